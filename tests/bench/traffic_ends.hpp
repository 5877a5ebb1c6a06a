// Sender and receiver of the traffic, and the bare loops that anogated is compared with.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace bench {

inline constexpr std::size_t frame_size = 21;

/// Ends the program with `what` and errno's text if `good` is false.
void must(bool good, const char* what);

/// A frame of frame_size bytes from `source` to `destination`; its DATA is made from `number`.
std::vector<std::uint8_t> frame(std::uint8_t source, std::uint8_t destination, std::uint64_t number, std::uint8_t id = 0xF1);

/// A UDP socket on loopback, at a port chosen by the kernel.
class Socket {
public:
    Socket();
    ~Socket();
    Socket(const Socket&) = delete;
    Socket& operator=(const Socket&) = delete;
    int fd() const noexcept { return fd_; }
    std::uint16_t port() const noexcept { return port_; }
    std::string text() const { return "127.0.0.1:" + std::to_string(port_); }
    void connect(std::uint16_t port);
    /// To the peer that it is connected to.
    void send(std::span<const std::uint8_t> bytes) const;
    /// Receives datagrams up to the one that equals `bytes`; false: it did not arrive in time. Polls without a pause, so that
    /// only the path of the sender is measured.
    bool wait_for(std::span<const std::uint8_t> bytes, std::chrono::milliseconds patience) const;

private:
    int fd_;
    std::uint16_t port_;
};

/// Receives and counts the datagrams of some sockets in its own thread, several times a millisecond.
class Sink {
public:
    explicit Sink(std::vector<int> fds);
    ~Sink();
    std::uint64_t bytes() const noexcept { return bytes_; }

private:
    std::vector<int> fds_;
    std::atomic<std::uint64_t> bytes_{0};
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

/// Offers frames, one per datagram, as fast as possible, until it is destroyed.
class Flood {
public:
    Flood(std::uint16_t port, std::uint8_t destination);
    ~Flood();

private:
    Socket socket_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

/// The loop that anogated is compared with: reads datagrams in batches from `in` and sends each to every one of `out`; if `pack`
/// is not 0, joined into datagrams of up to `pack` bytes. Neither parses nor routes. Counts sent frames; never returns.
[[noreturn]] void bare_loop(int in, const std::vector<int>& out, std::size_t pack, std::uint64_t* frames);

}    // namespace bench
