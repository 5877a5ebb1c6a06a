// Parses JSON and refuses what nlohmann-json accepts: keys given twice, unlimited nesting, bytes behind a byte 0.
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

/// Of arrays and objects in each other.
inline constexpr std::size_t max_json_depth = 32;

/// `Document`: nlohmann::json or nlohmann::ordered_json. std::nullopt when it is not JSON, with why in `faults`. A key given twice is a
/// fault as well, and the document is returned, so that the rest can be checked. Reading ends with the twentieth fault.
template <class Document>
std::optional<Document> strict_json(std::string_view text, bool with_comments, std::vector<JsonFault>& faults);

/// The same without comments; std::nullopt: it is not JSON, or has a fault.
template <class Document>
std::optional<Document> strict_json(std::string_view text);

/// The body of a request, without comments; or what is wrong, in a clause about `what`. `most_values`: in the whole document, where anybody
/// may send one who may not change anything.
std::variant<nlohmann::ordered_json, std::string> json_body(std::string_view text, std::string_view what = "the body",
                                                            std::size_t most_values = SIZE_MAX);

}    // namespace ano
