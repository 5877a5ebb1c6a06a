// How a frame is treated on a slow line (protocol text, section 5), derived from the message table.
#pragma once
#include <ano/schema.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// In the order of sending.
using ano::TrafficClass;
inline constexpr std::size_t traffic_classes = ano::traffic_class_names.size();

/// Which waiting frame of the same source and destination a newer one may replace.
using ano::Replaces;

/// Which age limit applies to a frame.
enum class AgeKind : std::uint8_t {
    control,    // sticks: urgent, and replaced by newer ones
    telemetry,
    rest,
};

/// How long a frame may wait.
struct AgeLimits {
    ano::Duration control = std::chrono::milliseconds{200};
    ano::Duration telemetry = std::chrono::seconds{1};
    ano::Duration rest = std::chrono::seconds{5};
    bool operator==(const AgeLimits&) const = default;
};

constexpr ano::Duration limit(const AgeLimits& limits, AgeKind kind) noexcept {
    switch (kind) {
    case AgeKind::control: return limits.control;
    case AgeKind::telemetry: return limits.telemetry;
    case AgeKind::rest: break;
    }
    return limits.rest;
}

struct QueuePolicy {
    TrafficClass traffic = TrafficClass::bulk;
    Replaces replaces = Replaces::nothing;
    AgeKind age = AgeKind::rest;
    std::uint32_t age_limit = 0;    // milliseconds; 0: the limit of the link for `age`
    friend constexpr bool operator==(QueuePolicy, QueuePolicy) noexcept = default;
};

constexpr ano::Duration limit(const AgeLimits& limits, QueuePolicy policy) noexcept {
    return policy.age_limit != 0 ? std::chrono::milliseconds{policy.age_limit} : limit(limits, policy.age);
}

/// By id, from the message table.
extern const std::array<QueuePolicy, 256> policies;
inline QueuePolicy policy_of(std::uint8_t id) noexcept { return policies[id]; }

/// The configured class of the frames of one id.
enum class FrameClass : std::uint8_t { control, urgent, telemetry, bulk };
struct ClassSettings {
    std::uint8_t id = 0;
    FrameClass frame_class{};
    std::optional<bool> replaces{};        // a newer frame replaces an older one that waits; std::nullopt: only for `control`
    std::optional<ano::Duration> age{};    // std::nullopt: the limit of the link for the class
    bool operator==(const ClassSettings&) const = default;
};
QueuePolicy policy_of(const ClassSettings& of_id) noexcept;
/// Whether frames of `id` may have a ClassSettings. False for commands, parameters and their answers, each of which must arrive,
/// and for tunnel frames, which contain them.
bool may_have_class(std::uint8_t id) noexcept;

}    // namespace anogate
