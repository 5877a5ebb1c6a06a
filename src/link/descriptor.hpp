// A file descriptor in the loop: says when it can be read or written. The reading and writing is the caller's.
#pragma once
#include <link/asio_fwd.hpp>
#include <link/unique_fd.hpp>

#include <cstdint>
#include <functional>
#include <memory>

namespace anogate {

/// Not to be destroyed by a call of its own.
class Descriptor {
public:
    explicit Descriptor(asio::io_context& io);
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor();

    /// Takes `fd`, which must be non-blocking. Nothing waits yet.
    void open(UniqueFd fd);
    bool is_open() const noexcept { return fd_ >= 0; }
    int fd() const noexcept { return fd_; }

    /// Calls `call` each time there is something to read, until stop_reading() or close(). It need not read all. Not from
    /// `call` itself; while it is reading already, nothing changes.
    void read_with(std::function<void()> call);
    void stop_reading() noexcept { reading_ = false; }

    /// Calls `call` once when it can be written; a second request before that changes nothing.
    void when_writable(std::function<void()> call);

    void close() noexcept;

private:
    void wait_readable();

    struct Stream;
    std::unique_ptr<Stream> stream_;
    std::function<void()> on_readable_;    // outlives close(), which it may call
    std::function<void()> on_writable_;
    std::uint64_t generation_ = 0;    // of open and close: an answer of an earlier one means nothing
    int fd_ = -1;
    bool reading_ = false;
    bool waits_readable_ = false;
    bool waits_writable_ = false;
};

}    // namespace anogate
