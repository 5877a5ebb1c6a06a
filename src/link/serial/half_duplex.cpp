#include <link/serial/half_duplex.hpp>
#include <link/serial/termios.hpp>
#include <sys/errors.hpp>
#include <sys/thread_signals.hpp>

#include <sys/eventfd.h>

#include <algorithm>

namespace anogate {

Expected<void> HalfDuplex::open(int port, ano::Duration byte_time) {
    UniqueFd event{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    if (!event) return Unexpected{error_text(errno)};
    closing_ = false;
    waiting_ = again_ = false;
    try {
        thread_ = begin_thread([this, port, byte_time, wake = event.get()] {
            for (;;) {
                wait_.acquire();
                if (closing_) return;
                terminal::wait_until_sent(port, byte_time, closing_);
                ::eventfd_write(wake, 1);
            }
        });
    } catch (const std::system_error& e) {
        return Unexpected{"can't start a thread for RS-485 direction control: " + error_text(e.code().value())};
    }
    sent_.open(std::move(event));
    sent_.read_with([this] { all_sent(); });
    return {};
}

void HalfDuplex::close() noexcept {
    if (thread_.joinable()) {
        closing_ = true;
        wait_.release();
        thread_.join();
        while (wait_.try_acquire()) {}
    }
    sent_.close();
    if (std::exchange(sending_, false)) send_(false);
}

void HalfDuplex::writing() {
    if (sending_) return;
    sending_ = true;
    send_(true);
}

void HalfDuplex::written() {
    again_ = waiting_;
    if (waiting_) return;
    waiting_ = true;
    wait_.release();
}

void HalfDuplex::all_sent() {
    eventfd_t count = 0;
    if (::eventfd_read(sent_.fd(), &count) != 0) return;
    waiting_ = false;
    if (std::exchange(again_, false)) return written();
    sending_ = false;
    send_(false);
}

}    // namespace anogate
