// What this process takes of the system.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

struct ProcessFigures {
    double cpu_s = 0;
    double started_at_s = 0;    // Unix time
    std::uint64_t virtual_bytes = 0, resident_bytes = 0;
    std::optional<std::uint64_t> open_fds;    // nothing: the system does not say now
    std::uint64_t max_fds = 0;
};

/// Asks the system, from files that are in memory.
ProcessFigures this_process();

/// Of a text as /proc/PID/stat has it. Nothing: it is none.
struct ProcessTimes {
    std::uint64_t ticks = 0;            // of CPU time
    std::uint64_t started_ticks = 0;    // since the system started
    std::uint64_t virtual_bytes = 0;
    std::uint64_t resident_pages = 0;
};
std::optional<ProcessTimes> parse_stat(std::string_view text);

}    // namespace anogate
