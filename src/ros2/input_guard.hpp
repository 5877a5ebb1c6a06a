// Which messages of a topic may control a device: those of one publisher at a time, and none that waited. No I/O, no clock.
#pragma once
#include <ano/time.hpp>
#include <ros2/bus.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

/// Why a message was not used.
enum class InputFault : std::uint8_t {
    none,
    old,                // it waited for more than InputGuard::max_age
    other_publisher,    // another publisher controls the device
    malformed,          // not a message of the type, or values that are not numbers
    wrong_mode,         // the device is in a flight mode without velocities
    unknown_mode,       // no 0x06 of the last VelocityControl::mode_age
    not_sent,           // the gateway is not connected
};
inline constexpr std::size_t input_faults = 7;
std::string_view format_fault(InputFault fault) noexcept;

class InputGuard {
public:
    static constexpr ano::Duration silence = std::chrono::milliseconds{500};    // after it, another publisher may begin
    static constexpr std::uint64_t max_age_ns = 500'000'000;

    /// Whether a message may be used. The clocks of publishers differ: the age is relative to the shortest delay of its publisher.
    InputFault check(const Sample& sample, ano::TimePoint now) noexcept;

    /// The publisher whose messages are used; std::nullopt: none at present.
    std::optional<Guid> publisher(ano::TimePoint now) const noexcept;

private:
    /// If all messages seem old for this time, without a pause, the clock of the publisher was set back.
    static constexpr ano::Duration forget = std::chrono::seconds{5};

    Guid guid_{};
    bool has_publisher_ = false;
    std::int64_t least_delay_ns_ = 0;
    ano::TimePoint used_at_{}, heard_at_{};
    std::optional<ano::TimePoint> old_since_;    // the first of consecutive old messages
};

}    // namespace anogate
