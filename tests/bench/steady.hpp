// The same steady traffic for two gateways, one of which has additional work.
#pragma once
#include "forwarder.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace bench {

/// The number of frames sent together, and the interval; one frame per datagram.
struct Rate {
    std::chrono::microseconds spacing;
    int frames_at_once;
};
inline constexpr Rate fifty_thousand{std::chrono::microseconds{200}, 10};    // a second
inline constexpr Rate one_thousand{std::chrono::milliseconds{1}, 1};

/// Offers frames to two gateways at the same steady rate until it is destroyed, so that other load on the machine affects both.
class Steady {
public:
    Steady(std::uint16_t first, std::uint16_t second, Rate rate = fifty_thousand) {
        sockets_[0].connect(first);
        sockets_[1].connect(second);
        thread_ = std::thread{[this, rate] {
            const std::vector<std::uint8_t> datagram = frame(0x30, target, 0);
            std::size_t turn = 0;
            for (auto next = std::chrono::steady_clock::now(); !stop_; std::this_thread::sleep_until(next += rate.spacing)) {
                ++turn;    // so that neither is always the first to be woken
                for (std::size_t one = 0; one < sockets_.size(); ++one)
                    for (int i = 0; i < rate.frames_at_once; ++i) sockets_[(turn + one) % sockets_.size()].send(datagram);
            }
        }};
    }
    ~Steady() {
        stop_ = true;
        thread_.join();
    }
    Steady(const Steady&) = delete;
    Steady& operator=(const Steady&) = delete;

private:
    std::array<Socket, 2> sockets_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}    // namespace bench
