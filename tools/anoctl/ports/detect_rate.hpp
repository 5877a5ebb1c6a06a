// Detects the baud rate of the device at a serial port: the rate at which valid frames are received.
#pragma once
#include <anoctl/anoctl.hpp>

#include <ano/parser.hpp>
#include <ano/v7.hpp>

#include <algorithm>
#include <bitset>
#include <chrono>
#include <cstdint>
#include <set>
#include <span>
#include <string>

namespace anoctl {

/// The usual rates, in the order of the attempts: first those of V8 devices.
std::span<const std::uint32_t> usual_rates() noexcept;

/// The data received at one rate.
struct HeardAtRate {
    std::uint32_t baud = 0;
    ano::ParserCounters counters;
    std::set<std::uint8_t> from;    // the senders of the valid frames
    ano::v7::ParserCounters v7;     // as frames of the previous protocol version
    std::bitset<256> v7_ids;

    /// Whether the valid frames are no coincidence: at least two, or one that contains most of the bytes.
    bool is_right() const noexcept { return is_no_coincidence(counters.frames_in, counters.bytes_in, counters.skipped_bytes); }
    bool is_right_in_v7() const noexcept { return is_no_coincidence(v7.frames_in, v7.bytes_in, v7.skipped_bytes); }

private:
    static bool is_no_coincidence(std::uint64_t frames, std::uint64_t bytes, std::uint64_t skipped) noexcept {
        return frames >= 2 || (frames == 1 && bytes - skipped > skipped);
    }
};

/// How long each rate is tried.
struct ListeningTime {
    ano::Duration for_first_byte = std::chrono::milliseconds{1200};    // enough for a device that sends once a second
    ano::Duration for_frames = std::chrono::milliseconds{500};         // from the first byte on
    unsigned bytes = 400;    // a slow rate gets at least the time of this many bytes: some frames, the first of them incomplete

    /// The time after the first byte, at this rate.
    ano::Duration at(std::uint32_t baud) const noexcept {
        return std::max(for_frames, ano::Duration{std::chrono::seconds{10}} * bytes / baud);
    }
};

/// The rate at which valid frames were received.
struct FoundRate {
    std::uint32_t baud = 0;
    std::set<std::uint8_t> from;
    bool any_rate = false;         // USB device (cdc_acm), which ignores the rate
    std::uint8_t v7_device = 0;    // a guess, if the frames are of V7; 0: they are of V8
    std::bitset<256> v7_ids{};
};

/// Listens at one rate after another until one is right. Sends nothing. Throws Failure if the port can't be opened, no rate is
/// right, or on SIGINT or SIGTERM.
FoundRate find_rate(const std::string& port, Streams& streams, ListeningTime time = {});

/// The same, and prints the result. Returns the exit status.
int detect_rate(const std::string& port, bool json, Streams& streams, ListeningTime time = {});

}    // namespace anoctl
