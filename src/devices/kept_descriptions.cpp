#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <devices/kept_descriptions.hpp>
#include <devices/unit_note.hpp>

#include <nlohmann/json.hpp>

#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

namespace anogate {
namespace {

using RowJson = nlohmann::ordered_json;
using ano::host::ParameterInfo;
using ano::host::ParameterLayout;

constexpr int format_of_descriptions = 1;
constexpr int last_type = static_cast<int>(ano::Type::text), last_layout = static_cast<int>(ParameterLayout::scaled);

// Texts are stored as bytes of the device, in any encoding.
std::string hex_of_text(const std::string& text) {
    return ano::hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

RowJson row_json(const ParameterInfo& info) {
    RowJson row{{"type", info.type ? RowJson(static_cast<int>(*info.type)) : RowJson(nullptr)},
                {"name", hex_of_text(info.name)},
                {"info", hex_of_text(info.info)},
                {"layout", static_cast<int>(info.layout)},
                {"mul", info.mul}};
    if (info.limits) row["limits"] = {info.limits->min, info.limits->max};
    return row;
}

std::int32_t whole_in(const RowJson& json, std::int64_t least, std::int64_t most) {
    const auto number = json.get<std::int64_t>();
    if (!json.is_number_integer() || number < least || number > most) throw std::out_of_range{"a number of a description"};
    return static_cast<std::int32_t>(number);
}

std::string decode_hex(const RowJson& json) {
    const auto bytes = ano::from_hex(json.get<std::string>());
    if (!bytes) throw std::invalid_argument{"a text of a description"};
    return {bytes->begin(), bytes->end()};
}

ParameterInfo info_in_row(const RowJson& row, std::uint16_t id) {
    using Limits = std::numeric_limits<std::int32_t>;
    ParameterInfo info{.id = id, .name = decode_hex(row.at("name")), .info = decode_hex(row.at("info"))};
    if (!row.at("type").is_null()) info.type = static_cast<ano::Type>(whole_in(row.at("type"), 0, last_type));
    info.layout = static_cast<ParameterLayout>(whole_in(row.at("layout"), 0, last_layout));
    info.mul = whole_in(row.at("mul"), 1, Limits::max());
    if (row.contains("limits"))
        info.limits = {whole_in(row.at("limits").at(0), Limits::min(), Limits::max()),
                       whole_in(row.at("limits").at(1), Limits::min(), Limits::max())};
    return info;
}

}    // namespace

std::string descriptions_name(const WorkPlace& place) { return unit_note_name("descriptions", place, place.device.info()); }

std::string descriptions_text(const WorkPlace& place, const std::vector<ParameterInfo>& all) {
    RowJson json = unit_json(place, place.device.info());
    json["format"] = format_of_descriptions;
    json["descriptions"] = RowJson::array();
    for (const ParameterInfo& info : all) json["descriptions"].push_back(row_json(info));
    return ano::compact_json(json) + "\n";
}

std::optional<std::vector<ParameterInfo>> descriptions_in(const std::string& text, const WorkPlace& place,
                                                          std::uint16_t count) try {
    const RowJson json = note_json(text);
    if (json.is_null() || !misfit_of_note(text, place).empty() || json.at("format") != format_of_descriptions)
        return std::nullopt;
    const RowJson& rows = json.at("descriptions");
    if (!rows.is_array() || rows.size() != count) return std::nullopt;
    std::vector<ParameterInfo> all;
    for (const RowJson& row : rows) all.push_back(info_in_row(row, static_cast<std::uint16_t>(all.size())));
    return all;
} catch (const std::exception&) {
    return std::nullopt;
}

}    // namespace anogate
