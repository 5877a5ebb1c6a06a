#include "http.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

namespace support {

namespace {

template <class Address>
int connect_to(const Address& address, int family, const Address* from, std::chrono::seconds longest) {
    const int fd = ::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (from) ::bind(fd, reinterpret_cast<const sockaddr*>(from), sizeof *from);
    const timeval limit{longest.count(), 0};
    ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
    ::close(fd);
    return -1;
}

std::string ask(int fd, const std::string& request) {
    if (fd < 0) return {};
    std::string answer;
    if (::send(fd, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size()))
        answer = read_to_end(fd);
    ::close(fd);
    return answer;
}

}    // namespace

int connect_unix(const std::string& path, std::chrono::seconds limit) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    return connect_to<sockaddr_un>(address, AF_UNIX, nullptr, limit);
}

int connect_tcp(std::uint16_t port, const std::string& from) {
    sockaddr_in address{}, own{};
    address.sin_family = own.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::inet_pton(AF_INET, from.c_str(), &own.sin_addr);
    return connect_to(address, AF_INET, &own, std::chrono::seconds{30});
}

std::string read_to_end(int fd) {
    std::string text;
    char buffer[65536];
    for (ssize_t n; (n = ::read(fd, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
    return text;
}

std::string http(const std::string& socket, const std::string& request, std::chrono::seconds limit) {
    return ask(connect_unix(socket, limit), request);
}
std::string http(std::uint16_t port, const std::string& request, const std::string& from) {
    return ask(connect_tcp(port, from), request);
}

std::string body_of(const std::string& answer) {
    const auto end = answer.find("\r\n\r\n");
    return end == std::string::npos ? std::string{} : answer.substr(end + 4);
}

}    // namespace support
