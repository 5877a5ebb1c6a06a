// A light that shows traffic. On and off last long enough to be visible, at most 20 times a second.
#pragma once
#include <ano/time.hpp>

#include <utility>

namespace anogate {

class Blink {
public:
    static constexpr ano::Duration min_phase = std::chrono::milliseconds{25};    // minimum duration of on and of off

    /// There was traffic. True: call step() at due(), or now if that is past. Traffic while the light is on needs no further
    /// flash; traffic while it is off causes the next flash.
    constexpr bool traffic() noexcept { return !lit_ && !std::exchange(seen_, true); }
    /// When the light may change next.
    constexpr ano::TimePoint due() const noexcept { return due_; }
    /// Changes the light, at due() or later. True: it is on now, and step() must be called again.
    constexpr bool step(ano::TimePoint now) noexcept {
        lit_ = std::exchange(seen_, false);
        due_ = now + min_phase;
        return lit_;
    }

private:
    ano::TimePoint due_{};
    bool lit_ = false;
    bool seen_ = false;    // traffic not shown yet; never set while the light is on
};

}    // namespace anogate
