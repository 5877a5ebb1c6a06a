// anoctl info FILE: shows the content of a recording.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/text/table.hpp>
#include "recording_input.hpp"

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;
using anogate::MessageCounts;
using anogate::RecordingCounts;

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

std::vector<std::string> sources_of(const MessageCounts& message) {
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

void show_links(const RecordingCounts& counts, Streams& streams) {
    Table table{{"LINK", "KIND", " IN", " OUT", " DROPPED", "WHY"}};
    for (const auto& [name, link] : counts.links)
        table.row({without_controls(name), without_controls(link.description), std::to_string(link.frames[0]),
                   std::to_string(link.frames[1]), std::to_string(link.frames[2]), joined(link.causes)});
    table.write(streams.out, {}, streams.terminal ? streams.width : 0);
}

void show_messages(const RecordingCounts& counts, Streams& streams) {
    Table table{{"ID", "MESSAGE", " FRAMES", " PER SECOND", " BYTES", "FROM"}};
    for (unsigned id = 0; id < 256; ++id) {
        const MessageCounts& message = counts.messages[id];
        if (message.frames == 0) continue;
        const auto byte = static_cast<std::uint8_t>(id);
        table.row({ano::hex_byte(byte), name_of_message(byte), std::to_string(message.frames),
                   rate_text(counts.rate(message.frames)), std::to_string(message.bytes), joined(sources_of(message))});
    }
    table.write(streams.out, {}, streams.terminal ? streams.width : 0);
}

/// "flexible1", "flexible2 from 30 when 3"
std::vector<std::string> flexible_ids(const anogate::Decoding& decoding) {
    std::vector<std::string> all;
    for (const ano::FlexibleSpec& spec : decoding.flexible()) {
        std::string& text = all.emplace_back(name_of_message(spec.id));
        if (spec.source) text += " from " + std::to_string(*spec.source);
        if (spec.when) text += " when " + std::to_string(*spec.when);
    }
    return all;
}

void show(const std::string& file, const RecordingCounts& counts, const RecordingFacts& facts, Streams& streams) {
    std::ostream& out = streams.out;
    out << file << ": " << text(facts.format);
    if (!facts.head.program.empty()) out << " of " << without_controls(facts.head.program);
    out << ", " << counted(facts.size, "byte") << '\n' << counted(counts.frames, "frame");
    if (counts.frames > 0)
        out << " in " << time_text(counts.seconds()) << ", " << date_text(counts.first) << " to " << date_text(counts.last);
    out << '\n';
    if (counts.lost > 0) {
        out << counted(counts.lost, "frame") << (counts.lost == 1 ? " is" : " are")
            << " missing: the buffer of the gateway was full";
        out << (counts.lost_messages.empty() ? "" : ": ") << joined(counts.lost_messages) << '\n';
    }
    if (const double by = counts.clock_was_set(); by != 0)
        out << "the clock was set " << (by < 0 ? "back" : "ahead") << " by " << time_text(std::abs(by)) << " meanwhile\n";
    for (const std::string& note : facts.notes()) out << note << '\n';
    if (facts.head.decoding && !facts.head.decoding->flexible().empty())
        out << "layouts of flexible messages: " << joined(flexible_ids(*facts.head.decoding)) << '\n';
    if (counts.frames == 0) return;
    out << '\n';
    show_links(counts, streams);
    out << '\n';
    show_messages(counts, streams);
}

Json json_of(const anogate::SkippedParts& skipped) {
    Json json{{"parts", skipped.count}, {"bytes", skipped.bytes}, {"frames", skipped.frames}, {"first", Json::array()}};
    for (const anogate::SkippedPart& part : skipped.first) {
        json["first"].push_back({{"at", part.at}, {"bytes", part.size}, {"why", part.why}});
        json["first"].back()["messages"] = part.messages ? Json(*part.messages) : Json(nullptr);
    }
    return json;
}

Json json_of(const std::string& file, const RecordingCounts& counts, const RecordingFacts& facts) {
    Json json{{"file", file},
              {"format", std::string{text(facts.format)}},
              {"program", facts.head.program},
              {"bytes", facts.size},
              {"ended", facts.has_end},
              {"frames", counts.frames},
              {"frame_bytes", counts.bytes},
              {"begin", anogate::json_seconds(counts.first)},
              {"end", anogate::json_seconds(counts.last)},
              {"seconds", counts.seconds()},
              {"clock_was_set", counts.clock_was_set()},
              {"lost", counts.lost},
              {"lost_messages", counts.lost_messages},
              {"foreign", facts.foreign},
              {"skipped", json_of(facts.skipped)},
              {"mismatches", facts.mismatches},
              {"unread", facts.size - facts.read},
              {"fault", facts.fault.empty() ? Json(nullptr) : Json(facts.fault)},
              {"decoding", facts.head.decoding ? Json::parse(facts.head.decoding->text()) : Json::object()},
              {"links", Json::array()},
              {"messages", Json::array()}};
    for (const auto& [name, link] : counts.links)
        json["links"].push_back({{"name", name},
                                 {"kind", link.description},
                                 {"in", link.frames[0]},
                                 {"out", link.frames[1]},
                                 {"dropped", link.frames[2]},
                                 {"causes", link.causes}});
    for (unsigned id = 0; id < 256; ++id) {
        const MessageCounts& message = counts.messages[id];
        if (message.frames == 0) continue;
        Json from = Json::array();
        for (unsigned a = 0; a < 256; ++a)
            if (message.from[a]) from.push_back(a);
        json["messages"].push_back({{"id", id},
                                    {"name", name_of_message(static_cast<std::uint8_t>(id))},
                                    {"frames", message.frames},
                                    {"rate", counts.rate(message.frames)},
                                    {"bytes", message.bytes},
                                    {"from", std::move(from)}});
    }
    return json;
}

struct Info {
    std::string file;
    bool json = false, all = false;

    int run(Streams& streams) const {
        IndexedRecording recording;
        if (auto indexed = all ? std::nullopt : read_index(file)) recording = std::move(*indexed);
        else
            recording.facts = read_recording(
                file, streams, [&](const anogate::Recorded& item, const anogate::RecordingHead&) { recording.counts.add(item); });
        const RecordingFacts& facts = recording.facts;
        if (json) streams.out << ano::json_text(json_of(file, recording.counts, facts)) << '\n';
        else show(file, recording.counts, facts, streams);
        return facts.is_damaged() ? failed : fine;
    }
};

}    // namespace

Run add_info(Options& options) {
    const auto self = std::make_shared<Info>();
    options.push_back({"file", &self->file, "FILE",
                       "Recording; a running recording is read up to its current end; - reads standard input", true});
    options.push_back({"--all", &self->all, "", "Read the whole file and report damaged parts, even if the file has an index"});
    options.push_back({"--json", &self->json, "", "Print one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
