// A device at the end of a real line, a pseudo-terminal or UDP, with configurable delay and loss.
#pragma once
#include <ano/parser.hpp>
#include <support/fake_device.hpp>
#include <support/fake_loader.hpp>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace bench {

/// In each direction a frame takes the time of its bytes at the rate of the line, then `delay`; or it is lost. Runs in its own
/// thread.
class DeviceLine {
public:
    enum class Wire { pty, udp };
    DeviceLine(Wire wire, support::LineFaults faults, std::size_t parameters);
    ~DeviceLine();
    DeviceLine(const DeviceLine&) = delete;
    DeviceLine& operator=(const DeviceLine&) = delete;

    /// With UDP.
    std::uint16_t port() const { return port_; }
    /// The LINK text for a gateway.
    std::string link() const { return link_; }
    /// Bytes of received frames and of answers so far.
    std::pair<std::uint64_t, std::uint64_t> bytes() const { return {there_.bytes, back_.bytes}; }

private:
    using Clock = std::chrono::steady_clock;
    struct Direction {
        Clock::time_point free_at{};
        std::atomic<std::uint64_t> bytes{0};
    };
    struct Event {
        bool to_device;
        support::Bytes frame;
    };

    void run();
    void read();
    void put(bool to_device, const support::Bytes& frame);
    void arrive(const Event& event);
    void send_hello();

    support::LineFaults faults_;
    support::FakeDevice fake_;
    support::FakeLoader loader_;
    support::Random random_{1};
    int fd_ = -1, other_end_ = -1;
    std::uint16_t port_ = 0;
    std::string link_;
    std::vector<std::uint8_t> sender_;    // with UDP: the destination of answers
    ano::FrameParser parser_{{}};
    Direction there_, back_;
    std::multimap<Clock::time_point, Event> events_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}    // namespace bench
