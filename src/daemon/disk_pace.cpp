#include <daemon/disk_pace.hpp>

#include <algorithm>

namespace anogate {

ano::Duration DiskPace::silence_that_is_told() const noexcept {
    return is_troubled_ ? std::max(holds, 2 * longest_) : silence_told;
}

// The first look behind a silence that was told is no sign of slowness: what waited through it is still on its way.
DiskPace::State DiskPace::look(ano::TimePoint now, const Signs& signs) noexcept {
    const bool is_quiet = signs.silence >= silence_told, was_silent = state_ == State::silent;
    if (signs.fails || (is_troubled_ && now >= troubled_until_)) {
        is_troubled_ = false;
        longest_ = silence_ = {};
    }
    if (!is_quiet) longest_ = std::max(longest_, silence_);
    silence_ = is_quiet ? signs.silence : ano::Duration{};

    if (is_quiet) state_ = was_silent || signs.silence >= silence_that_is_told() ? State::silent : State::slow;
    else if (signs.is_behind && !signs.fails && !was_silent) state_ = State::slow;
    else if (was_silent || !is_troubled_) state_ = State::well;

    if (is_quiet || (signs.is_behind && state_ == State::slow)) {
        is_troubled_ = !signs.fails;
        troubled_until_ = now + holds;
    }
    return state_;
}

}    // namespace anogate
