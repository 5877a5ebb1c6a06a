// The keys of "record".
#include <ano_json/nearest.hpp>
#include <config/config_error.hpp>
#include <config/frame_words.hpp>
#include <config/key_rows.hpp>
#include <config/values.hpp>

#include <algorithm>

namespace anogate {
namespace {

using namespace key_rows;
using Rec = RecordSettings;

constexpr std::string_view directions[] = {"in", "out", "dropped"};

Value get_direction(const KeyFacts&, const RecordSettings& record) { return record.direction; }

std::string set_direction(const KeyFacts& key, Value value, RecordSettings& record) {
    auto& words = std::get<std::vector<std::string>>(value);
    if (words.empty()) return in_quotes(key.name) + " must list what to record: in, out, dropped";
    for (const std::string& word : words)
        if (std::find(std::begin(directions), std::end(directions), word) == std::end(directions))
            return in_quotes(key.name) + " has " + in_quotes(word) + ", which is not in, out or dropped" +
                   ano::did_you_mean(word, directions);
    record.direction = std::move(words);
    return {};
}

Value get_limit(const KeyFacts&, const RecordSettings& record) { return record.limit; }

std::string set_record_limit(const KeyFacts&, Value value, RecordSettings& record) {
    std::vector<LimitRule> limit = record.limit;
    for (const LimitRule& rule : std::get<std::vector<LimitRule>>(value))
        if (std::string wrong = add_limit(rule, limit); !wrong.empty()) return wrong;
    record.limit = std::move(limit);
    return {};
}

// A limit of a few bytes is probably a number without its unit: nearly all recordings would be deleted.
template <auto Field, std::uint64_t min_bytes>
constexpr Key<Rec> size_from(std::string_view name, std::string_view help) {
    Key<Rec> key = size<Field>(name, help);
    key.put = [](const KeyFacts& facts, Value value, RecordSettings& record) -> std::string {
        const std::uint64_t bytes = std::get<std::uint64_t>(value);
        if (bytes != 0 && bytes < min_bytes)
            return in_quotes(facts.name) + " must be 0 or at least " + size_text(min_bytes) + ", not " + std::to_string(bytes) +
                   " bytes: add a unit, such as 20GB";
        store(facts, std::move(value), record.*Field);
        return {};
    };
    return key;
}

constexpr std::uint64_t kB = 1000, MB = 1000 * kB;
constexpr std::uint64_t max_age = 3650 * day, max_in_memory = 3600 * second;

constexpr Key<Rec> record_rows[] = {
    boolean<&Rec::start>("start", "record from the start; no: only on request"),
    text<&Rec::folder>("folder", 0, max_path,
                       "the folder of the files; created if missing (default: /var/lib/anogate/recordings, for users "
                       "~/.local/state/anogate/recordings)") |
        as("PATH"),
    choice<&Rec::format>("format", "pcapng|mcap", "the file format"),
    choice<&Rec::message_encoding>("message_encoding", "cdr|json",
                                   "the encoding of decoded messages in MCAP: as in ROS 2, or JSON"),
    Key<Rec>{{.name = "direction",
              .form = Form::texts,
              .help = "what to record: in, out, dropped (default: in)",
              .min = 1,
              .max = max_name,
              .stands_for = "[in|out|dropped...]"},
             get_direction,
             set_direction},
    frames<&Rec::ids>("id", "record only these frames"),
    senders<&Rec::from>("from", "only from these addresses"),
    senders<&Rec::to>("to", "only to these addresses"),
    row<&Rec::links>({.name = "link", .form = Form::names, .help = "only on these links", .min = 1, .max = max_name}),
    Key<Rec>{{.name = "limit", .form = Form::limits, .help = "maximum frames per second to record of an id or message"},
             get_limit,
             set_record_limit},
    size_from<&Rec::rotate_size, 10 * kB>("rotate.size", "start a new file at this size; 0: never"),
    duration<&Rec::rotate_time>("rotate.time", second, max_age, "start a new file after this time (default: never)"),
    size_from<&Rec::keep_size, 100 * kB>("keep.size", "delete the oldest recordings above this total size; 0: no limit"),
    duration<&Rec::keep_age>("keep.age", second, max_age, "delete older recordings (default: never)"),
    size_from<&Rec::keep_free, MB>("keep.free", "delete the oldest recordings while less disk space is free; 0: never"),
    size_from<&Rec::free, MB>("free",
                              "disk space to keep free: recording stops below this plus 5 MB; 0: record until the disk "
                              "is full"),
    duration<&Rec::keep_last>(
        "keep_last", second, max_in_memory,
        "keep the frames of this time in memory, at most 16 MiB; they are saved on request, when a device logs a "
        "fault, and when a link is lost (default: none)"),
};

}    // namespace

Keys<RecordSettings> record_keys() noexcept { return record_rows; }

}    // namespace anogate
