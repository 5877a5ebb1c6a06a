#include <ano/traffic.hpp>
#include <gateway/queue_policy.hpp>
#include <gateway/tunnel/tunnel.hpp>

namespace anogate {
namespace {

consteval AgeKind age_of(ano::Traffic traffic) {
    if (traffic.traffic_class == TrafficClass::telemetry) return AgeKind::telemetry;
    const bool state = traffic.traffic_class == TrafficClass::urgent && traffic.replaces != Replaces::nothing;
    return state ? AgeKind::control : AgeKind::rest;
}

consteval std::array<QueuePolicy, 256> by_id() {
    std::array<QueuePolicy, 256> all;
    for (std::size_t id = 0; id < all.size(); ++id) {
        const ano::Traffic traffic = ano::table::traffic[id];
        all[id] = {traffic.traffic_class, traffic.replaces, age_of(traffic)};
    }
    return all;
}

}    // namespace

constinit const std::array<QueuePolicy, 256> policies = by_id();

QueuePolicy policy_of(const ClassSettings& of_id) noexcept {
    const bool is_control = of_id.frame_class == FrameClass::control;
    QueuePolicy policy;
    policy.traffic = is_control ? TrafficClass::urgent : static_cast<TrafficClass>(static_cast<int>(of_id.frame_class) - 1);
    if (of_id.replaces.value_or(is_control)) {
        const Replaces listed = policy_of(of_id.id).replaces;
        policy.replaces = listed != Replaces::nothing ? listed : Replaces::same_id;
    }
    policy.age = is_control ? AgeKind::control : policy.traffic == TrafficClass::telemetry ? AgeKind::telemetry : AgeKind::rest;
    if (of_id.age) policy.age_limit = static_cast<std::uint32_t>(*of_id.age / std::chrono::milliseconds{1});
    return policy;
}

bool may_have_class(std::uint8_t id) noexcept {
    if (id == ip_tunnel || id == ip_tunnel_short) return false;    // they contain commands
    const QueuePolicy listed = policy_of(id);
    return listed.traffic != TrafficClass::urgent || listed.replaces != Replaces::nothing;
}

}    // namespace anogate
