// Zero bytes before a frame, for a device whose parser may wait inside a damaged one.
#pragma once
#include <ano/time.hpp>

#include <algorithm>

namespace ano {

/// What became of zero bytes that were wanted before a frame.
struct Flush {
    Duration busy{};     // the line sends them for so long; zero also when none are sent
    Duration later{};    // none are sent, but they may be in so long; zero: waiting for that is of no use

    /// Of a frame that leaves by several lines.
    friend Flush operator|(const Flush& one, const Flush& other) noexcept {
        return {std::max(one.busy, other.busy), std::max(one.later, other.later)};
    }
};

}    // namespace ano
