#include <ano/traffic.hpp>
#include <gateway/queue_policy.hpp>

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

}    // namespace anogate
