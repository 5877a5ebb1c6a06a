#include <recording/disk_pace.hpp>

#include <algorithm>

namespace anogate {

ano::Duration DiskPace::reported_silence() const noexcept {
    const bool was_reported = has_lost_ || longest_ > ano::Duration::zero();    // not if only behind: a silence may follow
    return is_troubled_ && was_reported ? std::max(min_further_silence, 2 * longest_) : min_silence;
}

// The first look() after a reported silence does not report slowness: the frames that waited during it are still being written.
DiskPace::State DiskPace::look(ano::TimePoint now, const Signs& signs) noexcept {
    const bool is_quiet = signs.silence >= min_silence, was_silent = state_ == State::silent;
    if (signs.fails || (is_troubled_ && now >= troubled_until_)) {
        is_troubled_ = has_lost_ = false;
        longest_ = silence_ = {};
    }
    if (!is_quiet) longest_ = std::max(longest_, silence_);
    silence_ = is_quiet ? signs.silence : ano::Duration{};

    if (!was_silent) before_ = reported_silence() == min_silence ? State::well : state_;
    if (is_quiet) state_ = was_silent || signs.silence >= reported_silence() ? State::silent : State::slow;
    else if (was_silent) state_ = is_troubled_ ? before_ : State::well;
    else if (signs.is_behind && !signs.fails) state_ = State::slow;
    else if (!is_troubled_) state_ = State::well;

    if (is_quiet || (signs.is_behind && state_ == State::slow)) {
        is_troubled_ = !signs.fails;
        has_lost_ = is_troubled_ && (has_lost_ || signs.loses);
        troubled_until_ = now + holds;
    }
    return state_;
}

}    // namespace anogate
