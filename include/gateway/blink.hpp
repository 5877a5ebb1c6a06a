// A light that shows traffic: lit and dark long enough to be seen, 20 times a second at most.
#pragma once
#include <ano/time.hpp>

namespace anogate {

class Blink {
public:
    static constexpr ano::Duration shortest = std::chrono::milliseconds{25};    // lit, and dark

    /// There was traffic at `now`. True: the light goes on now, and lit_until() is when to call end().
    constexpr bool traffic(ano::TimePoint now) noexcept {
        if (lit_ || now < dark_until_) return false;
        lit_ = true;
        lit_until_ = now + shortest;
        return true;
    }
    constexpr ano::TimePoint lit_until() const noexcept { return lit_until_; }
    /// The light goes out at `now`, however late that is.
    constexpr void end(ano::TimePoint now) noexcept {
        lit_ = false;
        dark_until_ = now + shortest;
    }

private:
    ano::TimePoint lit_until_{};
    ano::TimePoint dark_until_{};
    bool lit_ = false;
};

}  // namespace anogate
