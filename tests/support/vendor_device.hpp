// A device at a pseudo-terminal with the vendor's parser: after a damaged LEN it receives no frames.
#pragma once
#include "bytes.hpp"
#include "fake_device.hpp"
#include "fake_loader.hpp"
#include "pty_device.hpp"

#include <ano/messages.hpp>
#include <world/vendor_parser.hpp>

#include <poll.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace support {

/// Driven by its own thread, which start() starts.
class VendorDevice {
public:
    explicit VendorDevice(const std::string& path) : port_{path} {
        fake.instead = [this](ano::FrameView frame) { return loader_.take(fake, frame); };
    }
    ~VendorDevice() {
        stops_ = true;
        if (thread_.joinable()) thread_.join();
    }
    VendorDevice(const VendorDevice&) = delete;
    VendorDevice& operator=(const VendorDevice&) = delete;

    FakeDevice fake;    // not to be used after start()
    void start() {
        thread_ = std::thread{[this] { run(); }};
    }
    /// Passes its parser a header with a damaged LEN, so that it waits for 190 bytes.
    void disturb() {
        disturbed_ = true;
        while (disturbed_) std::this_thread::sleep_for(std::chrono::milliseconds{1});
    }
    /// It receives frames, but sends none.
    void mute(bool is_mute) { is_mute_ = is_mute; }
    unsigned calls() const { return calls_; }
    unsigned frames() const { return frames_; }
    /// The largest number of zero bytes received in a row.
    std::size_t zeros() const { return zeros_; }

private:
    void run() {
        TimePoint next{};
        while (!stops_) {
            pollfd port{port_.fd(), POLLIN, 0};
            ::poll(&port, 1, 10);
            if (port.revents & POLLHUP) std::this_thread::sleep_for(std::chrono::milliseconds{10});    // no program has it open
            if (disturbed_) {
                parser_.feed(Bytes{0xAB, 0xFE, 0xDC, 0xE0, 190, 0, 1, 0, 0, 0x6E, 0x60}, [](ano::Bytes) {});
                disturbed_ = false;
            }
            receive(port_.read());
            if (ano::Clock::now() < next) continue;
            next = ano::Clock::now() + std::chrono::milliseconds{100};
            if (!is_mute_) port_.write(frame(fake.address, 0xFF, 0x03, Bytes(7)));
        }
    }
    void receive(const Bytes& bytes) {
        for (const std::uint8_t byte : bytes) {
            in_a_row_ = byte == 0 ? in_a_row_ + 1 : 0;
            zeros_ = std::max<std::size_t>(zeros_, in_a_row_);
        }
        parser_.feed(bytes, [this](ano::Bytes frame) {
            const ano::FrameView heard{frame};
            ++frames_;
            calls_ += heard.id() == 0xC0;
            for (const Bytes& answer : fake.take(heard))
                if (!is_mute_) port_.write(answer);
        });
    }

    PtyDevice port_;
    FakeLoader loader_;
    ano::world::VendorParser parser_;
    std::atomic<bool> stops_ = false, disturbed_ = false, is_mute_ = false;
    std::atomic<unsigned> calls_ = 0, frames_ = 0;
    std::size_t in_a_row_ = 0;
    std::atomic<std::size_t> zeros_ = 0;
    std::thread thread_;
};

}    // namespace support
