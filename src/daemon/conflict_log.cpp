#include <daemon/conflict_log.hpp>
#include <daemon/gateway.hpp>

#include <fmt/core.h>

namespace anogate {

std::string conflict_text(const Gateway& gateway, const Conflict& conflict) {
    std::string names, who;
    for (const LinkId id : conflict.links) names += (names.empty() ? "" : " and ") + gateway.name(id);
    if (const Forwarder::Claimant* by = gateway.forwarder().claimant(conflict))
        who = ", claimed by " + gateway.name(by->link) + (by->peer.empty() ? "" : " (" + by->peer + ")");
    return fmt::format(
        "0x{:02X} is heard on {}{}: the same device? give the links one `group`; two devices? give one of them another "
        "id; neither? pin it: --route 0x{:02X}=LINK",
        conflict.address, names, who, conflict.address);
}

}    // namespace anogate
