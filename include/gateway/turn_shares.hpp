// Whose turn it is when several channels have received more than can be processed at once: each gets the same share of the time.
//
// Flow:    shares.begins(id)                    // something waits of a channel of which nothing waited
//          const auto id = shares.next(waiting)
//          shares.charge(id, time)              // how long that took
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>

namespace anogate {

/// A channel that receives little goes before those that always have something waiting: it has used the least time. What a
/// channel does not use while nothing of it waits is not saved for later.
class TurnShares {
public:
    void begins(ChannelId id) noexcept { used_[index(id)] = std::max(used_[index(id)], least_); }
    /// The channel of `waiting`, which is not empty, that has used the least time.
    ChannelId next(ChannelSet waiting) noexcept {
        ChannelId chosen = *waiting.begin();
        for (const ChannelId id : waiting)
            if (used_[index(id)] < used_[index(chosen)]) chosen = id;
        least_ = std::max(least_, used_[index(chosen)]);
        return chosen;
    }
    void charge(ChannelId id, ano::Duration time) noexcept { used_[index(id)] += time; }

private:
    std::array<ano::Duration, max_channels> used_{};
    ano::Duration least_{};    // what the channel of the last turn had used before it
};

}    // namespace anogate
