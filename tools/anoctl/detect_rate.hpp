// Which rate the device at a serial port speaks at: the one at which its frames are good.
#pragma once
#include "anoctl.hpp"

#include <ano/parser.hpp>

#include <chrono>
#include <cstdint>
#include <set>
#include <span>
#include <string>

namespace anoctl {

/// The usual rates, those that devices of V8 have first.
std::span<const std::uint32_t> usual_rates() noexcept;

/// What came in while a port was at one rate.
struct HeardAtRate {
    std::uint32_t baud = 0;
    ano::ParserCounters counters;
    std::set<std::uint8_t> from;    // who sent the good frames

    /// Frames that are no accident: two, or one that most of the bytes belong to.
    bool is_right() const noexcept {
        const std::uint64_t good = counters.bytes_in - counters.skipped_bytes;
        return counters.frames_in >= 2 || (counters.frames_in == 1 && good > counters.skipped_bytes);
    }
};

/// How long it listens at a rate.
struct ListeningTime {
    ano::Duration for_first_byte = std::chrono::milliseconds{1200};    // who sends once a second is heard at every rate
    ano::Duration for_frames = std::chrono::milliseconds{500};         // from the first byte on
};

/// Listens at one rate after the other until one is right, and says so. Returns the exit status. Nothing is sent. Throws Failure when
/// the port can't be opened, none is right, or SIGINT comes.
int detect_rate(const std::string& port, bool json, Streams& streams, ListeningTime time = {});

}    // namespace anoctl
