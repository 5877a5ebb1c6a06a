// One parameter as a device describes it (0xE2).
#pragma once
#include <ano/frame.hpp>
#include <ano/schema.hpp>
#include <host/exchange.hpp>
#include <host/value.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ano::host {

/// How a device describes its parameters; it describes all of them in the same way.
enum class ParameterLayout : std::uint8_t {
    typed,     // by their type
    ranged,    // by min and max; every value is an i32
    scaled,    // by min, max and mul; every value is an i32, multiplied by mul
};

struct ParameterInfo {
    struct Limits {
        std::int32_t min = 0, max = 0;
        friend bool operator==(const Limits&, const Limits&) = default;
    };

    std::uint16_t id = 0;
    std::optional<Type> type{};    // std::nullopt: the type is unknown, so the parameter is read-only
    std::string name{};            // as received, in the encoding of the device, like info
    std::string info{};
    std::optional<Limits> limits{};    // of an older device, in the unit of the value; ParameterWrite observes them
    ParameterLayout layout = ParameterLayout::typed;
    std::int32_t mul = 1;    // the number on the wire is the value times `mul`, which is at least 1

    bool is_scaled() const noexcept { return mul > 1; }
    friend bool operator==(const ParameterInfo&, const ParameterInfo&) = default;
};

/// The description in `frame`; std::nullopt if it is not a 0xE2, or too short for one.
std::optional<ParameterInfo> parameter_info_in(FrameView frame, ParameterLayout layout);
/// The same, in the layout that this frame suggests: another frame of the same device may disprove it.
std::optional<ParameterInfo> parameter_info_in(FrameView frame);

/// Like value_of() of value.hpp, for the value of this parameter: a scaled one is a double. std::nullopt if the type is not
/// known.
std::optional<AnyValue> value_of(Bytes bytes, const ParameterInfo& info);
/// A scaled value must be a multiple of 1 / mul, within a thousandth of that.
Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, const ParameterInfo& info);
Misfit with_range(const Misfit& misfit, const ParameterInfo& info);
bool same_bytes(const AnyValue& a, const AnyValue& b, const ParameterInfo& info);
/// The nearest number that append() accepts, for a number within the range; other values are returned unchanged.
AnyValue nearest_value(const AnyValue& value, const ParameterInfo& info);

/// Why the bytes that the device sent are not a value of this type ("4 bytes for u8"); empty: they are, or may be.
std::string unreadable_value(Bytes value, const ParameterInfo& info);

/// Why a number may not be written as a value of `size` bytes if the device sent `had` bytes, as a clause; empty: it may.
Misfit length_misfit(std::size_t size, std::size_t had, const ParameterInfo& info);

/// Determines the layout of a device from all its descriptions, since a single one may look like another layout.
class LayoutVotes {
public:
    void count(FrameView description) noexcept;
    /// The layout of most descriptions.
    ParameterLayout winner() const noexcept;
    void clear() noexcept { votes_ = {}; }

private:
    std::array<std::uint32_t, 3> votes_{};
};

/// The parameter that a name refers to.
struct Found {
    const ParameterInfo* parameter = nullptr;    // nullptr: none has this name, or several have it
    bool several = false;
};
Found find_parameter(std::span<const ParameterInfo> all, std::string_view name) noexcept;
/// The parameter with this name, or else with this number.
Found parameter_called(std::span<const ParameterInfo> all, std::string_view word) noexcept;

/// The 0xE0 questions, whose answers are 0xE3, 0xE0, 0xE1 and 0xE2.
namespace question {
Request device_info(std::uint32_t tag);
Request parameter_count(std::uint32_t tag);
Request parameter_value(std::uint16_t id, std::uint32_t tag);
Request parameter_info(std::uint16_t id, std::uint32_t tag);
}    // namespace question

}    // namespace ano::host
