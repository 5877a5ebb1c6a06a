#include "slow_line.hpp"

#include "traffic_ends.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>

namespace bench {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

SlowLine::SlowLine(double rate, std::function<void(ano::FrameView)> on_frame)
    : rate_{rate}, on_frame_{std::move(on_frame)}, fd_{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)} {
    must(fd_ >= 0 && ::grantpt(fd_) == 0 && ::unlockpt(fd_) == 0, "a pseudo-terminal");
    path_ = ::ptsname(fd_);
    other_end_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios raw{};
    ::cfmakeraw(&raw);
    ::tcsetattr(other_end_, TCSANOW, &raw);
    thread_ = std::thread{[this] { run(); }};
}

SlowLine::~SlowLine() {
    stop_ = true;
    thread_.join();
    ::close(other_end_);
    ::close(fd_);
}

// Time without a byte to send is lost: a line does not catch up.
void SlowLine::run() {
    const auto begin = steady_clock::now();
    double missed = 0;
    const auto possible = [&] { return std::chrono::duration<double>(steady_clock::now() - begin).count() * rate_; };
    for (auto next = begin; !stop_; next = std::max(next + 500us, steady_clock::now())) {
        std::this_thread::sleep_until(next);
        const double so_far = possible();
        possible_ = static_cast<std::uint64_t>(so_far);
        const double due = so_far - missed - static_cast<double>(carried_);
        int there = 0;
        ::ioctl(fd_, FIONREAD, &there);
        const double also_due = possible() - so_far;    // if we were delayed, more bytes arrived, and more would have left
        max_waiting_ = std::max(max_waiting_.load(), there - due - also_due);
        const std::size_t wanted = static_cast<std::size_t>(std::max(due, 0.0));
        const std::size_t taken = std::min(wanted, static_cast<std::size_t>(there));
        if (taken < wanted) missed += due - static_cast<double>(taken);
        take(taken);
    }
}

void SlowLine::take(std::size_t bytes) {
    while (bytes > 0) {
        const auto room = parser_.prepare();
        const ssize_t n = ::read(fd_, room.data(), std::min(room.size(), bytes));
        must(n > 0, "read from the line");
        parser_.commit(static_cast<std::size_t>(n), {});
        carried_ += static_cast<std::uint64_t>(n);
        bytes -= static_cast<std::size_t>(n);
        while (const auto frame = parser_.next()) on_frame_(*frame);
    }
    damaged_ = parser_.counters().skipped_bytes;
}

}    // namespace bench
