// A connection between two programs. Its delay may differ by direction, and it can fail without notice.
#pragma once
#include "udp_peer.hpp"

#include <chrono>
#include <deque>

namespace support {

/// Two UDP sockets. Datagrams received on one are sent from the other, `delay` later, to the address that last sent to it. The
/// test drives it by pump().
class Relay {
public:
    using Clock = std::chrono::steady_clock;

    Relay(Clock::duration from_a, Clock::duration from_b) : sides_{Side{from_a}, Side{from_b}} {}

    /// The addresses to which the two programs must send.
    std::string a() const { return sides_[0].socket.local().text(); }
    std::string b() const { return sides_[1].socket.local().text(); }

    /// From now on nothing passes, and datagrams in transit are lost, without any error.
    void fail() {
        failing_ = true;
        for (Side& side : sides_) side.on_the_way.clear();
    }
    void pump() {
        for (std::size_t i : {0u, 1u}) {
            Side& from = sides_[i];
            Side& to = sides_[1 - i];
            for (Bytes& datagram : from.socket.datagrams()) {
                from.sender = from.socket.last_sender();
                carried_ += split(datagram).frames.size();
                if (!failing_) from.on_the_way.push_back({Clock::now() + from.delay, std::move(datagram)});
            }
            for (; !from.on_the_way.empty() && from.on_the_way.front().due <= Clock::now(); from.on_the_way.pop_front())
                if (to.sender.port != 0) to.socket.send(to.sender, from.on_the_way.front().bytes);
        }
    }
    bool idle() const { return sides_[0].on_the_way.empty() && sides_[1].on_the_way.empty(); }
    /// Frames received from both sides.
    std::size_t carried() const { return carried_; }

private:
    struct Datagram {
        Clock::time_point due;
        Bytes bytes;
    };
    struct Side {
        explicit Side(Clock::duration d) : delay{d} {}
        Clock::duration delay;
        UdpPeer socket{};
        anogate::Endpoint sender{};
        std::deque<Datagram> on_the_way{};
    };
    Side sides_[2];
    std::size_t carried_ = 0;
    bool failing_ = false;
};

}    // namespace support
