#include "gateway_process.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace bench {
namespace {

std::string made_folder() {
    char name[] = "/tmp/anogate-bench-XXXXXX";
    if (!::mkdtemp(name)) throw std::runtime_error("no folder in /tmp");
    return name;
}

std::vector<std::string> command(const std::string& program, const std::string& folder, const std::vector<std::string>& arguments,
                                 std::vector<std::string> words) {
    words.push_back(program);
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), {"--control", folder + "/control", "--log-level", "error"});
    return words;
}

// One GET; empty when nobody listens.
std::string get(const std::string& socket, const std::string& path) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket.copy(address.sun_path, sizeof address.sun_path - 1);
    std::string answer;
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
        if (::write(fd, request.data(), request.size()) < 0) answer.clear();
        char buffer[65536];
        for (ssize_t n; (n = ::read(fd, buffer, sizeof buffer)) > 0;) answer.append(buffer, static_cast<std::size_t>(n));
    }
    ::close(fd);
    const auto body = answer.find("\r\n\r\n");
    return body == std::string::npos ? std::string{} : answer.substr(body + 4);
}

}    // namespace

GatewayProcess::GatewayProcess(const std::string& program, const std::vector<std::string>& arguments,
                               const std::vector<std::string>& tracer)
    : folder_{made_folder()}, child_{Child::of(command(program, folder_.path, arguments, tracer), folder_.path + "/log")} {
    for (int i = 0; i < 500; ++i) {
        if (!get(folder_.path + "/control", "/status").empty()) return;
        ::usleep(10000);
    }
    std::ostringstream log;
    log << program << " does not start. " << std::ifstream{folder_.path + "/log"}.rdbuf();
    throw std::runtime_error(log.str());
}

GatewayProcess::Folder::~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
}

nlohmann::json GatewayProcess::status() const { return nlohmann::json::parse(get(folder_.path + "/control", "/status")); }

nlohmann::json GatewayProcess::link(const std::string& name) const {
    const nlohmann::json now = status();
    for (const auto& link : now.at("links"))
        if (link.at("name") == name) return link;
    throw std::runtime_error("no link " + name);
}

}    // namespace bench
