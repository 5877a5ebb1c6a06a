// The resources used by this process.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

struct ProcessFigures {
    double cpu_s = 0;
    double started_at_s = 0;    // Unix time
    std::uint64_t virtual_bytes = 0, resident_bytes = 0;
    std::optional<std::uint64_t> open_fds;    // std::nullopt: not known at present
    std::uint64_t max_fds = 0;
};

/// Reads the figures from /proc, which never blocks on a disk.
ProcessFigures this_process();

/// Parses the text of /proc/PID/stat. std::nullopt: it has another form.
struct ProcessTimes {
    std::uint64_t ticks = 0;            // of CPU time
    std::uint64_t started_ticks = 0;    // since the system started
    std::uint64_t virtual_bytes = 0;
    std::uint64_t resident_pages = 0;
};
std::optional<ProcessTimes> parse_stat(std::string_view text);

}    // namespace anogate
