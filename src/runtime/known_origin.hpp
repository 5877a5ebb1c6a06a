// Whether the origin of a frame rules out a forged source address.
#pragma once
#include <config/link_kind.hpp>
#include <runtime/gateway.hpp>

#include <cstdint>

namespace anogate {

/// True: `source` has no home elsewhere, and the frame was received on a serial port, CAN or another link that is not a network,
/// or on a link that `source` is pinned to. In a network any sender can forge the address of a device.
inline bool is_known_origin(const Gateway& gateway, const Channel& from, std::uint8_t source) {
    const Router& router = gateway.forwarder().router();
    const bool is_wired = gateway.link(from.link).settings().kind->reach == nullptr;
    return !router.claims(source, from.id) && (is_wired || router.pinned(source).contains(from.link));
}

}    // namespace anogate
