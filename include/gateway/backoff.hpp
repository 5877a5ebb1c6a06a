// When to open a link again, for all kinds of links.
#pragma once
#include <ano/time.hpp>

#include <algorithm>

namespace anogate {

/// The first retry is immediate, the second after 100 ms. Each pause is twice the previous one, at most `longest`. If a link was
/// up for less than one second, the pauses continue where they were, so that a link that opens and fails at once can't keep the
/// loop busy.
class Backoff {
public:
    static constexpr ano::Duration first = std::chrono::milliseconds{100};
    static constexpr ano::Duration cap = std::chrono::seconds{1};        // the longest pause for a plugged-in device
    static constexpr ano::Duration network = std::chrono::seconds{5};    // the longest pause for a peer in a network

    constexpr explicit Backoff(ano::Duration longest = cap) noexcept : longest_{longest} {}

    constexpr void came_up(ano::TimePoint now) noexcept {
        up_ = true;
        up_since_ = now;
    }
    /// The link or an attempt to open it failed at `now`: returns when to try next.
    constexpr ano::TimePoint retry_at(ano::TimePoint now) noexcept {
        if (up_ && now - up_since_ >= cap) pause_ = ano::Duration::zero();
        up_ = false;
        const ano::Duration pause = pause_;
        pause_ = pause == ano::Duration::zero() ? first : std::min(2 * pause, longest_);
        return now + pause;
    }

private:
    ano::Duration longest_;
    ano::Duration pause_ = ano::Duration::zero();
    ano::TimePoint up_since_{};
    bool up_ = false;
};

}    // namespace anogate
