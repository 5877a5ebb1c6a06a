// Makes what read.mjs reads: in FOLDER flight.mcap, flight-json.mcap, plain.mcap (which is not packed) and empty.mcap; cut.mcap, which was
// repaired; and flight.ndjson with what is in them, a line a frame or loss.
#include <ano/hex.hpp>
#include <ano_json/frame_json.hpp>
#include <record/csv.hpp>
#include <record/recording_repair.hpp>
#include <support/random.hpp>
#include <support/recorded.hpp>
#include <support/vectors.hpp>

#include <nlohmann/json.hpp>

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace {

using anogate::DecodedEncoding;
using anogate::Direction;
using support::KeptItem;

const anogate::RecordingHead head{"anogate test", 1'763'898'044'123'456'789, 1'234'567'890'123};

// Every golden vector some times, by two links; a loss now and then, and half way the clock is set back by an hour.
std::vector<KeptItem> flight() {
    constexpr std::size_t rounds = 20;
    constexpr std::uint64_t step_ns = 1'234'567, hour_ns = 3'600'000'000'000;
    support::Random random{1};
    std::vector<KeptItem> items;
    for (std::size_t round = 0; round < rounds; ++round) {
        for (const support::Vector& vector : support::golden_vectors()) {
            KeptItem item;
            item.time_ns = head.time_ns + items.size() * step_ns - (round * 2 >= rounds ? hour_ns : 0);
            item.boottime_ns = head.boottime_ns + items.size() * step_ns;
            item.link = random.of<std::string>({"fc", "地面站"});
            item.description = item.link == "fc" ? "serial /dev/ttyUSB0" : "";
            item.direction = random.one_in(4) ? random.of({Direction::out, Direction::dropped}) : Direction::in;
            if (item.direction == Direction::dropped) item.cause = "limited";
            if (random.one_in(2)) item.channel = static_cast<std::uint8_t>(random.below(256u));
            if (item.channel) item.peer = "192.168.1.20:6000";
            item.frame = vector.bytes;
            items.push_back(item);
            if (!random.one_in(50)) continue;
            KeptItem loss;
            loss.lost = 1 + random.below(1000u);
            loss.names = "euler " + std::to_string(loss.lost);
            items.push_back(loss);
        }
    }
    if (items.back().frame.empty()) items.pop_back();    // a loss is written with the next frame, or at the end
    return items;
}

std::string written(const std::vector<KeptItem>& items, anogate::RecordingOptions options, std::size_t often, bool end = true) {
    std::string file;
    const auto writer = anogate::make_recording_writer(anogate::RecordingFormat::mcap, head, file, options);
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (items[i].frame.empty()) writer->write(anogate::RecordedLoss{items[i].lost, items[i].names});
        else writer->write(support::frame_of(items[i]), file);
        if ((i + 1) % often == 0) writer->flush(file);
    }
    if (end) writer->end(file);
    else writer->flush(file);
    return file;
}

std::string hex_of(const support::Bytes& bytes) {
    std::string hex;
    for (const std::uint8_t byte : bytes) hex += ano::hex_byte(byte).substr(2);
    return hex;
}

// Numbers of 64 bits as text: JavaScript would round them.
std::string truth_of(const KeptItem& item) {
    if (item.frame.empty()) return ano::Json{{"lost", item.lost}, {"names", item.names}}.dump();
    const ano::Json decoded = ano::Json::parse(
        anogate::recorded_json(anogate::Recorded{support::frame_of(item)}, {.encoding = ano::Encoding::automatic}));
    return ano::Json{{"time", std::to_string(item.time_ns)},
                     {"boottime", std::to_string(item.boottime_ns)},
                     {"link", item.link},
                     {"description", item.description},
                     {"direction", static_cast<int>(item.direction)},
                     {"cause", item.cause},
                     {"channel", item.channel ? int{*item.channel} : -1},
                     {"peer", item.peer},
                     {"hex", hex_of(item.frame)},
                     {"decoded", decoded}}
        .dump();
}

bool write_file(const std::string& path, const std::string& bytes) {
    std::ofstream file{path, std::ios::binary};
    return bool{file << bytes} && bool{file.flush()};
}

}    // namespace

int main(int count, char** words) {
    if (count != 2) return std::fputs("make_flight FOLDER\n", stderr), 2;
    const std::string folder = std::string{words[1]} + '/';
    const auto items = flight();
    std::string truth;
    for (const KeptItem& item : items) truth += truth_of(item) + '\n';
    constexpr std::size_t often = 400;
    std::string cut = written(items, {}, often, false) + std::string(1000, '\0');
    anogate::RecordingRepair repair{anogate::RecordingFormat::mcap};
    repair.feed(cut);
    const auto result = repair.finish();
    cut.resize(result.keep);
    const bool all =
        write_file(folder + "flight.ndjson", truth) && write_file(folder + "flight.mcap", written(items, {}, often)) &&
        write_file(folder + "flight-json.mcap", written(items, {.encoding = DecodedEncoding::json, .packed = true}, often)) &&
        write_file(folder + "plain.mcap", written(items, {.encoding = DecodedEncoding::cdr, .packed = false}, often)) &&
        write_file(folder + "empty.mcap", written({}, {}, often)) && write_file(folder + "cut.mcap", cut + result.append);
    return all ? 0 : 1;
}
