// Sends an outbox as datagrams, many with one system call. One for the whole loop: it has no state between calls.
#pragma once
#include <gateway/outbox.hpp>
#include <link/pacing.hpp>
#include <link/raw_port.hpp>
#include <link/udp/ip_socket.hpp>

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <span>

namespace anogate {

enum class SendResult {
    done,         // the outbox is empty
    full,         // continue when the socket is writable
    no_memory,    // retry after no_memory_pause: the system does not report free memory
    paced,        // the rest waits; Pacing calls when more may be sent
    broken,       // the socket can't be used any more, see `error`
};

inline constexpr std::chrono::milliseconds no_memory_pause{5};

struct SendReport {
    SendResult result = SendResult::done;
    int error = 0;                // the last errno; 0: none
    std::uint64_t refused = 0;    // "connection refused" answers to earlier datagrams
};

class DatagramSender {
public:
    struct Path {
        int fd = -1;
        const SocketAddress* to = nullptr;    // nullptr: the connected peer
        std::size_t mtu = 0;                  // frames are packed into datagrams of at most this size; 0: one frame each
        // For sockets with an error queue: reads the reports about earlier datagrams and returns whether there were any.
        const std::function<bool()>* read_reports = nullptr;
        std::size_t max_bytes = SIZE_MAX;    // in total; the rest stays in the outbox
        RawTap* tap = nullptr;               // called for every frame sent
    };

    DatagramSender() : room_{new Buffers} {}
    /// Sends the waiting frames. Frames that can't be sent are counted in the outbox by cause.
    SendReport send_all(const Path& way, Outbox& outbox, Pacing& pacing, ano::TimePoint now);

private:
    static constexpr std::size_t max_datagrams = 64;
    static constexpr std::size_t max_frames = 512;
    struct Buffers {
        std::array<std::span<const std::uint8_t>, max_frames> frames;
        std::array<iovec, max_frames> pieces;
        std::array<mmsghdr, max_datagrams> messages;
        std::array<std::size_t, max_datagrams> frames_in;    // per datagram
    };

    unsigned fill(std::size_t frames, const SocketAddress* to, std::size_t mtu) noexcept;

    std::unique_ptr<Buffers> room_;
};

}    // namespace anogate
