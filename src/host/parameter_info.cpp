#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <ano/wire.hpp>
#include <host/parameter_info.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <variant>

namespace ano::host {
namespace {

Request parameter_command(std::uint8_t cmd, std::uint16_t val, std::uint32_t tag) {
    Draft<"parameter_command"> draft;
    (void)draft.set<"cmd">(cmd);
    (void)draft.set<"val">(val);
    return request(draft, tag);
}

constexpr double max_step_part = 0.001;    // the largest deviation of a value from a multiple of its step, as a part of the step

std::optional<ParameterLayout> layout_of(const Message* row) noexcept {
    if (row == &View<"parameter_info">::message()) return ParameterLayout::typed;
    if (row == &View<"parameter_info", "old">::message()) return ParameterLayout::ranged;
    if (row == &View<"parameter_info", "scaled">::message()) return ParameterLayout::scaled;
    return std::nullopt;
}

const Message* matching_layout(FrameView frame) noexcept {
    constexpr std::uint8_t id = id_of<"parameter_info">;
    return frame.id() == id ? select_layout(layouts_of(id), frame.data()) : nullptr;
}

template <Name Label>
ParameterInfo older_info(Bytes data, ParameterLayout layout) {
    const View<"parameter_info", Label> row{data};
    return {row.template get<"par_id">(),
            Type::i32,
            std::string{row.template get<"name">()},
            std::string{row.template get<"info">()},
            ParameterInfo::Limits{row.template get<"min">(), row.template get<"max">()},
            layout};
}

// std::nullopt: not a number.
std::optional<double> real_in(const AnyValue& value) noexcept {
    if (std::holds_alternative<std::string>(value)) return std::nullopt;
    return std::visit(
        []<class T>(const T& number) {
            if constexpr (std::is_same_v<T, std::string>) return 0.0;
            else return static_cast<double>(number);
        },
        value);
}

std::string shortest(double value) {
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}    // namespace

std::optional<ParameterInfo> parameter_info_in(FrameView frame, ParameterLayout layout) {
    const Bytes data = frame.data();
    if (frame.id() != id_of<"parameter_info">) return std::nullopt;
    switch (layout) {
    case ParameterLayout::ranged:
        if (data.size() < View<"parameter_info", "old">::message().fixed_size) return std::nullopt;
        return older_info<"old">(data, layout);
    case ParameterLayout::scaled: {
        if (data.size() < View<"parameter_info", "scaled">::message().fixed_size) return std::nullopt;
        auto info = older_info<"scaled">(data, layout);
        info.mul = std::max(View<"parameter_info", "scaled">{data}.get<"mul">(), 1);    // 0: an integer
        return info;
    }
    case ParameterLayout::typed: break;
    }
    if (data.size() < View<"parameter_info">::message().fixed_size) return std::nullopt;
    const View<"parameter_info"> row{data};
    return ParameterInfo{row.get<"par_id">(), parameter_type(row.get<"par_type">()), std::string{row.get<"name">()},
                         std::string{row.get<"info">()}, std::nullopt};
}

std::optional<ParameterInfo> parameter_info_in(FrameView frame) {
    return parameter_info_in(frame, layout_of(matching_layout(frame)).value_or(ParameterLayout::typed));
}

std::optional<AnyValue> value_of(Bytes bytes, const ParameterInfo& info) {
    if (!info.type) return std::nullopt;
    auto value = value_of(bytes, *info.type);
    if (!value || !info.is_scaled()) return value;
    return AnyValue{*real_in(*value) / info.mul};
}

AnyValue nearest_value(const AnyValue& value, const ParameterInfo& info) {
    const auto number = real_in(value);
    if (!info.is_scaled() || !number || !std::isfinite(*number)) return value;
    return std::round(*number * info.mul) / info.mul;
}

Misfit append(std::vector<std::uint8_t>& out, const AnyValue& value, const ParameterInfo& info) {
    if (!info.type) return {"has_unknown_type"};
    const auto number = real_in(value);
    if (!info.is_scaled() || !number) return append(out, value, *info.type);
    const double steps = *number * info.mul, whole = std::round(steps);
    if (!(std::abs(whole) <= std::numeric_limits<std::int32_t>::max())) return {"out_of_range"};
    if (std::abs(steps - whole) > max_step_part) return {"not_a_multiple"};
    return append(out, AnyValue{static_cast<std::int64_t>(whole)}, *info.type);
}

Misfit with_range(const Misfit& misfit, const ParameterInfo& info) {
    if (misfit.empty() || !info.type) return misfit;
    if (!info.is_scaled()) return with_range(misfit, *info.type);
    if (misfit.is("not_a_multiple")) return {"not_a_multiple_of", shortest(1.0 / info.mul)};
    if (!misfit.is("out_of_range")) return misfit;
    return {"out_of_scale", shortest(double{std::numeric_limits<std::int32_t>::max()} / info.mul)};
}

bool same_bytes(const AnyValue& a, const AnyValue& b, const ParameterInfo& info) {
    std::vector<std::uint8_t> of_a, of_b;
    return append(of_a, a, info).empty() && append(of_b, b, info).empty() && of_a == of_b;
}

Misfit length_misfit(std::size_t size, std::size_t had, const ParameterInfo& info) {
    if (!info.type || *info.type == Type::text || size == had) return {};
    return {"other_length", size, had};
}

std::string unreadable_value(Bytes value, const ParameterInfo& info) {
    if (!info.type || *info.type == Type::text || value.empty() || value.size() == width(*info.type)) return {};
    return std::to_string(value.size()) + (value.size() == 1 ? " byte for " : " bytes for ") + std::string{name_of(*info.type)};
}

void LayoutVotes::count(FrameView description) noexcept {
    const Message* const row = matching_layout(description);
    const auto layout = layout_of(row);
    if (layout && is_plausible(*row, description.data())) ++votes_[static_cast<std::size_t>(*layout)];
}

ParameterLayout LayoutVotes::winner() const noexcept {
    return static_cast<ParameterLayout>(std::max_element(votes_.begin(), votes_.end()) - votes_.begin());
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

Found parameter_called(std::span<const ParameterInfo> all, std::string_view word) noexcept {
    const Found found = find_parameter(all, word);
    if (found.parameter != nullptr || found.several) return found;
    std::uint16_t id = 0;
    const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), id);
    if (ec != std::errc{} || end != word.data() + word.size() || id >= all.size()) return {};
    return {&all[id], false};
}

namespace question {

Request device_info(std::uint32_t tag) {
    Request question = parameter_command(0, 0, tag);
    question.patience.if_late = std::chrono::seconds{3};
    return question;
}
Request parameter_count(std::uint32_t tag) { return parameter_command(1, 0, tag); }
Request parameter_value(std::uint16_t id, std::uint32_t tag) { return parameter_command(2, id, tag); }
Request parameter_info(std::uint16_t id, std::uint32_t tag) { return parameter_command(3, id, tag); }

}    // namespace question
}    // namespace ano::host
