// Who gives way when all places at the server are taken.
#pragma once
#include <ano/time.hpp>
#include <http/door.hpp>

#include <cstddef>
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

/// Whose places are counted together: a user of this machine, and beside them, as one, all who come by the network. What they have is
/// shared in turn by their clients.
struct Party {
    std::uint32_t user = 0;      // unknown_user: of the network
    std::uint64_t client = 0;    // there: which one
};
Party party_of(std::uint32_t user, const Door& door);

/// One client that has a place.
struct Visitor {
    Party party{};
    Asking asking = Asking::nothing;
    ano::TimePoint since{};         // it came, or came on
    std::optional<Access> may{};    // what its last request might; nothing: none was judged yet
};

/// All places are taken by `visitors`, and one of `party` wants one: whose place it gets, by number; nothing: it is refused.
///
/// Each party that is there has the same share. Who has his share gets a place of his own alone; who has less gets one of who has
/// most beyond it. First gives way who asks nothing or asked half a request: of these two sorts the one that has more, so that a
/// crowd of the one costs none of the other. Then who was not heard yet. Of a sort, the one that has said nothing for longest. A
/// whole request gives way to a party that has less than its share, never to one of the same party. `first` (root and our own user)
/// gets a place also where there are more parties than places.
///
/// Clients of the network: whose request is not here in full gives way to each, of the client first that has most such. A whole
/// request gives way to a client that has less than its share, and to one that has shown that it may control; of who may control it
/// gives way to none.
std::optional<std::size_t> gives_way(std::span<const Visitor> visitors, const Party& party, bool first);

/// Whether the request of one of the visitors, who are counted with it, may take its place for as long as it is answered: of `places`
/// one in eight is kept from those who may not control, so that who controls a vehicle finds one however many look at it. Until a
/// request was judged it has a place of any sort, for which one more is kept free.
bool has_place(std::span<const Visitor> visitors, std::size_t places, Access access);

/// Who controls has taken the last place: which of those who look leaves, so that the next can be heard. Nothing: none has to.
std::optional<std::size_t> leaves_room(std::span<const Visitor> visitors, std::size_t places);

}    // namespace anogate::http
