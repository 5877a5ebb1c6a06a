// Which thread the program's signals come to.
#pragma once
#include <csignal>

namespace anogate {

/// Called first in every other thread than the loop's, which handles them: as long as it does not yet, or does no more, they wait.
/// SIGTTOU is among them, so that a terminal does not stop the program for writing to it in the background.
inline void leave_signals_to_the_loop() noexcept {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
}

}    // namespace anogate
