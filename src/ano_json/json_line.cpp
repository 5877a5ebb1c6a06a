#include <ano_json/escapes.hpp>
#include <ano_json/json_line.hpp>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <utility>

namespace ano {
namespace {

constexpr std::int64_t max_exact = std::int64_t{1} << 53;

void keep_exact(nlohmann::ordered_json& json) {
    const bool is_beyond = json.is_number_unsigned()  ? json.get<std::uint64_t>() > std::uint64_t{max_exact}
                           : json.is_number_integer() ? json.get<std::int64_t>() < -max_exact
                                                      : false;
    if (is_beyond) json = json.dump();
    else if (json.is_structured())
        for (auto& value : json) keep_exact(value);
}

}    // namespace

std::string json_line(nlohmann::ordered_json json) {
    keep_exact(json);
    return json_text(json) + "\n";
}

}    // namespace ano
