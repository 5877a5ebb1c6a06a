// Who gives way when all places at the control socket are taken.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <span>

namespace anogate {

/// One client that has a place.
struct Visitor {
    std::uint32_t user = 0;
    bool busy = false;        // it asks or is answered, and lately came on with that
    ano::TimePoint since;     // it came, or came on
};

/// All places are taken by `visitors`, and one of `user` wants one: whose place it gets, by number; nothing: it is refused.
/// Each user that is there has the same share. Who has his share gets a place of his own alone, idle the longest. Who has less
/// gets one of who has most beyond it: idle the longest, or else the busy one that came on with nothing for longest.
/// `first` (root and our own user) gets one also where there are more users than places.
std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, std::uint32_t user, bool first);

}  // namespace anogate
