// Directs the program's signals to the thread of the loop.
#pragma once
#include <csignal>

namespace anogate {

/// To be called first in every other thread: blocks all signals there, so that the loop handles them, or they stay pending while it
/// does not. That includes SIGTTOU, by which a terminal would stop a program that writes to it in the background.
inline void leave_signals_to_the_loop() noexcept {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
}

}    // namespace anogate
