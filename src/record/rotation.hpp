// When to begin the next file of a recording, and the names of the files. No I/O.
#pragma once
#include <ano/time.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <string>

namespace anogate {

/// 0: no limit.
struct RotationLimits {
    std::uint64_t bytes = 0;
    ano::Duration time{};
};

/// The file being written.
struct FileSoFar {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0;
    ano::Duration age{};    // by the steady clock
};

/// False for a file without frames: otherwise a gateway that receives no frames would fill its folder with empty files.
constexpr bool is_time_for_the_next(const RotationLimits& limits, const FileSoFar& file) noexcept {
    if (file.frames == 0) return false;
    return (limits.bytes > 0 && file.bytes >= limits.bytes) || (limits.time > ano::Duration::zero() && file.age >= limits.time);
}

/// "flight.pcapng", "flight-2.pcapng": `number` counts from 1.
inline std::string recording_file_name(const std::string& name, unsigned number, RecordingFormat format) {
    std::string file = number > 1 ? name + "-" + std::to_string(number) : name;
    return file.append(".").append(text(format));
}

}    // namespace anogate
