#include <runtime/conflict_log.hpp>
#include <runtime/gateway.hpp>

#include <fmt/core.h>

namespace anogate {

namespace {

std::string names_of(const Gateway& gateway, LinkSet links) {
    std::string names;
    for (const LinkId id : links) names += (names.empty() ? "" : " and ") + gateway.name(id);
    return names;
}

}    // namespace

std::string conflict_text(const Gateway& gateway, const Conflict& conflict) {
    const LinkSet pinned = gateway.forwarder().router().pinned(conflict.address);
    std::string who;
    const Forwarder::Claimant* const by = gateway.forwarder().claimant(conflict);
    if (by != nullptr) who = gateway.name(by->link) + (by->peer.empty() ? "" : " (" + by->peer + ")");
    if (!pinned.empty() && by != nullptr)
        return fmt::format("0x{:02X} is pinned to {}, and is claimed by {}: frames from there are not taken for its own. {}",
                           conflict.address, names_of(gateway, pinned), who,
                           pinned.contains(by->link)
                               ? "Another device? give it another id"
                               : "The same device? give the links one `group`; another one? give it another id");
    const std::string names = names_of(gateway, conflict.links);
    if (!who.empty()) who.insert(0, ", claimed by ");
    if (!pinned.empty())
        return fmt::format(
            "0x{:02X} is heard on {}: the same device? give the links one `group`; two devices? give one of them another id",
            conflict.address, names);
    return fmt::format(
        "0x{:02X} is heard on {}{}: the same device? give the links one `group`; two devices? give one of them another "
        "id; neither? pin it: --route 0x{:02X}=LINK",
        conflict.address, names, who, conflict.address);
}

std::string move_text(const Gateway& gateway, const Router::Moved& moved) {
    const std::string before = names_of(gateway, moved.from);
    return fmt::format(
        "0x{:02X} moved from {} to {}: frames for it go there now. If the device was not connected there, pin it: --route "
        "0x{:02X}={}",
        moved.address, before, gateway.name(moved.to), moved.address, before);
}

}    // namespace anogate
