#include <ano_json/compact_json.hpp>
#include <ano_json/strict_json.hpp>
#include <record/recording_counts.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace anogate {
namespace {

using CountsJson = nlohmann::ordered_json;

constexpr double clock_step = 0.1;    // seconds; a larger difference between the clocks means that one was set

double seconds_between(std::uint64_t from, std::uint64_t to) {
    return to >= from ? static_cast<double>(to - from) / 1e9 : -static_cast<double>(from - to) / 1e9;
}

// Throws an exception of nlohmann::json if there is no such number.
std::uint64_t number_at(const CountsJson& json, const char* key) {
    const CountsJson& number = json.at(key);
    if (!number.is_number_unsigned()) throw std::invalid_argument{key};
    return number.get<std::uint64_t>();
}

CountsJson json_of(const std::map<std::string, std::uint64_t>& numbers) {
    CountsJson json = CountsJson::object();
    for (const auto& [name, number] : numbers) json[name] = number;
    return json;
}

std::map<std::string, std::uint64_t> numbers_of(const CountsJson& json) {
    std::map<std::string, std::uint64_t> numbers;
    for (const auto& [name, number] : json.items()) numbers[name] = number.get<std::uint64_t>();
    return numbers;
}

CountsJson json_of(const std::string& name, const LinkCounts& link) {
    return {{"name", name},          {"kind", link.description},  {"in", link.frames[0]},
            {"out", link.frames[1]}, {"dropped", link.frames[2]}, {"causes", json_of(link.causes)}};
}

CountsJson json_of(std::size_t id, const MessageCounts& message) {
    CountsJson from = CountsJson::array();
    for (std::size_t address = 0; address < message.from.size(); ++address)
        if (message.from[address]) from.push_back(address);
    return {{"id", id}, {"frames", message.frames}, {"bytes", message.bytes}, {"from", std::move(from)}};
}

}    // namespace

void RecordingCounts::add(const Recorded& item) {
    if (const auto* loss = std::get_if<RecordedLoss>(&item)) add(*loss);
    else add(std::get<RecordedFrame>(item));
}

void RecordingCounts::add(const RecordedFrame& frame) {
    if (frames++ == 0) {
        first = frame.time_ns;
        first_boottime = frame.boottime_ns;
    }
    last = frame.time_ns;
    last_boottime = frame.boottime_ns;
    const std::size_t size = frame.frame.bytes().size();
    bytes += size;
    LinkCounts& link = links[std::string{frame.link}];
    link.description = frame.link_description;
    ++link.frames[static_cast<std::size_t>(frame.direction)];
    if (frame.direction == Direction::dropped) ++link.causes[std::string{frame.cause}];
    MessageCounts& message = messages[frame.frame.id()];
    ++message.frames;
    message.bytes += size;
    message.from.set(frame.frame.source());
}

// `names` of the loss is a text such as "euler 120, inertial 120".
void RecordingCounts::add(const RecordedLoss& loss) {
    lost += loss.count;
    std::string_view rest = loss.names;
    while (!rest.empty()) {
        const std::string_view one = rest.substr(0, rest.find(", "));
        rest.remove_prefix(std::min(one.size() + 2, rest.size()));
        const auto blank = one.rfind(' ');
        std::uint64_t count = 0;
        if (blank == one.npos || std::from_chars(one.data() + blank + 1, one.data() + one.size(), count).ec != std::errc{})
            continue;
        lost_messages[std::string{one.substr(0, blank)}] += count;
    }
}

double RecordingCounts::seconds() const {
    if (frames == 0) return 0;
    if (first_boottime > 0 && last_boottime >= first_boottime) return seconds_between(first_boottime, last_boottime);
    return last >= first ? seconds_between(first, last) : 0;
}

double RecordingCounts::clock_was_set() const {
    if (first_boottime == 0 || last_boottime < first_boottime) return 0;
    const double by = seconds_between(first, last) - seconds();
    return std::abs(by) < clock_step ? 0 : by;
}

std::string RecordingCounts::json() const {
    CountsJson json{{"frames", frames},
                    {"bytes", bytes},
                    {"first", first},
                    {"last", last},
                    {"first_boottime", first_boottime},
                    {"last_boottime", last_boottime},
                    {"lost", lost},
                    {"lost_messages", json_of(lost_messages)},
                    {"links", CountsJson::array()},
                    {"messages", CountsJson::array()}};
    for (const auto& [name, link] : links) json["links"].push_back(json_of(name, link));
    for (std::size_t id = 0; id < messages.size(); ++id)
        if (messages[id].frames > 0) json["messages"].push_back(json_of(id, messages[id]));
    return ano::compact_json(json);
}

std::optional<RecordingCounts> RecordingCounts::of_json(std::string_view text) try {
    const auto strict = ano::strict_json<CountsJson>(text);
    if (!strict) return std::nullopt;
    const CountsJson& json = *strict;
    RecordingCounts counts;
    counts.frames = number_at(json, "frames");
    counts.bytes = number_at(json, "bytes");
    counts.first = number_at(json, "first");
    counts.last = number_at(json, "last");
    counts.first_boottime = number_at(json, "first_boottime");
    counts.last_boottime = number_at(json, "last_boottime");
    counts.lost = number_at(json, "lost");
    counts.lost_messages = numbers_of(json.at("lost_messages"));
    for (const CountsJson& one : json.at("links")) {
        LinkCounts& link = counts.links[one.at("name").get<std::string>()];
        link.description = one.at("kind").get<std::string>();
        link.frames = {number_at(one, "in"), number_at(one, "out"), number_at(one, "dropped")};
        link.causes = numbers_of(one.at("causes"));
    }
    for (const CountsJson& one : json.at("messages")) {
        MessageCounts& message = counts.messages.at(static_cast<std::size_t>(number_at(one, "id")));
        message.frames = number_at(one, "frames");
        message.bytes = number_at(one, "bytes");
        for (const CountsJson& address : one.at("from")) message.from.set(static_cast<std::size_t>(address.get<std::uint64_t>()));
    }
    return counts;
} catch (const std::exception&) {
    return std::nullopt;
}

}    // namespace anogate
