// Finds the baud rate of the device at a serial port: the one at which its frames are good.
#pragma once
#include <anoctl/anoctl.hpp>

#include <ano/parser.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <set>
#include <span>
#include <string>

namespace anoctl {

/// The usual rates; first those of V8 devices.
std::span<const std::uint32_t> usual_rates() noexcept;

/// What was received while a port was at one rate.
struct HeardAtRate {
    std::uint32_t baud = 0;
    ano::ParserCounters counters;
    std::set<std::uint8_t> from;    // the senders of the good frames

    /// Whether the good frames are no coincidence: at least two, or one that has most of the bytes.
    bool is_right() const noexcept {
        const std::uint64_t good = counters.bytes_in - counters.skipped_bytes;
        return counters.frames_in >= 2 || (counters.frames_in == 1 && good > counters.skipped_bytes);
    }
};

/// How long to listen at each rate.
struct ListeningTime {
    ano::Duration for_first_byte = std::chrono::milliseconds{1200};    // so that a device that sends once a second is heard
    ano::Duration for_frames = std::chrono::milliseconds{500};         // from the first byte on
    unsigned bytes = 400;    // at a slow rate at least the time of these: some frames, the first of them not whole

    /// From the first byte on, at this rate.
    ano::Duration at(std::uint32_t baud) const noexcept {
        return std::max(for_frames, ano::Duration{std::chrono::seconds{10}} * bytes / baud);
    }
};

/// The rate at which a device at a port sends good frames.
struct FoundRate {
    std::uint32_t baud = 0;
    std::set<std::uint8_t> from;
    bool any_rate = false;    // by USB alone (cdc_acm): the rate means nothing
};

/// Listens at one rate after the other until one is right. Nothing is sent. Throws Failure when the port can't be opened, no rate is
/// right, or SIGINT is received.
FoundRate find_rate(const std::string& port, Streams& streams, ListeningTime time = {});

/// The same, and prints it. Returns the exit status.
int detect_rate(const std::string& port, bool json, Streams& streams, ListeningTime time = {});

}    // namespace anoctl
