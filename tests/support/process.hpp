// The real program as a process, killed when its handle is destroyed, and its control socket.
#pragma once
#include "http.hpp"
#include "wait.hpp"

#include <nlohmann/json.hpp>

#include <sys/types.h>

#include <csignal>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace support {

class Process {
public:
    /// `program` is searched in PATH. `in_child` runs in the new process before the program.
    Process(
        const std::string& program, std::vector<std::string> arguments, const std::vector<std::string>& environment = {},
        const std::function<void()>& in_child = [] {});
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t pid() const { return pid_; }
    void signal(int number) const { ::kill(pid_, last_signal_ = number); }
    bool is_running();
    /// Its exit status, 128 + the signal that ended it, or -1 if it still runs after `limit`.
    int wait(std::chrono::steady_clock::duration limit = patience);
    /// Its output so far: standard output and error.
    const std::string& output();
    /// Its output since the last call of this function.
    std::string new_output();
    bool until_says(const std::string& words, std::chrono::steady_clock::duration limit = patience);
    /// Waits until it has printed the local address of its page, and returns the port; 0: it does not print it.
    std::uint16_t http_port();
    /// The number in a field of /proc/PID/status.
    long proc_status(const std::string& field) const;

private:
    void reap(int options);

    pid_t pid_ = -1;
    int output_fd_ = -1;
    mutable int last_signal_ = 0;
    std::string output_;
    std::size_t returned_ = 0;    // bytes of output_ that new_output() has returned
    std::optional<int> status_;
};

/// A command line of the shell; its end also ends all processes that it started.
class Shell : public Process {
public:
    explicit Shell(const std::string& command);
    ~Shell() { end(); }
    void end();
};

/// Runs a command line of the shell to its end. Returns its exit status; if it fails, its output is shown.
int run(const std::string& command);

/// An anogated with its own control socket.
class Daemon : public Process {
public:
    Daemon(
        const std::string& program, const std::string& socket, std::vector<std::string> arguments,
        const std::vector<std::string>& environment = {}, const std::function<void()>& in_child = [] {});

    /// Its status; a discarded value while it does not answer.
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
