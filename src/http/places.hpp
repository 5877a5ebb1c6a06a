// Who gives way when all places at the server are taken.
#pragma once
#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <span>

namespace anogate::http {

/// What was heard of a client.
enum class Asking : std::uint8_t {
    nothing,    // for a while: it asks when it likes
    half,       // the beginning of a request
    unheard,    // it has just come: its request may be on the way
    whole,      // a request, of which the answer waits, or is on its way
};

/// One client that has a place.
struct Visitor {
    std::uint32_t user = 0;
    Asking asking = Asking::nothing;
    ano::TimePoint since{};    // it came, or came on
};

/// All places are taken by `visitors`, and one of `user` wants one: whose place it gets, by number; nothing: it is refused.
/// Each user that is there has the same share. Who has his share gets a place of his own alone; who has less gets one of who has
/// most beyond it. First gives way who asks nothing or asked half a request: of these two sorts the one that has more, so that a
/// crowd of the one costs none of the other. Then who was not heard yet. Of a sort, the one that has said nothing for longest. A
/// whole request gives way to a user who has less than his share, never to one of the same user. `first` (root and our own user)
/// gets a place also where there are more users than places.
std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, std::uint32_t user, bool first);

}    // namespace anogate::http
