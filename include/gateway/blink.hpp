// A light that shows traffic: lit and dark long enough to be seen, 20 times a second at most.
#pragma once
#include <ano/time.hpp>

#include <utility>

namespace anogate {

class Blink {
public:
    static constexpr ano::Duration shortest = std::chrono::milliseconds{25};    // lit, and dark

    /// There was traffic. True: step() is to be called, at due() or now when that is past. What comes while the light is on is
    /// shown already; what comes in the dark behind it is shown after that.
    constexpr bool traffic() noexcept { return !lit_ && !std::exchange(seen_, true); }
    /// When the light may change next.
    constexpr ano::TimePoint due() const noexcept { return due_; }
    /// Changes the light, at due() or later; true: it is on now, and step() is to be called again.
    constexpr bool step(ano::TimePoint now) noexcept {
        lit_ = std::exchange(seen_, false);
        due_ = now + shortest;
        return lit_;
    }

private:
    ano::TimePoint due_{};
    bool lit_ = false;
    bool seen_ = false;    // traffic, and not shown yet; never while lit
};

}    // namespace anogate
