// Streams of numbered frames: none may be missing, duplicated or out of order.
#pragma once
#include "bytes.hpp"

#include <gtest/gtest.h>

#include <vector>

#include <sched.h>

namespace support {

inline Bytes numbered(std::uint8_t from, std::uint8_t to, int number) {
    Bytes data(8, 0x55);
    for (int i = 0; i < 4; ++i) data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(number >> 8 * i);
    return frame(from, to, 0xF1, data);
}

/// Pins this process and its children to the processor it runs on. A datagram over the loopback may wait on the processor that
/// sent it while a later one, sent from another processor, arrives first: on a busy machine some arrive out of order.
inline void stay_on_one_processor() {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(::sched_getcpu()), &one);
    ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
}

/// Checks that each numbered frame of a stream is received once and in order.
class Stream {
public:
    Stream(std::uint8_t from, std::uint8_t to) : from_{from}, to_{to} {}
    Bytes next() { return numbered(from_, to_, sent_++); }
    void take(const std::vector<Bytes>& frames) {
        for (const Bytes& f : frames) {
            if (f[1] != from_ || f[3] != 0xF1) continue;
            EXPECT_EQ(f, numbered(from_, to_, came_++));
        }
    }
    int sent() const { return sent_; }
    int came() const { return came_; }
    /// True if fewer than `frames` were sent and fewer than 100 are in transit.
    bool may_go_on(int frames) const { return sent_ < frames && sent_ - came_ < 100; }

private:
    std::uint8_t from_, to_;
    int sent_ = 0, came_ = 0;
};

/// The whole frames that a device or terminal has sent since the last call; `rest` is kept from call to call.
template <class Device>
std::vector<Bytes> frames_of(Device& device, Bytes& rest) {
    Split got = split(rest + device.read());
    rest = std::move(got.rest);
    return std::move(got.frames);
}

}    // namespace support
