#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <host/parameter_info.hpp>

namespace ano::host {
namespace {

Request parameter_command(std::uint8_t cmd, std::uint16_t val, std::uint32_t tag) {
    Draft<"parameter_command"> draft;
    (void)draft.set<"cmd">(cmd);
    (void)draft.set<"val">(val);
    return request(draft, tag);
}

}    // namespace

std::optional<ParameterInfo> parameter_info_in(FrameView frame) {
    if (const auto old = as<"parameter_info", "old">(frame))
        return ParameterInfo{old->get<"par_id">(), Type::i32, std::string{old->get<"name">()}, std::string{old->get<"info">()},
                             ParameterInfo::Limits{old->get<"min">(), old->get<"max">()}};
    if (const auto said = as<"parameter_info">(frame))
        return ParameterInfo{said->get<"par_id">(), parameter_type(said->get<"par_type">()), std::string{said->get<"name">()},
                             std::string{said->get<"info">()}, std::nullopt};
    return std::nullopt;
}

Found find_parameter(std::span<const ParameterInfo> all, std::string_view name) noexcept {
    Found found;
    if (name.empty()) return found;
    for (const ParameterInfo& one : all) {
        if (one.name != name) continue;
        if (found.parameter != nullptr) return {nullptr, true};
        found.parameter = &one;
    }
    return found;
}

namespace question {

Request device_info(std::uint32_t tag) { return parameter_command(0, 0, tag); }
Request parameter_count(std::uint32_t tag) { return parameter_command(1, 0, tag); }
Request parameter_value(std::uint16_t id, std::uint32_t tag) { return parameter_command(2, id, tag); }
Request parameter_info(std::uint16_t id, std::uint32_t tag) { return parameter_command(3, id, tag); }

}    // namespace question
}    // namespace ano::host
