#include <ano/hex.hpp>
#include <ano_json/json_writer.hpp>
#include <ano_json/v7_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>

namespace ano {

Json v7_frame_to_json(v7::FrameView frame, const JsonOptions& options) {
    const Reading reading = v7::read(frame, options.flexible);
    Json json{{"to", frame.destination()}, {"id", frame.id()}};
    if (reading.message() != nullptr) json["name"] = reading.message()->name;
    if (!reading) {
        json["data"] = hex(frame.data());
        return json;
    }
    std::string text;
    JsonWriter out{text};
    out.begin_object();
    write_fields(reading, options, out);
    out.end_object();
    json["fields"] = Json::parse(text);
    if (!reading.extra().empty()) json["extra"] = hex(reading.extra());
    const Bytes in_fields = frame.data().first(frame.data().size() - reading.extra().size());
    const auto again = v7_data_from_json(frame.id(), json["fields"], {options.flexible, Encoding::utf8, options.value_type_7});
    const auto* const data = std::get_if<std::vector<std::uint8_t>>(&again);
    if (data == nullptr || !std::equal(data->begin(), data->end(), in_fields.begin(), in_fields.end()))
        json["data"] = hex(frame.data());
    return json;
}

}    // namespace ano
