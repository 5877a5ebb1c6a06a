#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/json_writer.hpp>
#include <record/recording.hpp>
#include <watch/record_json.hpp>

#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

// The names of links and peers may contain any bytes.
std::string to_string(const Json& json) { return ano::json_text(json); }

// Empty: the number is not in use.
std::string_view name_at(const std::vector<std::string>& names, std::size_t number) {
    return number < names.size() ? std::string_view{names[number]} : std::string_view{};
}

Json list_of(const std::vector<std::string>& names) {
    Json list = Json::array();
    for (const std::string& name : names) list.push_back(name.empty() ? Json(nullptr) : Json(name));
    return list;
}

}    // namespace

std::string record_json(const FrameRecord& record, const WatchTables& tables, const ano::FlexibleLayouts& flexible,
                        ano::Encoding encoding) {
    std::string json;
    ano::JsonWriter out{json};
    const auto write_name = [&](std::string_view key, std::string_view name) {
        out.key(key);
        if (name.empty()) out.null();
        else out.text(name);
    };
    out.begin_object();
    ano::write_frame(record.frame, {.flexible = &flexible, .encoding = encoding}, out);
    out.key("time");
    out.number(json_seconds(record.time_ns));
    write_name("link", name_at(tables.links, record.link));
    if (record.channel != FrameRecord::no_channel) write_name("peer", name_at(tables.peers, record.channel));
    out.text("direction", text(record.direction));
    const auto causes = frame_causes();
    if (record.direction == Direction::dropped && record.cause < causes.size()) out.text("cause", causes[record.cause]);
    if (record.is_elsewhere) {
        out.key("elsewhere");
        out.boolean(true);
    }
    if (!record.raw.empty()) out.text("raw", ano::hex(record.raw));
    out.end_object();
    return ano::with_json_escapes(std::move(json));
}

std::string lost_json(const LostFrames& lost) {
    Json by_message = Json::object();
    for (unsigned n = 0; n < lost.by_id.size(); ++n) {
        if (lost.by_id[n] == 0) continue;
        const ano::Message* message = ano::find_message(static_cast<std::uint8_t>(n));
        by_message[message ? std::string{message->name} : ano::hex_byte(static_cast<std::uint8_t>(n))] = lost.by_id[n];
    }
    return to_string({{"lost", std::move(by_message)}, {"since_ms", lost.since.count()}});
}

std::string tables_json(const WatchTables& tables) {
    Json causes = Json::array();
    for (const std::string_view cause : frame_causes()) causes.push_back(cause.empty() ? Json(nullptr) : Json(cause));
    return to_string({{"links", list_of(tables.links)},
                      {"channels", list_of(tables.peers)},
                      {"causes", std::move(causes)},
                      {"decoding", tables.decoding ? Json::parse(tables.decoding->text()) : Json::object()}});
}

}    // namespace anogate
