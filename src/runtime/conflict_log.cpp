#include <runtime/conflict_log.hpp>
#include <runtime/gateway.hpp>

#include <fmt/core.h>

namespace anogate {

namespace {

std::string names_of(const Gateway& gateway, LinkSet links) {
    std::string names;
    for (const LinkId id : links) names += (names.empty() ? "" : " and ") + gateway.link(id).name();
    return names;
}

bool are_of_one_group(const Gateway& gateway, LinkSet links) {
    const std::string& group = gateway.link(*links.begin()).settings().group;
    bool are = !group.empty();
    for (const LinkId id : links) are = are && gateway.link(id).settings().group == group;
    return are;
}

}    // namespace

SharedSource meaning_of(const Gateway& gateway, const Conflict& conflict) {
    const Forwarder& forwarder = gateway.forwarder();
    if (!conflict.links.has_several()) return SharedSource::two_peers;
    if (are_of_one_group(gateway, conflict.links)) return SharedSource::of_a_group;
    const LinkSet pinned = forwarder.router().pinned(conflict.address);
    if (!pinned.empty() && !(conflict.links - pinned).empty()) return SharedSource::claims_pinned;
    const bool is_one = forwarder.same_device().met(conflict.address) && !forwarder.same_device().differ(conflict.address);
    return is_one ? SharedSource::one_device : SharedSource::two_devices;
}

std::string conflict_text(const Gateway& gateway, const Conflict& conflict) {
    const LinkSet pinned = gateway.forwarder().router().pinned(conflict.address);
    const Forwarder::Claimant* const by = gateway.forwarder().claimant(conflict);
    const SharedSource meaning = meaning_of(gateway, conflict);
    std::string text = fmt::format("0x{:02X} is {} {}", conflict.address, pinned.empty() ? "seen on" : "pinned to",
                                   names_of(gateway, pinned.empty() ? conflict.links : pinned));
    if (by != nullptr)
        text += (pinned.empty() ? ", claimed by " : ", and is claimed by ") + gateway.link(by->link).name() +
                (by->peer.empty() ? "" : " (" + by->peer + ")");
    else if (!pinned.empty()) text += ", and is seen on " + names_of(gateway, conflict.links);
    text.append(": ").append(advice_on(meaning));
    if (pinned.empty() && meaning != SharedSource::two_peers && meaning != SharedSource::of_a_group)
        text += fmt::format("; or pin it: --route 0x{:02X}=LINK", conflict.address);
    return text;
}

std::string move_text(const Gateway& gateway, const Router::Moved& moved) {
    const std::string before = names_of(gateway, moved.from);
    const Router& router = gateway.forwarder().router();
    if (!router.pinned(moved.address).empty())
        return fmt::format("0x{:02X} moved from {} to {}, which is in the same group: frames for it now also go there",
                           moved.address, before, gateway.link(moved.to).name());
    return fmt::format(
        "0x{:02X} moved from {} to {}: frames for it now go there. If the device is not connected there, pin it: --route "
        "0x{:02X}={}",
        moved.address, before, gateway.link(moved.to).name(), moved.address, before);
}

}    // namespace anogate
