// Does systemd's part for a service: receives its notifications, stores its descriptors, and passes them to its next start.
#pragma once
#include "process.hpp"

#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace support {

class ServiceManager {
public:
    explicit ServiceManager(std::string path)
        : path_{std::move(path)}, socket_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
    }

    /// Starts the service with the stored descriptors; `environment` is added to its environment.
    std::unique_ptr<Daemon> start(const std::string& program, const std::string& control, std::vector<std::string> arguments,
                                  std::vector<std::string> environment = {}) {
        receive();
        std::string names;
        for (const auto& [name, fd] : stored_) names += (names.empty() ? "" : ":") + name;
        environment.insert(environment.end(), {"NOTIFY_SOCKET=" + path_, "LISTEN_FDS=" + std::to_string(stored_.size()),
                                               "LISTEN_FDNAMES=" + names, "LISTEN_PID=0"});
        return std::make_unique<Daemon>(program, control, std::move(arguments), environment, [this] { pass(); });
    }
    /// Stops the service like `systemctl restart`, and receives the descriptors that it leaves. Returns its exit status.
    int stop(Daemon& service) {
        service.signal(SIGTERM);
        const bool ended = wait_until([&] {
            receive();
            return !service.is_running();
        });
        receive();
        return ended ? service.wait() : -1;
    }
    /// The stored descriptors by name.
    std::multimap<std::string, anogate::UniqueFd>& stored() {
        receive();
        return stored_;
    }
    void forget() { stored_.clear(); }

private:
    // Runs in the new process: places the descriptors from 3 on, in the order of the names.
    void pass() const {
        std::vector<int> high;
        for (const auto& [name, fd] : stored_) high.push_back(::fcntl(fd.get(), F_DUPFD, 200));
        for (std::size_t i = 0; i < high.size(); ++i) {
            ::dup2(high[i], 3 + static_cast<int>(i));
            ::close(high[i]);
        }
        ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
    }

    void receive() {
        std::array<char, 4096> text{};
        alignas(cmsghdr) std::array<char, CMSG_SPACE(253 * sizeof(int))> control{};
        for (;;) {
            iovec piece{text.data(), text.size()};
            msghdr message{};
            message.msg_iov = &piece;
            message.msg_iovlen = 1;
            message.msg_control = control.data();
            message.msg_controllen = control.size();
            const ssize_t n = ::recvmsg(socket_.get(), &message, MSG_CMSG_CLOEXEC);
            if (n <= 0) return;
            std::vector<anogate::UniqueFd> descriptors;
            if (const cmsghdr* passed = CMSG_FIRSTHDR(&message))
                for (std::size_t i = 0; i < (passed->cmsg_len - CMSG_LEN(0)) / sizeof(int); ++i) {
                    int number = -1;
                    std::memcpy(&number, CMSG_DATA(passed) + i * sizeof number, sizeof number);
                    descriptors.emplace_back(number);
                }
            take(std::string{text.data(), static_cast<std::size_t>(n)}, std::move(descriptors));
        }
    }
    // BARRIER=1 is answered by closing the descriptors received with it.
    void take(const std::string& message, std::vector<anogate::UniqueFd> descriptors) {
        const std::string field = "FDNAME=";
        const std::size_t at = message.find(field);
        const std::string name = at == message.npos ? "" : message.substr(at + field.size());
        if (message.starts_with("FDSTORE=1"))
            for (anogate::UniqueFd& fd : descriptors) stored_.emplace(name, std::move(fd));
        else if (message.starts_with("FDSTOREREMOVE=1")) stored_.erase(name);
    }

    std::string path_;
    anogate::UniqueFd socket_;
    std::multimap<std::string, anogate::UniqueFd> stored_;
};

}    // namespace support
