#include "talking_ptys.hpp"

#include "traffic_ends.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr std::size_t frames_of_a_stream = 400;
constexpr std::size_t max_a_write = 4000;    // a pseudo-terminal stores a little more

}    // namespace

TalkingPtys::TalkingPtys(std::size_t count, std::uint8_t destination, std::size_t rate) : rate_{rate} {
    for (std::size_t i = 0; i < count; ++i) {
        Device device{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC), -1, {}, static_cast<std::uint8_t>(0x43 + i)};
        must(device.fd >= 0 && ::grantpt(device.fd) == 0 && ::unlockpt(device.fd) == 0, "a pseudo-terminal");
        device.path = ::ptsname(device.fd);
        device.other_end = ::open(device.path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
        termios raw{};
        ::cfmakeraw(&raw);
        ::tcsetattr(device.other_end, TCSANOW, &raw);
        streams_.emplace_back();
        for (std::uint64_t n = 0; n < frames_of_a_stream; ++n) {
            const auto one = frame(device.address, destination, n);
            streams_.back().insert(streams_.back().end(), one.begin(), one.end());
        }
        devices_.push_back(device);
    }
}

TalkingPtys::~TalkingPtys() {
    if (thread_.joinable()) stop();
    for (const Device& device : devices_) {
        ::close(device.other_end);
        ::close(device.fd);
    }
}

void TalkingPtys::start() {
    stop_ = false;
    thread_ = std::thread{[this] { rate_ > 0 ? talk_at_a_rate() : talk(); }};
}

void TalkingPtys::stop() {
    stop_ = true;
    thread_.join();
    for (Device& device : devices_) {
        const std::uint64_t whole = (device.bytes + frame_size - 1) / frame_size * frame_size;
        for (int i = 0; i < 1000 && device.bytes < whole; ++i) {
            send(device, whole);
            if (device.bytes < whole) ::usleep(1000);
        }
    }
}

std::uint64_t TalkingPtys::frames() const noexcept {
    std::uint64_t bytes = 0;
    for (const Device& device : devices_) bytes += device.bytes;
    return bytes / frame_size;
}

void TalkingPtys::talk() {
    std::vector<pollfd> room;
    for (const Device& device : devices_) room.push_back({device.fd, POLLOUT, 0});
    while (!stop_) {
        ::poll(room.data(), room.size(), 10);
        for (Device& device : devices_) send(device, device.bytes + max_a_write);
    }
}

void TalkingPtys::talk_at_a_rate() {
    const auto begin = steady_clock::now();
    std::vector<std::uint64_t> sent_before;
    for (const Device& device : devices_) sent_before.push_back(device.bytes);
    for (auto now = begin; !stop_; now += 1ms) {
        std::this_thread::sleep_until(now);
        const auto elapsed = std::chrono::duration<double>(steady_clock::now() - begin).count();
        const auto due = static_cast<std::uint64_t>(elapsed * static_cast<double>(rate_));
        for (std::size_t i = 0; i < devices_.size(); ++i) send(devices_[i], sent_before[i] + due);
    }
}

// Sends as much as is accepted now.
void TalkingPtys::send(Device& device, std::uint64_t until) {
    const std::vector<std::uint8_t>& stream = streams_[static_cast<std::size_t>(device.address - 0x43)];
    while (device.bytes < until) {
        const std::size_t at = device.bytes % stream.size();
        const std::size_t size = std::min({static_cast<std::size_t>(until - device.bytes), stream.size() - at, max_a_write});
        const ssize_t n = ::write(device.fd, stream.data() + at, size);
        if (n <= 0) return;
        device.bytes += static_cast<std::uint64_t>(n);
    }
}

}    // namespace bench
