// Limits of the values of a device, which AlarmWatch applies. The gateway stores them for all viewers. Pure.
#pragma once
#include <ano/flexible.hpp>

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

struct AlarmLimit {
    std::string field;    // "power.voltage": a message and one of its fields, in the unit of the message table
    bool is_below = false;
    std::optional<double> amber, red;
    std::optional<unsigned> cells;    // number of cells by which the value is divided
    double for_s = 0;                 // how long the value must be beyond it
    bool operator==(const AlarmLimit&) const = default;
};

class AlarmLimits {
public:
    using List = std::vector<AlarmLimit>;
    static constexpr std::size_t max_limits = 32;                     // of one device
    static constexpr std::size_t max_text = std::size_t{16} << 10;    // bytes of text()

    const List& of(std::uint8_t address) const noexcept { return lists_[address]; }
    void set(std::uint8_t address, List list) { lists_[address] = std::move(list); }
    /// A number that differs for other limits, also after a restart; 0: there are none.
    std::uint32_t version(std::uint8_t address) const;

    /// {"limits": [{"field", "side": "below" | "above", "amber", "red", "cells", "for_s"}, …]}; a string: the error.
    static std::variant<List, std::string> parse(const nlohmann::ordered_json& json);
    static nlohmann::ordered_json json(const List& list);
    /// The error for a field that is not one number in any frame of `source`, with the most similar names; empty: all fields
    /// exist.
    static std::string unknown_field(const List& list, std::uint8_t source, const ano::FlexibleLayouts& layouts);

private:
    std::array<List, 256> lists_;
};

/// "limits-0xDC.json": the file of a device.
std::string limits_file(std::uint8_t address);
/// std::nullopt: `name` is not exactly such a name.
std::optional<std::uint8_t> address_of_limits_file(std::string_view name);

}    // namespace anogate
