// The real program as a process, killed when its handle is destroyed, and the socket it answers on.
#pragma once
#include "wait.hpp"

#include <nlohmann/json.hpp>

#include <sys/types.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

namespace support {

/// A blocking connection to a Unix socket; -1 when nobody answers. A read ends after some seconds.
int connect_unix(const std::string& path);
std::string read_to_end(int fd);

/// One request on a connection of its own: the whole answer, empty when there is none.
std::string http(const std::string& socket, const std::string& request);
std::string body_of(const std::string& answer);

class Process {
public:
    Process(const std::string& program, std::vector<std::string> arguments, const std::vector<std::string>& environment = {});
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t pid() const { return pid_; }
    void signal(int number) const { ::kill(pid_, last_signal_ = number); }
    bool is_running();
    /// Its exit status, 128 + the signal that ended it, or -1 when it still runs after `limit`.
    int wait(std::chrono::steady_clock::duration limit = patience);
    /// What it has written so far, standard output and error.
    const std::string& output();
    bool until_says(const std::string& words, std::chrono::steady_clock::duration limit = patience);
    /// The number in a field of /proc/PID/status.
    long proc_status(const std::string& field) const;

private:
    void reap(int options);

    pid_t pid_ = -1;
    int output_fd_ = -1;
    mutable int last_signal_ = 0;
    std::string output_;
    std::optional<int> status_;
};

/// An anogated with a control socket of its own.
class Daemon : public Process {
public:
    Daemon(const std::string& program, const std::string& socket, std::vector<std::string> arguments,
           const std::vector<std::string>& environment = {});

    /// Null while it does not answer.
    nlohmann::json status() const;
    nlohmann::json link(const std::string& name) const;
    bool until(const std::function<bool(const nlohmann::json&)>& holds);
    bool until_answers();
    bool until_up(const std::string& name);
    std::uint64_t count(const std::string& name, const std::string& counter) const;
    std::uint16_t port(const std::string& name) const;

private:
    std::string socket_;
};

}    // namespace support
