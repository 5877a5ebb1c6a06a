// Writes a byte stream to a HID device as reports, without blocking the caller.
#pragma once
#include <sys/descriptor.hpp>
#include <sys/expected.hpp>

#include <sys/types.h>
#include <sys/uio.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace anogate {

/// A write to a hidraw device blocks until the device takes the report, 5 s at most, also with O_NONBLOCK. So a thread writes, and
/// receives the stream by a socket. The thread ends with the socket: soon after close(), or when the device is unplugged.
class HidWriter {
public:
    explicit HidWriter(asio::io_context& io);

    /// Writes to a copy of `device`, in reports of `report_size` bytes (2 to hid::max_report). Returns why it is not possible.
    Expected<void> open(int device, std::size_t report_size);
    void close() noexcept { stream_.close(); }

    /// As writev() of a non-blocking socket. EPIPE: the device was unplugged.
    ssize_t write_some(std::span<const iovec> pieces);
    /// Calls `call` once when write_some() accepts bytes again.
    void when_writable(std::function<void()> call) { stream_.when_writable(std::move(call)); }
    /// Whether bytes wait for the thread.
    bool has_unsent() const noexcept;
    /// Reports that the device did not take, since the start.
    std::uint64_t failed_reports() const noexcept { return *failed_reports_; }

private:
    Descriptor stream_;
    std::shared_ptr<std::atomic<std::uint64_t>> failed_reports_ = std::make_shared<std::atomic<std::uint64_t>>(0);
};

}    // namespace anogate
