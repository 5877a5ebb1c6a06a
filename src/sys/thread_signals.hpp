// Directs the program's signals to the thread of the loop.
#pragma once
#include <csignal>
#include <thread>
#include <utility>

namespace anogate {

/// Begins a thread that blocks all signals from its start, so that the loop handles them, or they stay pending until it does.
/// This includes SIGTTOU, with which a terminal would stop a background program that writes to it. Throws as std::thread does.
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
    const Blocked blocked;    // inherited by the new thread
    return std::thread{std::move(run)};
}

}    // namespace anogate
