// Which recordings go, so that the others have room. No I/O.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace anogate {

/// A file that the gateway wrote.
struct KeptRecording {
    std::string name;
    std::uint64_t bytes = 0;
    std::chrono::seconds time{};    // of its last change, since 1970
    bool is_written = false;        // now: it never goes
};

/// 0: no limit.
struct KeepLimits {
    std::uint64_t bytes = 0;       // all recordings together have at most so many
    std::chrono::seconds age{};    // none is older
    std::uint64_t free = 0;        // bytes of the disk that stay free
};

/// The places in `recordings` of those that go, the oldest first. `now` is since 1970; a recording of the future is not old. For the
/// sake of free bytes none goes when all of them were not enough: they would be lost for nothing.
std::vector<std::size_t> recordings_to_delete(std::span<const KeptRecording> recordings, const KeepLimits& limits,
                                              std::chrono::seconds now, std::uint64_t free_bytes);

}    // namespace anogate
