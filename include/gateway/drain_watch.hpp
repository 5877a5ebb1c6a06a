// Notices a line that takes nothing, as one that the device's flow control stops.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstdint>

namespace anogate {

/// Of one channel. To be called at least once in `seen_within` while somebody waits for it: what was before a longer pause is not known.
class DrainWatch {
public:
    static constexpr ano::Duration patience = std::chrono::seconds{3};
    static constexpr ano::Duration seen_within = std::chrono::seconds{1};

    /// `left`: the bytes that have left so far; `waits`: some wait to leave. True: they wait, and none has left for `patience`.
    constexpr bool takes_nothing(std::uint64_t left, bool waits, ano::TimePoint now) noexcept {
        if (!waits || left != left_ || now - seen_at_ > seen_within) since_ = now;
        left_ = left;
        seen_at_ = now;
        return now - since_ >= patience;
    }

private:
    std::uint64_t left_ = 0;
    ano::TimePoint since_{}, seen_at_{};
};

}    // namespace anogate
