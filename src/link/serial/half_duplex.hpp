// Switches an RS-485 transceiver to sending before a write, and back after the last bit is sent. A thread waits for the last bit;
// everything else, including the line, is done in the loop.
#pragma once
#include <ano/time.hpp>
#include <sys/descriptor.hpp>
#include <sys/expected.hpp>

#include <atomic>
#include <functional>
#include <semaphore>
#include <thread>

namespace anogate {

class HalfDuplex {
public:
    /// `send(true)` must switch the transceiver to sending, `send(false)` to receiving.
    HalfDuplex(asio::io_context& io, std::function<void(bool)> send) : sent_{io}, send_{std::move(send)} {}
    ~HalfDuplex() { close(); }
    HalfDuplex(const HalfDuplex&) = delete;
    HalfDuplex& operator=(const HalfDuplex&) = delete;

    /// `port`: an open serial port, which must stay open until close().
    Expected<void> open(int port, ano::Duration byte_time);
    /// Switches to receiving. Blocks until the thread ends: at once if the driver holds no output, so discard that first.
    void close() noexcept;

    /// Whether some bits may not be sent yet.
    bool is_sending() const noexcept { return sending_; }

    /// To be called before each write.
    void writing();
    /// To be called after each write.
    void written();

private:
    void all_sent();

    Descriptor sent_;    // an eventfd: the thread reports that everything is sent
    std::function<void(bool)> send_;
    std::thread thread_;
    std::counting_semaphore<> wait_{0};    // released: the thread waits for the port
    std::atomic<bool> closing_{false};
    bool sending_ = false;
    bool waiting_ = false;    // the thread is waiting for the port
    bool again_ = false;      // more was written since the thread began to wait
};

}    // namespace anogate
