// The contents of a recording, for all formats.
#pragma once
#include <ano/frame.hpp>
#include <gateway/frame_record.hpp>
#include <record/decoding.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace anogate {

/// A frame that passed a gateway. Texts are UTF-8; the texts and the frame refer to memory of the caller.
struct RecordedFrame {
    std::uint64_t time_ns = 0;                 // since 1970
    std::uint64_t boottime_ns = 0;             // since the computer was started; 0: not known
    std::string_view link = {};                // its name
    std::string_view link_description = {};    // "serial /dev/ttyUSB0"; empty: not known
    Direction direction = Direction::in;
    std::string_view cause = {};                 // why it was dropped: a name of frame_causes()
    std::optional<std::uint8_t> channel = {};    // the number of the channel in its gateway
    std::string_view peer = {};                  // of that channel
    ano::FrameView frame;
};

/// Frames that were not recorded, after the previous frame and before the next one.
struct RecordedLoss {
    std::uint64_t count = 0;
    std::string_view names = {};    // "euler 120, inertial 120"
};

using Recorded = std::variant<RecordedFrame, RecordedLoss>;

/// The recording program, and both clocks at the beginning.
struct RecordingHead {
    std::string program;    // "anoctl 0.1.0"
    std::uint64_t time_ns = 0;
    std::uint64_t boottime_ns = 0;
    DecodingPtr decoding{};           // of the frames; in a reader: that of its last frame
    bool has_bad_decoding = false;    // in a reader: one could not be read

    /// `text` of Decoding, as read from a recording.
    void use_decoding(std::string_view text) {
        decoding = Decoding::parse(text);
        has_bad_decoding = has_bad_decoding || !decoding;
    }
};

/// Texts of a recording are cut after this many bytes, and before a NUL.
inline constexpr std::size_t max_recorded_text = 1024;
/// The part of `text` that is recorded, without an incomplete character at its end.
std::string_view text_that_fits(std::string_view text) noexcept;

/// Seconds in whole microseconds, as in the JSON of frames.
double json_seconds(std::uint64_t ns) noexcept;
/// Appends "1763898044.123456789".
void append_seconds(std::uint64_t ns, std::string& out);

}    // namespace anogate
