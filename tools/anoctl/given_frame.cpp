#include "given_frame.hpp"

#include "anoctl.hpp"
#include "json_file.hpp"

#include <ano/reading.hpp>
#include <ano/v7.hpp>
#include <ano_json/syntax_fault.hpp>
#include <ano_json/v7_json.hpp>

#include <nlohmann/json.hpp>

#include <span>
#include <sstream>
#include <utility>
#include <variant>

namespace anoctl {

using namespace ano;

namespace {

Field field_called(std::span<const Message> layouts, const std::string& name) {
    for (const Message& row : layouts)
        if (const Field* f = row.field(name)) return *f;
    return {};
}
// Numbers stay text: the encoder parses them, in C notation.
Json value(std::span<const Message> layouts, const std::string& name, const std::string& text) {
    const Field field = field_called(layouts, name);
    if (field.type == Type::text || field.type == Type::bytes || field.type == Type::ip) return text;
    if (text.starts_with('[')) return json_in_text(text, name);
    if (is_number(field.type) && field.count == 1 && text == "null") return nullptr;
    if (!is_number(field.type) || field.count == 1) return text;
    Json list = Json::array();    // 1,4,7
    std::istringstream parts{text};
    for (std::string part; std::getline(parts, part, ',');) list.push_back(part);
    return list;
}

std::uint8_t v7_id_of(const std::string& word) {
    const auto id = v7_message_id(word);
    if (const auto* fault = std::get_if<JsonFault>(&id)) throw UsageError{fault->what};
    return std::get<std::uint8_t>(id);
}

}    // namespace

std::vector<std::uint8_t> frame_bytes(const Json& json, const JsonOptions& options, const std::string& where, bool v7) {
    auto frame = v7 ? v7_frame_from_json(json, options) : frame_from_json(json, options);
    if (const auto* fault = std::get_if<JsonFault>(&frame)) throw UsageError{where + fault->what};
    return std::move(std::get<0>(frame));
}

void GivenFrame::add(Options& options, GivenFrame& given, const std::string& help) {
    options.push_back({"name", &given.name, "NAME", help, true});
    options.push_back({"fields", &given.fields, "FIELD=VALUE...",
                       "Field values, in the unit of the field or as names: cmd=action val=save. Omitted fields are 0 or empty. "
                       "With a type where the device defines the type: value=f32:1.5 values=u16:100,i32:-5"});
    options.push_back({"--from", &given.from, "ADDRESS", "Source address (default: 0xFE, the host)"});
    options.push_back({"--to", &given.to, "ADDRESS", "Destination address (default: 0xFF, broadcast)"});
    options.push_back({"--data", &given.data, "HEX", "Complete DATA in hex digits, instead of fields"});
}

std::vector<std::uint8_t> GivenFrame::bytes(const JsonOptions& options) const { return frame_bytes(json(), options, "", v7); }

Json GivenFrame::json() const {
    Json json{{"to", to}};
    if (!v7) json["from"] = from;
    const std::uint8_t id = v7 ? v7_id_of(name) : message_id_of(name);
    const auto layouts = v7 ? v7::layouts_of(id) : layouts_of(id);
    json["id"] = id;
    if (data) json["data"] = *data;
    if (data && !fields.empty()) throw UsageError{"--data gives the complete DATA and cannot be combined with FIELD=VALUE"};
    Json given = Json::object();
    for (const std::string& word : fields) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos || equals == 0) throw UsageError{in_quotes(word) + " is not FIELD=VALUE"};
        const std::string field = word.substr(0, equals);
        if (given.contains(field)) throw UsageError{in_quotes(field) + " is given twice"};
        given[field] = value(layouts, field, word.substr(equals + 1));
    }
    if (!given.empty() || !data) json["fields"] = std::move(given);
    return json;
}

}    // namespace anoctl
