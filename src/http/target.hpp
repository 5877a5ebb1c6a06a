// Parses the target of a request: "/links/fc?ids=1,2".
#pragma once
#include <http/request.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Target {
    std::string_view path;     // from the first '/'; "http://host" is removed
    std::string_view query;    // after the '?'
};
Target split(std::string_view target) noexcept;

/// "a b" for "a%20b"; std::nullopt if a '%' is not followed by two hex digits, or means a zero byte. In a query '+' may mean a space.
std::optional<std::string> percent_decoded(std::string_view text, bool plus_is_space = false);

/// "a=1&b" gives {a: "1"} and {b: ""}, in this order; std::nullopt if an encoding is bad.
std::optional<std::vector<Field>> parse_query(std::string_view query);

/// The target without the query parameter `name`.
std::string without_query_value(std::string_view target, std::string_view name);

}    // namespace anogate::http
