// A frame as JSON, and back.
//
//   {"from": 220, "to": 254, "id": 3, "name": "euler", "fields": {"rol": 1.23, ...}, "extra": "hex", "data": "hex"}
//
// `extra` has the bytes after the layout. `data` is given without `fields` when the frame has no known layout, and in addition to them
// when they can't restore the bytes exactly. If both are given, `data` is encoded, so that every frame comes back unchanged.
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
    Encoding encoding = Encoding::utf8;           // of text on the wire
    ValueType7 value_type_7 = ValueType7::f32;    // the meaning of value type 7 of commands
};

/// Never fails, whatever the frame holds.
Json frame_to_json(FrameView frame, const JsonOptions& options = {});

/// The same as text: the members of an object that is open in `out`. Others may follow.
void write_frame(FrameView frame, const JsonOptions& options, JsonWriter& out);
/// Only the members of `fields`; `reading` must have fields. `without_null`: none of those that are null.
void write_fields(const Reading& reading, const JsonOptions& options, JsonWriter& out, bool without_null = false);
/// Only the value of `field`, one of reading.fields().
void write_value(const Reading& reading, const Field& field, const JsonOptions& options, JsonWriter& out);
/// The bytes in the last field of a tunnel that are no frame: `data` in its fields.
std::string hex_between_frames(const Reading& tunnel);

/// What is wrong with the JSON of a frame.
struct JsonFault {
    std::string pointer;    // where: "/fields/rol"
    std::string what;       // for the user, one line; names the field
};

/// The whole frame, HEAD to AC. `from` is 254 and `to` is 255 where not given; `name` or `id` must be. In place of a
/// number there may be a number as text, written as in C ("0xDC"), or the word for it ("airborne", "flight controller").
/// `value` of a parameter and `values` of a command may be typed: "f32:1.5", "u16:100,i32:-5". A `value` with fewer bytes
/// than devices would read is refused; `par_type` beside it tells its type and is not sent. The keys
/// `time`, `link`, `peer`, `direction` and `cause`, which the gateway adds to frames that it shows, are ignored.
std::variant<std::vector<std::uint8_t>, JsonFault> frame_from_json(const Json& json, const JsonOptions& options = {});

/// DATA of message `id` from the object of its fields, in the layout that has all of them (the base layout first).
/// `source` is used for flexible messages only.
std::variant<std::vector<std::uint8_t>, JsonFault> data_from_json(std::uint8_t id, std::uint8_t source, const Json& fields,
                                                                  const JsonOptions& options = {});

/// The address that `word` stands for: a number, or a name ("host", "flight controller"); otherwise a fault.
std::variant<std::uint8_t, JsonFault> address_called(std::string_view word);

/// The id that `word` stands for: the name of a message, or a number; otherwise a fault with the nearest name.
std::variant<std::uint8_t, JsonFault> message_id(std::string_view word);

}    // namespace ano
