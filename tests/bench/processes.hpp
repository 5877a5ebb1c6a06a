// Processes under measurement: a function in a fork, or a program; their CPU time, memory and wake-ups.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bench {

/// A child process; ended by its destructor.
class Child {
public:
    /// Runs `body` in a fork, on the second processor where there is one.
    static Child of(const std::function<void()>& body);
    /// Runs a program the same way, its standard output and error to `log`.
    static Child of(const std::vector<std::string>& command, const std::string& log);
    Child(Child&& other) noexcept : pid_{other.pid_} { other.pid_ = -1; }
    Child& operator=(Child&&) = delete;
    ~Child();

    pid_t pid() const noexcept { return pid_; }
    double cpu_seconds() const;
    std::uint64_t wake_ups() const;    // voluntary context switches so far
    std::uint64_t resident_bytes() const;
    std::uint64_t max_resident_bytes() const;    // at any time so far
    /// Waits until it ends by itself. Its exit status; -1 when a signal ended it.
    int wait();

private:
    explicit Child(pid_t pid) : pid_{pid} {}
    pid_t pid_;
};

/// The measuring process and its threads stay on the first processor.
void stay_on_first_processor();

/// While it lives, its thread has real-time priority, where the system permits that; processes and threads that are started
/// meanwhile keep it. So other load on the machine does not affect the measurement.
class Undisturbed {
public:
    Undisturbed();
    ~Undisturbed();
    Undisturbed(const Undisturbed&) = delete;
    Undisturbed& operator=(const Undisturbed&) = delete;
};

/// A counter in shared memory, for a fork to count and its parent to read.
std::uint64_t* shared_word();

}    // namespace bench
