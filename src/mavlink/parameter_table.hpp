// The parameters of a device as MAVLink carries them: names of at most 16 characters, values of at most 32 bits. No I/O, no clock.
#pragma once
#include <ano/schema.hpp>
#include <ano/wire.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mavlink {

/// A parameter as the gateway lists it.
struct DeviceParameter {
    std::string name{};
    ano::Type type = ano::Type::u8;
    std::optional<ano::Number> value{};    // std::nullopt: text, or it could not be read
};

/// Names of at most 16 characters. Longer ones are shortened: the first 11 characters, "~", and 4 digits that depend on the whole name,
/// so that they stay the same when other parameters are added. No two are equal.
std::vector<std::string> short_names(std::span<const std::string> names);

/// The bytes of a value of at most 32 bits in the field param_value, and back; std::nullopt: it does not fit.
std::optional<float> bytewise(ano::Type type, const ano::Number& value) noexcept;
std::optional<ano::Number> value_of(ano::Type type, float bytes) noexcept;

class ParameterTable {
public:
    struct Row {
        std::string id{};      // param_id
        std::string name{};    // on the device
        ano::Type type{};
        std::uint8_t type_number = 0;    // MAV_PARAM_TYPE
        float value = 0;                 // bytewise
    };

    ParameterTable() = default;
    explicit ParameterTable(std::span<const DeviceParameter> parameters);

    std::span<const Row> rows() const noexcept { return rows_; }
    /// Parameters that MAVLink can't carry, by name: text, and those of 64 bits.
    const std::vector<std::string>& left_out() const noexcept { return left_out_; }
    std::optional<std::size_t> find(std::string_view id) const noexcept;
    void set(std::size_t place, float value) noexcept { rows_[place].value = value; }

private:
    std::vector<Row> rows_;
    std::vector<std::string> left_out_;
};

}    // namespace anogate::mavlink
