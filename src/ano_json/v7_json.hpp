// A frame of the previous protocol version, V7, as JSON, and back.
//
//   {"to": 175, "id": 3, "name": "euler", "fields": {"rol": 1.23, ...}, "extra": "hex", "data": "hex"}
//
// As in frame_json.hpp; there is no `from`. The names are those of V7's messages.
#pragma once
#include <ano/v7.hpp>
#include <ano_json/frame_json.hpp>

#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

namespace ano {

/// Converts any frame; never fails.
Json v7_frame_to_json(v7::FrameView frame, const JsonOptions& options = {});

/// The complete frame, HEAD to AC. As frame_from_json(); `to` is 255 by default, and its words are those of V7 ("host" is 0xAF).
std::variant<std::vector<std::uint8_t>, JsonFault> v7_frame_from_json(const Json& json, const JsonOptions& options = {});

/// As data_from_json(), for messages of V7.
std::variant<std::vector<std::uint8_t>, JsonFault> v7_data_from_json(std::uint8_t id, const Json& fields,
                                                                     const JsonOptions& options = {});

/// The id for `word`: the name of a message of V7, or a number; otherwise a fault with the nearest name.
std::variant<std::uint8_t, JsonFault> v7_message_id(std::string_view word);

}    // namespace ano
