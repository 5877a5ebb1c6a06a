// Which channel is next when several have received more than can be processed at once: each gets the same share of the time.
//
// Flow:    shares.begins(id)                    // data waits again on this channel
//          const auto id = shares.next(waiting)
//          shares.charge(id, time)              // the time that it took
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>

namespace anogate {

/// A channel that receives little goes before those that always have waiting data, because it has used the least time. Time that
/// a channel does not use while none of its data waits is not saved for later.
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
    ano::Duration least_{};    // the time used by the channel of the last turn, before that turn
};

}    // namespace anogate
