// A light that shows traffic: on and off long enough to be seen, at most 20 times a second.
#pragma once
#include <ano/time.hpp>

#include <utility>

namespace anogate {

class Blink {
public:
    static constexpr ano::Duration min_phase = std::chrono::milliseconds{25};    // minimum duration of on and of off

    /// There was traffic. True: step() is to be called at due(), or now if that is past. Traffic while the light is on is
    /// shown already; traffic while it is off is shown by the next flash.
    constexpr bool traffic() noexcept { return !lit_ && !std::exchange(seen_, true); }
    /// When the light may change next.
    constexpr ano::TimePoint due() const noexcept { return due_; }
    /// Changes the light, at due() or later; true: it is on now, and step() is to be called again.
    constexpr bool step(ano::TimePoint now) noexcept {
        lit_ = std::exchange(seen_, false);
        due_ = now + min_phase;
        return lit_;
    }

private:
    ano::TimePoint due_{};
    bool lit_ = false;
    bool seen_ = false;    // traffic that is not shown yet; never while the light is on
};

}    // namespace anogate
