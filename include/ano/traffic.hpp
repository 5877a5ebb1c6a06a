// How a queue treats a frame, by its id: one load from a table of 512 bytes.
#pragma once
#include <ano/messages.hpp>

#include <array>
#include <cstdint>

namespace ano {
namespace table {

consteval std::array<Traffic, 256> traffic_by_id() {
    std::array<Traffic, 256> all{};    // not listed: bulk, replaces nothing
    for (const Message& row : messages) all[row.id] = row.traffic;
    return all;
}
inline constexpr std::array<Traffic, 256> traffic = traffic_by_id();

}    // namespace table

/// Protocol text, section 5.
constexpr Traffic traffic_of(std::uint8_t id) noexcept { return table::traffic[id]; }
constexpr TrafficClass traffic_class_of(std::uint8_t id) noexcept { return table::traffic[id].traffic_class; }

}    // namespace ano
