#include "process.hpp"
#include "sanitized.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

namespace support {

Process::Process(const std::string& program, std::vector<std::string> arguments, const std::vector<std::string>& environment,
                 const std::function<void()>& in_child) {
    int pipe[2];
    if (::pipe2(pipe, O_CLOEXEC) != 0) std::abort();
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ < 0) std::abort();    // a signal to -1 would reach all processes
    if (pid_ == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        ::signal(SIGPIPE, SIG_DFL);
        ::dup2(pipe[1], STDERR_FILENO);
        ::dup2(pipe[1], STDOUT_FILENO);
        for (const std::string& e : environment) ::putenv(const_cast<char*>(e.c_str()));
        in_child();
        ::execvp(program.c_str(), argv.data());
        ::_exit(127);
    }
    ::close(pipe[1]);
    ::fcntl(pipe[0], F_SETFL, O_NONBLOCK);
    output_fd_ = pipe[0];
}
Process::~Process() {
    if (!status_) {
        signal(SIGKILL);
        reap(0);
    }
    ::close(output_fd_);
}

bool Process::is_running() {
    reap(WNOHANG);
    return !status_;
}
int Process::wait(std::chrono::steady_clock::duration limit) {
    // ThreadSanitizer of clang 14 sometimes takes a signal from the kernel and never delivers it.
    auto again = std::chrono::steady_clock::now();
    wait_until(
        [&] {
            const auto now = std::chrono::steady_clock::now();
            if (thread_sanitized && last_signal_ == SIGTERM && now - again > std::chrono::seconds{1}) {
                again = now;
                ::kill(pid_, SIGTERM);
            }
            output();    // it may be blocked until its output is read
            return !is_running();
        },
        limit);
    output();
    return status_.value_or(-1);
}
const std::string& Process::output() {
    char buffer[4096];
    for (ssize_t n; (n = ::read(output_fd_, buffer, sizeof buffer)) > 0;) output_.append(buffer, static_cast<std::size_t>(n));
    return output_;
}
std::string Process::new_output() {
    const std::size_t before = returned_;
    returned_ = output().size();
    return output_.substr(before);
}
bool Process::until_says(const std::string& words, std::chrono::steady_clock::duration limit) {
    return wait_until([&] { return output().find(words) != std::string::npos || !is_running(); }, limit) &&
           output().find(words) != std::string::npos;
}
std::uint16_t Process::http_port() {
    const std::string before = "http://127.0.0.1:";
    if (!until_says(before)) return 0;
    return static_cast<std::uint16_t>(std::stoi(output().substr(output().rfind(before) + before.size())));
}
long Process::proc_status(const std::string& field) const {
    std::ifstream file{"/proc/" + std::to_string(pid_) + "/status"};
    for (std::string line; std::getline(file, line);)
        if (line.starts_with(field + ":")) return std::stol(line.substr(field.size() + 1));
    return -1;
}

void Process::reap(int options) {
    int status = 0;
    if (status_ || ::waitpid(pid_, &status, options) != pid_) return;
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Shell::Shell(const std::string& command) : Process{"/bin/sh", {"-c", command}, {}, [] { ::setpgid(0, 0); }} {}
void Shell::end() {
    if (!is_running()) return;
    if (::kill(-pid(), SIGKILL) != 0) signal(SIGKILL);    // it has no process group yet
    wait();
}

int run(const std::string& command) {
    Shell shell{command};
    const int status = shell.wait(std::chrono::minutes{5});
    if (status != 0) std::cerr << shell.output();
    return status;
}

namespace {

std::vector<std::string> with_control(const std::string& socket, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--control", socket});
    return arguments;
}

// A separate state folder, so that it does not read the state of other tests.
std::vector<std::string> with_state(const std::string& socket, std::vector<std::string> environment) {
    environment.insert(environment.begin(), "STATE_DIRECTORY=" + socket + ".state");
    return environment;
}

}    // namespace

Daemon::Daemon(const std::string& program, const std::string& socket, std::vector<std::string> arguments,
               const std::vector<std::string>& environment, const std::function<void()>& in_child)
    : Process{program, with_control(socket, std::move(arguments)), with_state(socket, environment), in_child}, socket_{socket} {}

nlohmann::json Daemon::status() const {
    return nlohmann::json::parse(body_of(http(socket_, "GET /status HTTP/1.0\r\n\r\n")), nullptr, false);
}
nlohmann::json Daemon::link(const std::string& name) const {
    const auto now = status();
    if (now.contains("links"))    // otherwise the server is full, or the gateway does not run
        for (const auto& link : now.at("links"))
            if (link.at("name") == name) return link;
    return {{"state", "no answer"}};
}
bool Daemon::until(const std::function<bool(const nlohmann::json&)>& holds) {
    return wait_until([&] {
        const auto now = status();
        return now.is_object() && holds(now);
    });
}
bool Daemon::until_answers() {
    return until([](const auto&) { return true; });
}
bool Daemon::until_up(const std::string& name) {
    return wait_until([&] { return link(name).at("state") == "up"; });
}
std::uint64_t Daemon::count(const std::string& name, const std::string& counter) const { return link(name).value(counter, 0u); }
std::uint16_t Daemon::port(const std::string& name) const { return link(name).at("port"); }

}    // namespace support
