// The same steady traffic for two gateways, of which one has more to do.
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

/// Offers frames to two gateways at the same steady rate until it is destroyed: what else the machine does meets both.
class Steady {
public:
    Steady(std::uint16_t first, std::uint16_t second) {
        sockets_[0].connect(first);
        sockets_[1].connect(second);
        thread_ = std::thread{[this] {
            using namespace std::chrono_literals;
            constexpr auto spacing = 200us;
            constexpr int frames_at_once = 10;    // each `spacing`: 50,000 a second
            const std::vector<std::uint8_t> datagram = frame(0x30, target, 0);
            std::size_t turn = 0;
            for (auto next = std::chrono::steady_clock::now(); !stop_; std::this_thread::sleep_until(next += spacing)) {
                ++turn;    // neither is always the first to be woken
                for (std::size_t one = 0; one < sockets_.size(); ++one)
                    for (int i = 0; i < frames_at_once; ++i) sockets_[(turn + one) % sockets_.size()].send(datagram);
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
