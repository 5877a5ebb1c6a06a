// Whether a frame came from where nobody else can send in the name of its source.
#pragma once
#include <config/link_kind.hpp>
#include <runtime/gateway.hpp>

#include <cstdint>

namespace anogate {

/// `source` is not at home elsewhere, and came by a serial port, CAN or another link that is no network, or by the link that it is pinned
/// to. In a network anybody can send in the name of a device.
inline bool is_known_origin(const Gateway& gateway, const Channel& from, std::uint8_t source) {
    const Router& router = gateway.forwarder().router();
    const bool is_wired = gateway.settings(from.link).kind->reach == nullptr;
    return !router.claims(source, from.id) && (is_wired || router.pinned(source).contains(from.link));
}

}    // namespace anogate
