// Turns an RS-485 transceiver to sending before a write and back when the last bit is out. The waiting for that is done in a
// thread of its own; all else, the line included, in the loop.
#pragma once
#include <ano/time.hpp>
#include <link/descriptor.hpp>
#include <link/expected.hpp>

#include <atomic>
#include <functional>
#include <semaphore>
#include <thread>

namespace anogate {

class HalfDuplex {
public:
    /// `send(true)`: the transceiver is to send now; `send(false)`: to listen.
    HalfDuplex(asio::io_context& io, std::function<void(bool)> send) : sent_{io}, send_{std::move(send)} {}
    ~HalfDuplex() { close(); }
    HalfDuplex(const HalfDuplex&) = delete;
    HalfDuplex& operator=(const HalfDuplex&) = delete;

    /// Of an open serial port, which stays open until close().
    Expected<void> open(int port, ano::Duration byte_time);
    /// Listens. Waits for the thread, which ends at once when nothing waits in the driver (throw that away before).
    void close() noexcept;

    /// Something may not be out yet.
    bool is_sending() const noexcept { return sending_; }

    /// Before each write.
    void writing();
    /// After it: what was written is on its way.
    void written();

private:
    void all_sent();

    Descriptor sent_;    // an eventfd: the thread says that all is out
    std::function<void(bool)> send_;
    std::thread thread_;
    std::counting_semaphore<> wait_{0};    // tells the thread to wait for the port
    std::atomic<bool> closing_{false};
    bool sending_ = false;
    bool waiting_ = false;    // the thread is
    bool again_ = false;      // something was written since
};

}    // namespace anogate
