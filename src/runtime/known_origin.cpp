#include <config/link_kind.hpp>
#include <runtime/gateway.hpp>
#include <runtime/known_origin.hpp>

namespace anogate {

bool is_known_origin(const Gateway& gateway, const Channel& from, std::uint8_t source) {
    const Router& router = gateway.forwarder().router();
    const bool is_wired = gateway.settings(from.link).kind->reach == nullptr;
    return !router.claims(source, from.id) && (is_wired || router.pinned(source).contains(from.link));
}

}    // namespace anogate
