#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>
#include <watch/record_json.hpp>

#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

// The names of links and peers may contain any bytes.
std::string text_of(const Json& json) { return ano::json_text(json); }

Json name_at(const std::vector<std::string>& names, std::size_t number) {
    return number < names.size() && !names[number].empty() ? Json(names[number]) : Json(nullptr);
}

Json list_of(const std::vector<std::string>& names) {
    Json list = Json::array();
    for (std::size_t i = 0; i < names.size(); ++i) list.push_back(name_at(names, i));
    return list;
}

}    // namespace

std::string record_json(const FrameRecord& record, const WatchTables& tables, const ano::FlexibleLayouts& flexible,
                        ano::Encoding encoding) {
    Json json = ano::frame_to_json(record.frame, {.flexible = &flexible, .encoding = encoding});
    const std::uint64_t microseconds = record.time_ns / 1000;
    json["time"] = static_cast<double>(microseconds) / 1e6;
    json["link"] = name_at(tables.links, record.link);
    if (record.channel != FrameRecord::no_channel) json["peer"] = name_at(tables.peers, record.channel);
    json["direction"] = text(record.direction);
    const auto causes = frame_causes();
    if (record.direction == Direction::dropped && record.cause < causes.size()) json["cause"] = causes[record.cause];
    if (record.is_elsewhere) json["elsewhere"] = true;
    return text_of(json);
}

std::string lost_json(const LostFrames& lost) {
    Json by_message = Json::object();
    for (unsigned n = 0; n < lost.by_id.size(); ++n) {
        if (lost.by_id[n] == 0) continue;
        const ano::Message* message = ano::find_message(static_cast<std::uint8_t>(n));
        by_message[message ? std::string{message->name} : ano::hex_byte(static_cast<std::uint8_t>(n))] = lost.by_id[n];
    }
    return text_of({{"lost", std::move(by_message)}, {"since_ms", lost.since.count()}});
}

std::string tables_json(const WatchTables& tables) {
    Json causes = Json::array();
    for (const std::string_view cause : frame_causes()) causes.push_back(cause.empty() ? Json(nullptr) : Json(cause));
    return text_of({{"links", list_of(tables.links)},
                    {"channels", list_of(tables.peers)},
                    {"causes", std::move(causes)},
                    {"decoding", tables.decoding ? Json::parse(tables.decoding->text()) : Json::object()}});
}

}    // namespace anogate
