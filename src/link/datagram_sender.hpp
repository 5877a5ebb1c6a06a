// Sends an outbox as datagrams, many with one system call. One for the whole loop: it holds nothing between two calls.
#pragma once
#include <gateway/outbox.hpp>
#include <link/ip_socket.hpp>
#include <link/pacing.hpp>

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <span>

namespace anogate {

enum class SendResult {
    done,         // nothing waits
    full,         // go on when the socket is writable
    no_memory,    // go on after no_memory_pause: the system says so without saying when
    paced,        // the rest waits for its time; the pacing calls
    broken,       // the socket is of no use any more; `error` says why
};

inline constexpr std::chrono::milliseconds no_memory_pause{5};

struct SendReport {
    SendResult result = SendResult::done;
    int error = 0;                // the last errno; 0: none
    std::uint64_t refused = 0;    // "connection refused" answers to earlier datagrams
};

class DatagramSender {
public:
    struct Way {
        int fd = -1;
        const SocketAddress* to = nullptr;    // nullptr: the connected peer
        std::size_t mtu = 0;                  // frames that wait share a datagram of so many bytes; 0: each has its own
        // Where the socket keeps what the network says of earlier datagrams: takes it, and says whether there was any.
        const std::function<bool()>* take_reports = nullptr;
        std::size_t max_bytes = SIZE_MAX;    // in all; what is above them stays
    };

    DatagramSender() : room_{new Room} {}
    /// Sends what waits. Frames that can't go are counted in the outbox by cause.
    SendReport send_all(const Way& way, Outbox& outbox, Pacing& pacing, ano::TimePoint now);

private:
    static constexpr std::size_t max_datagrams = 64;
    static constexpr std::size_t max_frames = 512;
    struct Room {
        std::array<std::span<const std::uint8_t>, max_frames> frames;
        std::array<iovec, max_frames> pieces;
        std::array<mmsghdr, max_datagrams> messages;
        std::array<std::size_t, max_datagrams> frames_in;    // each of them
    };

    unsigned fill(std::size_t frames, const SocketAddress* to, std::size_t mtu) noexcept;

    std::unique_ptr<Room> room_;
};

}    // namespace anogate
