#include "typed_value.hpp"

#include <ano/schema.hpp>
#include <ano_json/text.hpp>

#include <host/parameter_info.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

std::optional<ano::Type> type_called(std::string_view name) {
    const auto* found = std::find(ano::type_names.begin(), ano::type_names.end(), name);
    if (found == ano::type_names.end()) return std::nullopt;
    return static_cast<ano::Type>(found - ano::type_names.begin());
}

}    // namespace

std::string misfit_of(const std::string& word, const std::string& type_name, std::int32_t mul) {
    const auto type = type_called(type_name);
    if (!ano::is_utf8(word)) return ano::in_quotes(word) + " is not UTF-8";
    if (!type || !ano::is_number(*type)) return {};
    const auto number = ano::parse_number(word);
    if (!number) return ano::in_quotes(word) + " is not a number";
    const auto* const real = std::get_if<double>(&*number);
    if (real != nullptr && !std::isfinite(*real)) return ano::in_quotes(word) + " is not a number that can be stored";
    std::vector<std::uint8_t> bytes;
    const auto value = std::visit([](auto plain) { return ano::host::AnyValue{plain}; }, *number);
    ano::host::ParameterInfo info;
    info.type = type;
    info.mul = mul;
    const ano::host::Misfit misfit = ano::host::with_range(ano::host::append(bytes, value, info), info);
    return misfit.empty() ? std::string{} : ano::in_quotes(word) + " " + misfit.text();
}

}    // namespace anoctl
