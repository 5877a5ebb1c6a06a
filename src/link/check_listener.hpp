// Checks for the kinds of links that listen.
#pragma once
#include <config/link_kind.hpp>
#include <gateway/settings.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// `has_trusted`: the key `trusted` has a value.
inline void check_group(const LinkSettings& link, bool has_trusted, LinkFaults& faults) {
    if (link.group.empty() || has_trusted) return;
    faults.warning("group",
                   "without 'trusted', no peer of this link is in the group, and a device that is silent on the other links may "
                   "move to any peer unless it is pinned: name the address of the other end in 'trusted'");
}

inline void check_per_address(std::optional<std::uint16_t> max_per_address, std::uint16_t max_peers, LinkFaults& faults) {
    if (max_per_address && *max_per_address > max_peers)
        faults.warning("max_per_address", "'max_per_address' " + std::to_string(*max_per_address) +
                                              " has no effect: it is more than 'max_peers', " + std::to_string(max_peers));
}

}    // namespace anogate
