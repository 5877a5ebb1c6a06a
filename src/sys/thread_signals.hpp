// Directs the program's signals to the thread of the loop.
#pragma once
#include <csignal>
#include <thread>
#include <utility>

namespace anogate {

/// Begins a thread that blocks all signals from its first moment, so that the loop handles them, or they stay pending while it does not. That
/// includes SIGTTOU, by which a terminal would stop a program that writes to it in the background. Throws as std::thread does.
template <class Run>
std::thread begin_thread(Run run) {
    class Blocked {
    public:
        Blocked() noexcept {
            sigset_t all;
            sigfillset(&all);
            ::pthread_sigmask(SIG_SETMASK, &all, &before_);
        }
        Blocked(const Blocked&) = delete;
        Blocked& operator=(const Blocked&) = delete;
        ~Blocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

    private:
        sigset_t before_{};
    };
    const Blocked blocked;    // what the new thread inherits
    return std::thread{std::move(run)};
}

}    // namespace anogate
