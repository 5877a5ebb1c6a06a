// A frame as JSON, and back.
//
//   {"from": 220, "to": 254, "id": 3, "name": "euler", "fields": {"rol": 1.23, ...}, "extra": "hex", "data": "hex"}
//
// `extra` contains the bytes after the layout. `data` replaces `fields` if the frame has no known layout, and is added to them if
// they can't restore the bytes exactly. If both are given, `data` is encoded, so that every frame is restored unchanged.
#pragma once
#include <ano/flexible.hpp>
#include <ano/frame.hpp>
#include <ano/reading.hpp>
#include <ano/values.hpp>
#include <ano_json/text.hpp>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace ano {

/// Keys are in the order of the table.
using Json = nlohmann::ordered_json;

class JsonWriter;

struct JsonOptions {
    const FlexibleLayouts* flexible = nullptr;    // layouts of flexible messages
    Encoding encoding = Encoding::utf8;           // of texts on the wire
    ValueType7 value_type_7 = ValueType7::f32;    // the meaning of value type 7 of commands
};

/// Converts any frame; never fails.
Json frame_to_json(FrameView frame, const JsonOptions& options = {});

/// The same as text: writes the members of an object that is open in `out`. More members may follow.
void write_frame(FrameView frame, const JsonOptions& options, JsonWriter& out);
/// Only the members of `fields`; `reading` must have fields. `without_null`: omits members that are null.
void write_fields(const Reading& reading, const JsonOptions& options, JsonWriter& out, bool without_null = false);
/// Only the value of `field`, one of reading.fields().
void write_value(const Reading& reading, const Field& field, const JsonOptions& options, JsonWriter& out);
/// The bytes in the last field of a tunnel frame that belong to no frame: `data` in its fields.
std::string hex_between_frames(const Reading& tunnel);

/// A fault in the JSON of a frame.
struct JsonFault {
    std::string pointer;    // the place: "/fields/rol"
    std::string what;       // for the user, one line; names the field
};

/// The complete frame, HEAD to AC. Defaults: `from` is 254, `to` is 255; `name` or `id` is required. A number may be replaced by
/// a text with a number as in C ("0xDC"), or by its word ("airborne", "flight controller"). `value` of a parameter and `values`
/// of a command may be typed: "f32:1.5", "u16:100,i32:-5". A `value` with fewer bytes than devices would read is refused;
/// `par_type` beside it specifies its type and is not sent. The keys `time`, `link`, `peer`, `direction` and `cause`, which the
/// gateway adds to displayed frames, are ignored.
std::variant<std::vector<std::uint8_t>, JsonFault> frame_from_json(const Json& json, const JsonOptions& options = {});

/// DATA of message `id` from the object of its fields, in the first layout that has all of them (the base layout first). `source`
/// is used only for flexible messages.
std::variant<std::vector<std::uint8_t>, JsonFault> data_from_json(std::uint8_t id, std::uint8_t source, const Json& fields,
                                                                  const JsonOptions& options = {});

/// The address for `word`: a number, or a name ("host", "flight controller"); otherwise a fault.
std::variant<std::uint8_t, JsonFault> address_called(std::string_view word);

/// The id for `word`: the name of a message, or a number; otherwise a fault with the nearest name.
std::variant<std::uint8_t, JsonFault> message_id(std::string_view word);

}    // namespace ano
