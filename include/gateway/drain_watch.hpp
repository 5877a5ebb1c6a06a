// Detects a line that accepts no bytes, for example because the flow control of the device stops it.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstdint>

namespace anogate {

/// For one channel. Call it at least once per `seen_within` while anything waits for it: nothing is known of a longer pause.
class DrainWatch {
public:
    static constexpr ano::Duration patience = std::chrono::seconds{3};
    static constexpr ano::Duration seen_within = std::chrono::seconds{1};

    /// `left`: the bytes sent so far; `waits`: some wait to be sent. True: bytes wait, and none was sent for `patience`.
    constexpr bool accepts_nothing(std::uint64_t left, bool waits, ano::TimePoint now) noexcept {
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
