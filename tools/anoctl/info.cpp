// anoctl info FILE: what a recording holds.
#include "anoctl.hpp"
#include "counted.hpp"
#include "recording_input.hpp"
#include "table.hpp"

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bitset>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;
using anogate::Direction;
using anogate::RecordedFrame;
using anogate::RecordedLoss;

constexpr double second_ns = 1e9;
constexpr double clock_step = 0.1;    // seconds between both clocks, from which on one of them was set

struct LinkPart {
    std::string description;
    std::array<std::uint64_t, 3> frames{};    // by Direction
    std::map<std::string, std::uint64_t> causes;
};

struct MessagePart {
    std::uint64_t frames = 0, bytes = 0;
    std::bitset<256> from;
};

/// What all items of a recording come to.
class Summary {
public:
    void add(const anogate::Recorded& item) {
        if (const auto* loss = std::get_if<RecordedLoss>(&item)) add(*loss);
        else add(std::get<RecordedFrame>(item));
    }

    double seconds() const {
        if (frames == 0) return 0;
        if (first_boot_ > 0 && last_boot_ >= first_boot_) return static_cast<double>(last_boot_ - first_boot_) / second_ns;
        return last >= first ? static_cast<double>(last - first) / second_ns : 0;
    }
    /// By how much the clock was set meanwhile, seconds; 0: it was not.
    double clock_was_set() const {
        if (first_boot_ == 0 || last_boot_ < first_boot_) return 0;
        const double by = (static_cast<double>(last) - static_cast<double>(first)) / second_ns - seconds();
        return std::abs(by) < clock_step ? 0 : by;
    }
    double rate(std::uint64_t number) const { return seconds() > 0 ? static_cast<double>(number) / seconds() : 0; }

    std::uint64_t frames = 0, bytes = 0, lost = 0;
    std::uint64_t first = 0, last = 0;    // ns since 1970
    std::map<std::string, LinkPart> links;
    std::array<MessagePart, 256> messages;
    std::map<std::string, std::uint64_t> lost_messages;

private:
    void add(const RecordedFrame& frame) {
        if (frames++ == 0) {
            first = frame.time_ns;
            first_boot_ = frame.boottime_ns;
        }
        last = frame.time_ns;
        last_boot_ = frame.boottime_ns;
        bytes += frame.frame.bytes().size();
        LinkPart& link = links[std::string{frame.link}];
        link.description = frame.link_description;
        ++link.frames[static_cast<std::size_t>(frame.direction)];
        if (frame.direction == Direction::dropped) ++link.causes[std::string{frame.cause}];
        MessagePart& message = messages[frame.frame.id()];
        ++message.frames;
        message.bytes += frame.frame.bytes().size();
        message.from.set(frame.frame.source());
    }
    // "euler 120, inertial 120"
    void add(const RecordedLoss& loss) {
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

    std::uint64_t first_boot_ = 0, last_boot_ = 0;
};

std::string name_of_message(std::uint8_t id) {
    const ano::Message* message = ano::find_message(id);
    return message ? std::string{message->name} : "-";
}

std::string date_text(std::uint64_t ns) {
    const auto seconds = static_cast<std::time_t>(ns / 1'000'000'000);
    std::tm local{};
    localtime_r(&seconds, &local);
    std::array<char, 64> text{};
    const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &local);
    std::snprintf(text.data() + size, text.size() - size, ".%03u", static_cast<unsigned>(ns / 1'000'000 % 1000));
    return text.data();
}

std::string rate_text(double rate) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), rate < 10 ? "%.2f" : "%.1f", rate);
    return text.data();
}

std::vector<std::string> sources_of(const MessagePart& message) {
    std::vector<std::string> all;
    for (unsigned a = 0; a < 256; ++a)
        if (message.from[a]) all.push_back(ano::hex_byte(static_cast<std::uint8_t>(a)));
    return all;
}

std::string joined(const std::vector<std::string>& words) {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
}

std::string joined(const std::map<std::string, std::uint64_t>& numbers) {
    std::vector<std::string> words;
    words.reserve(numbers.size());
    for (const auto& [name, number] : numbers) words.push_back(without_controls(name) + " " + std::to_string(number));
    return joined(words);
}

void show_links(const Summary& summary, Streams& streams) {
    Table table{{"LINK", "KIND", " IN", " OUT", " DROPPED", "WHY"}};
    for (const auto& [name, link] : summary.links)
        table.row({without_controls(name), without_controls(link.description), std::to_string(link.frames[0]),
                   std::to_string(link.frames[1]), std::to_string(link.frames[2]), joined(link.causes)});
    table.write(streams.out, {}, streams.terminal ? streams.width : 0);
}

void show_messages(const Summary& summary, Streams& streams) {
    Table table{{"ID", "MESSAGE", " FRAMES", " A SECOND", " BYTES", "FROM"}};
    for (unsigned id = 0; id < 256; ++id) {
        const MessagePart& message = summary.messages[id];
        if (message.frames == 0) continue;
        const auto byte = static_cast<std::uint8_t>(id);
        table.row({ano::hex_byte(byte), name_of_message(byte), std::to_string(message.frames),
                   rate_text(summary.rate(message.frames)), std::to_string(message.bytes), joined(sources_of(message))});
    }
    table.write(streams.out, {}, streams.terminal ? streams.width : 0);
}

void show(const std::string& file, const Summary& summary, const RecordingFacts& facts, Streams& streams) {
    std::ostream& out = streams.out;
    out << file << ": pcapng";
    if (!facts.head.program.empty()) out << " of " << without_controls(facts.head.program);
    out << ", " << counted(facts.size, "byte") << '\n' << counted(summary.frames, "frame");
    if (summary.frames > 0)
        out << " in " << time_text(summary.seconds()) << ", " << date_text(summary.first) << " to " << date_text(summary.last);
    out << '\n';
    if (summary.lost > 0) {
        out << counted(summary.lost, "frame") << (summary.lost == 1 ? " is" : " are")
            << " not in it: the gateway had no room for them";
        out << (summary.lost_messages.empty() ? "" : ": ") << joined(summary.lost_messages) << '\n';
    }
    if (const double by = summary.clock_was_set(); by != 0)
        out << "the clock was set " << (by < 0 ? "back" : "ahead") << " by " << time_text(std::abs(by)) << " meanwhile\n";
    for (const std::string& note : facts.notes()) out << note << '\n';
    if (summary.frames == 0) return;
    out << '\n';
    show_links(summary, streams);
    out << '\n';
    show_messages(summary, streams);
}

Json json_of(const std::string& file, const Summary& summary, const RecordingFacts& facts) {
    Json json{{"file", file},
              {"format", "pcapng"},
              {"program", facts.head.program},
              {"bytes", facts.size},
              {"ended", facts.has_end},
              {"frames", summary.frames},
              {"frame_bytes", summary.bytes},
              {"begin", anogate::json_seconds(summary.first)},
              {"end", anogate::json_seconds(summary.last)},
              {"seconds", summary.seconds()},
              {"clock_was_set", summary.clock_was_set()},
              {"lost", summary.lost},
              {"lost_messages", summary.lost_messages},
              {"foreign", facts.foreign},
              {"unread", facts.size - facts.read},
              {"fault", facts.fault.empty() ? Json(nullptr) : Json(facts.fault)},
              {"links", Json::array()},
              {"messages", Json::array()}};
    for (const auto& [name, link] : summary.links)
        json["links"].push_back({{"name", name},
                                 {"kind", link.description},
                                 {"in", link.frames[0]},
                                 {"out", link.frames[1]},
                                 {"dropped", link.frames[2]},
                                 {"causes", link.causes}});
    for (unsigned id = 0; id < 256; ++id) {
        const MessagePart& message = summary.messages[id];
        if (message.frames == 0) continue;
        Json from = Json::array();
        for (unsigned a = 0; a < 256; ++a)
            if (message.from[a]) from.push_back(a);
        json["messages"].push_back({{"id", id},
                                    {"name", name_of_message(static_cast<std::uint8_t>(id))},
                                    {"frames", message.frames},
                                    {"rate", summary.rate(message.frames)},
                                    {"bytes", message.bytes},
                                    {"from", std::move(from)}});
    }
    return json;
}

struct Info {
    std::string file;
    bool json = false;

    int run(Streams& streams) const {
        Summary summary;
        const RecordingFacts facts = read_recording(file, streams,
                                                    [&](const anogate::Recorded& item, const anogate::RecordingHead&) {
                                                        summary.add(item);
                                                        return true;
                                                    });
        if (json) streams.out << json_of(file, summary, facts).dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
        else show(file, summary, facts, streams);
        return facts.fault.empty() ? fine : failed;
    }
};

}    // namespace

Run add_info(Options& options) {
    const auto self = std::make_shared<Info>();
    options.push_back({"file", &self->file, "FILE",
                       "A recording; one that is still written is read as far as it goes; - is standard input", true});
    options.push_back({"--json", &self->json, "", "One JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
