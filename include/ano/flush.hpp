// Zero bytes before a frame, for a device whose parser may wait inside a damaged one.
#pragma once
#include <ano/time.hpp>

#include <algorithm>

namespace ano {

/// The result of a request to send zero bytes before a frame.
struct Flush {
    bool sent = false;
    Duration busy{};     // how long the line needs to send them; zero also if that is not known
    Duration later{};    // none are sent now, but may be after this time; zero: waiting has no use

    /// For a frame that is sent on several lines.
    friend Flush operator|(const Flush& one, const Flush& other) noexcept {
        return {one.sent || other.sent, std::max(one.busy, other.busy), std::max(one.later, other.later)};
    }
};

}    // namespace ano
