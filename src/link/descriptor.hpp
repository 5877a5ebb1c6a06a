// A file descriptor in the loop: says when it can be read or written. The reading and writing is the caller's.
#pragma once
#include <link/asio.hpp>

#include <unistd.h>
#include <functional>

namespace anogate {

/// Owns a descriptor until it goes to somebody else or out of scope.
class UniqueFd {
public:
    UniqueFd() = default;
    explicit UniqueFd(int fd) noexcept : fd_{fd} {}
    UniqueFd(UniqueFd&& other) noexcept : fd_{other.release()} {}
    UniqueFd& operator=(UniqueFd&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~UniqueFd() {
        if (fd_ >= 0) ::close(fd_);
    }
    int get() const noexcept { return fd_; }
    int release() noexcept { return std::exchange(fd_, -1); }
    explicit operator bool() const noexcept { return fd_ >= 0; }

private:
    int fd_ = -1;
};

class Descriptor {
public:
    explicit Descriptor(asio::io_context& io) : stream_{io} {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() { close(); }

    /// Takes `fd`, which must be non-blocking. Nothing waits yet.
    void open(UniqueFd fd) {
        stream_.assign(fd.get());
        fd_ = fd.release();
        ++generation_;
    }
    bool is_open() const noexcept { return stream_.is_open(); }
    int fd() const noexcept { return fd_; }

    /// Calls `call` each time there is something to read, until stop_reading() or close(). It need not read all. Not from
    /// `call` itself; while it is reading already, nothing changes.
    void read_with(std::function<void()> call) {
        if (reading_) return;
        on_readable_ = std::move(call);
        reading_ = true;
        if (!waits_readable_) wait_readable();
    }
    void stop_reading() noexcept { reading_ = false; }

    /// Calls `call` once when it can be written; a second request before that changes nothing.
    void when_writable(std::function<void()> call) {
        if (waits_writable_) return;
        waits_writable_ = true;
        stream_.async_wait(stream_.wait_write, [this, mine = generation_, call = std::move(call)](error_code ec) {
            if (ec || mine != generation_) return;
            waits_writable_ = false;
            call();
        });
    }

    void close() noexcept {
        ++generation_;
        reading_ = false;
        waits_readable_ = waits_writable_ = false;
        error_code ignored;
        if (stream_.is_open()) stream_.close(ignored);
        fd_ = -1;
    }

private:
    void wait_readable() {
        waits_readable_ = true;
        stream_.async_wait(stream_.wait_read, [this, mine = generation_](error_code ec) {
            if (ec || mine != generation_) return;
            waits_readable_ = false;
            if (!reading_) return;
            on_readable_();
            if (mine == generation_ && reading_) wait_readable();
        });
    }

    asio::posix::stream_descriptor stream_;
    std::function<void()> on_readable_;    // outlives close(), which it may call
    bool reading_ = false;
    std::uint64_t generation_ = 0;    // of open and close: an answer of an earlier one means nothing
    int fd_ = -1;
    bool waits_readable_ = false;
    bool waits_writable_ = false;
};

}    // namespace anogate
