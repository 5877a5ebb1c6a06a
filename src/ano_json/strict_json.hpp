// Parses JSON. Refuses duplicate keys, unlimited nesting, and bytes after a byte 0, which nlohmann-json accepts.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ano {

/// The maximum depth of nested arrays and objects.
inline constexpr std::size_t max_json_depth = 32;

/// `Document`: nlohmann::json or nlohmann::ordered_json. std::nullopt: not JSON; the reason is in `faults`. A duplicate key is a
/// fault as well, but the document is returned, so that the rest can be checked. Reading ends at the twentieth fault.
template <class Document>
std::optional<Document> strict_json(std::string_view text, bool with_comments, std::vector<JsonFault>& faults);

/// The same without comments; std::nullopt: not JSON, or a fault.
template <class Document>
std::optional<Document> strict_json(std::string_view text);

/// The body of a request, without comments; or the error, in a clause about `what`. `most_values` limits the values of the whole
/// document, for requests that clients without write access may send.
std::variant<nlohmann::ordered_json, std::string> json_body(std::string_view text, std::string_view what = "the body",
                                                            std::size_t most_values = SIZE_MAX);

}    // namespace ano
