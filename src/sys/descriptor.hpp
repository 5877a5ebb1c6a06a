// A file descriptor in the loop: calls back when it can be read or written. The caller reads and writes.
#pragma once
#include <sys/asio_fwd.hpp>
#include <sys/unique_fd.hpp>

#include <cstdint>
#include <functional>
#include <memory>

namespace anogate {

/// Must not be destroyed from within its own callback.
class Descriptor {
public:
    explicit Descriptor(asio::io_context& io);
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor();

    /// Takes ownership of `fd`, which must be non-blocking. Makes no calls yet.
    void open(UniqueFd fd);
    bool is_open() const noexcept { return fd_ >= 0; }
    int fd() const noexcept { return fd_; }

    /// Calls `call` each time there is data to read, until stop_reading() or close(). `call` need not read everything and must
    /// not call read_with(). No effect while reading is already active.
    void read_with(std::function<void()> call);
    void stop_reading() noexcept { reading_ = false; }

    /// Calls `call` once when it can be written; a second request before that has no effect.
    void when_writable(std::function<void()> call);

    void close() noexcept;

private:
    void wait_readable();

    struct Stream;
    std::unique_ptr<Stream> stream_;
    std::function<void()> on_readable_;    // not destroyed by close(), which it may call
    std::function<void()> on_writable_;
    std::uint64_t generation_ = 0;    // counts open() and close(), to ignore callbacks of an earlier descriptor
    int fd_ = -1;
    bool reading_ = false;
    bool waits_readable_ = false;
    bool waits_writable_ = false;
};

}    // namespace anogate
