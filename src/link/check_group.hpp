// A check for the kinds of links that listen.
#pragma once
#include <config/link_kind.hpp>
#include <gateway/settings.hpp>

namespace anogate {

/// `has_trusted`: the key `trusted` has a value.
inline void check_group(const LinkSettings& link, bool has_trusted, LinkFaults& faults) {
    if (link.group.empty() || has_trusted) return;
    faults.warning("group",
                   "without 'trusted', no peer of this link is in the group, and any peer may replace a device that is silent on "
                   "the other links: name the address of the other end in 'trusted'");
}

}    // namespace anogate
