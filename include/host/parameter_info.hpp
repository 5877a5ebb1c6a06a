// One parameter as a device describes it (0xE2).
#pragma once
#include <ano/frame.hpp>
#include <ano/schema.hpp>
#include <host/exchange.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ano::host {

struct ParameterInfo {
    struct Limits {
        std::int32_t min = 0, max = 0;
        friend bool operator==(const Limits&, const Limits&) = default;
    };

    std::uint16_t id = 0;
    std::optional<Type> type{};    // std::nullopt: of unknown type, and it can't be written
    std::string name{};            // as received, in whatever encoding the device uses; so is info
    std::string info{};
    std::optional<Limits> limits{};    // of an old device, which sends them in place of the type, and every value as i32
    friend bool operator==(const ParameterInfo&, const ParameterInfo&) = default;
};

/// The description in `frame`; std::nullopt when it is not a 0xE2, or too short for one.
std::optional<ParameterInfo> parameter_info_in(FrameView frame);

/// The parameter that a name stands for.
struct Found {
    const ParameterInfo* parameter = nullptr;    // null: none has this name, or several have it
    bool several = false;
};
Found find_parameter(std::span<const ParameterInfo> all, std::string_view name) noexcept;

/// The 0xE0 questions, whose answers are 0xE3, 0xE0, 0xE1 and 0xE2.
namespace question {
Request device_info(std::uint32_t tag);
Request parameter_count(std::uint32_t tag);
Request parameter_value(std::uint16_t id, std::uint32_t tag);
Request parameter_info(std::uint16_t id, std::uint32_t tag);
}    // namespace question

}    // namespace ano::host
