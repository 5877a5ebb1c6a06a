// The words of a request's target: "/links/fc?ids=1,2".
#pragma once
#include <http/request.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Target {
    std::string_view path;     // from its first '/'; without that of "http://host/path"
    std::string_view query;    // behind the '?'
};
Target split(std::string_view target) noexcept;

/// "a b" for "a%20b"; nothing when a '%' is not followed by two hex digits, or stands for a zero byte. In a query a space may be '+'.
std::optional<std::string> percent_decoded(std::string_view text, bool plus_is_space = false);

/// "a=1&b" is {a: 1} and {b: nothing}, in their order; nothing when an encoding is bad.
std::optional<std::vector<Field>> parse_query(std::string_view query);

/// The target without what its query says under this name.
std::string without_query_value(std::string_view target, std::string_view name);

}    // namespace anogate::http
