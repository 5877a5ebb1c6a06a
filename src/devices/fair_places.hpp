// Which requesters that share a number of places may take one more.
#pragma once
#include <devices/job.hpp>

#include <cstddef>

namespace anogate {

/// Jobs that change a device have places of their own, jobs that read it as many, and those of clients that may only view half as
/// many: a reading job never takes the place of a command. Within each sort, a client may take a place as long as more are free
/// than it has: a single client gets half of them, and a client without a place finds one.
struct FairPlaces {
    std::size_t of_control;

    constexpr std::size_t of(const Requester& requester) const noexcept {
        return requester.controls() ? of_control : of_control / 2;
    }
    /// `taken`: by all requesters of the same sort; `own`: by the same client.
    constexpr bool has_one_for(const Requester& requester, std::size_t taken, std::size_t own) const noexcept {
        return taken + own < of(requester);
    }
};

/// Counts the places in use: `all` are the requesters that hold one.
template <class All>
bool has_place_for(const Requester& requester, const FairPlaces& places, const All& all) {
    std::size_t taken = 0, own = 0;
    for (const Requester& one : all) {
        if (one.controls() != requester.controls() || one.acts != requester.acts) continue;
        ++taken;
        if (one.client_id == requester.client_id) ++own;
    }
    return places.has_one_for(requester, taken, own);
}

}    // namespace anogate
