// What both directions of the translation between V7 and V8 share: addresses, and DATA that differ (protocol-v7.md, sections 2, 4, 8).
#pragma once
#include <gateway/v7_translation.hpp>

#include <ano/wire.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate {

/// 0: V8 has none.
std::uint8_t v8_address_of(std::uint8_t v7_address) noexcept;
/// The same number if V7 has none of its own.
std::uint8_t v7_address_of(std::uint8_t v8_address) noexcept;

V7Acceleration usual_acceleration(std::uint8_t address) noexcept;

/// Rounded, and limited to the range of the type.
std::int16_t saturated(double value) noexcept;
/// Multiplies the three i16 at `first`.
void scale_axes(std::uint8_t* data, std::size_t first, double factor) noexcept;

/// Three i32 with the number for "no position". `in` and `out` may be the same.
void positions_in_mm(const std::uint8_t* in, std::uint8_t* out) noexcept;
void positions_in_cm(const std::uint8_t* in, std::uint8_t* out) noexcept;

/// val of 0xA1, rounded; std::nullopt: outside of an i32.
std::optional<std::int32_t> log_value_in_v7(const std::uint8_t* val) noexcept;

struct V7Distance {
    std::uint8_t direction = 0;
    std::uint16_t angle = 0;
    std::uint32_t cm = 0;
    void store(std::uint8_t* data) const noexcept;    // 7 bytes
};
/// Writes the DATA of 0x34 in V8 and returns their size. 0: V8 can't represent it. `v7` has 7 bytes.
std::size_t ranging_in_v8(V7Range range, const std::uint8_t* v7, std::uint8_t* data) noexcept;
/// The distance of a type from 0 to 6; std::nullopt: V7 has no such direction.
std::optional<V7Distance> distance_in_v7(V7Range range, std::uint8_t type, std::int32_t mm) noexcept;
/// A distance of type 100.
std::optional<V7Distance> scanned_distance_in_v7(V7Range range, const std::uint8_t* pair) noexcept;

inline constexpr std::size_t v7_command_size = 11;
inline constexpr std::uint8_t v8_scan = 100;    // the type of 0x34 with angles

/// Calls `send(V7Distance)` for each distance in the DATA of 0x34 and `refuse()` for each that V7 can't represent. `data` has 5 bytes or
/// more.
template <class Send, class Refuse>
void for_each_distance(V7Range range, std::span<const std::uint8_t> data, Send send, Refuse refuse) {
    const auto pass = [&](const std::optional<V7Distance>& distance) {
        if (distance) send(*distance);
        else refuse();
    };
    if (data[0] != v8_scan) {
        return pass(distance_in_v7(range, data[0], ano::load<std::int32_t>(data.data() + 1)));
    }
    for (std::size_t at = 1; at + 4 <= data.size(); at += 4) pass(scanned_distance_in_v7(range, data.data() + at));
}

}    // namespace anogate
