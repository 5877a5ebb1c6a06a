// Other programs beside the test: started, read, ended with it.
#pragma once
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <string>

namespace support {

/// A shell command line; its standard output can be read. Ends with the object, or with the test.
class Process {
public:
    explicit Process(const std::string& command) {
        int ends[2];
        if (::pipe(ends) != 0) return;
        pid_ = ::fork();
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGKILL);
            ::setpgid(0, 0);
            ::dup2(ends[1], STDOUT_FILENO);
            ::close(ends[0]);
            ::close(ends[1]);
            ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
            ::_exit(127);
        }
        ::close(ends[1]);
        out_ = ends[0];
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
        end(SIGKILL);
        ::close(out_);
    }

    /// What it has written since the last call; does not wait.
    std::string read() {
        std::string text;
        char part[4096];
        pollfd ready{out_, POLLIN, 0};
        while (::poll(&ready, 1, 0) > 0) {
            const ssize_t n = ::read(out_, part, sizeof part);
            if (n <= 0) break;
            text.append(part, static_cast<std::size_t>(n));
        }
        return text;
    }
    bool ended() {
        if (pid_ <= 0) return true;
        if (::waitpid(pid_, &status_, WNOHANG) != pid_) return false;
        pid_ = 0;
        return true;
    }
    void end(int signal) {
        if (pid_ <= 0) return;
        ::kill(-pid_, signal);
        ::waitpid(pid_, &status_, 0);
        pid_ = 0;
    }
    pid_t pid() const { return pid_; }
    int status() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128; }

private:
    pid_t pid_ = -1;
    int out_ = -1;
    int status_ = 0;
};

/// Runs a shell command line to its end; its exit status.
inline int run(const std::string& command) {
    Process process{command};
    while (!process.ended()) {
        process.read();
        ::usleep(1000);
    }
    return process.status();
}

}    // namespace support
