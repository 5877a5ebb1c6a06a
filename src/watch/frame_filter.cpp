#include <ano_json/frame_json.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/frame_words.hpp>
#include <config/key_facts.hpp>
#include <config/values.hpp>
#include <watch/frame_filter.hpp>

#include <algorithm>
#include <charconv>

namespace anogate {
namespace {

using Bytes = FrameFilterSettings::Bytes;

constexpr std::string_view filter_names[] = {"from",    "to",        "id",    "link",   "direction",
                                             "samples", "elsewhere", "batch", "format", "raw"};
constexpr std::string_view limit_name = "limit.";
constexpr std::string_view directions[] = {"in", "out", "dropped"};

// The error of a filter; empty: none.
using Fault = std::string;

std::string is_not(std::string_view name, std::string_view word, const std::string& what) {
    return std::string{name} + "=" + ano::in_quotes(word) + " " + what;
}

/// Adds to the set. `given`: whether the name had values before; until then the set contains all.
void add(Bytes& set, bool given, ByteRange range) {
    if (!given) set.reset();
    for (unsigned n = range.first; n <= range.last; ++n) set.set(n);
}

Fault read_address(std::string_view name, std::string_view word, bool given, Bytes& set) {
    if (const auto range = parse_addresses(word)) return add(set, given, *range), Fault{};
    const auto address = ano::address_called(word);
    if (const auto* fault = std::get_if<ano::JsonFault>(&address)) return std::string{name} + ": " + fault->what;
    const auto one = std::get<std::uint8_t>(address);
    return add(set, given, {one, one}), Fault{};
}

Fault read_id(std::string_view word, bool given, Bytes& set) {
    const auto ranges = parse_frames(word);
    if (!ranges) return is_not("id", word, "is not an id, range of ids, message or class of messages" + meant_frames(word));
    for (const ByteRange& range : *ranges) {
        add(set, given, range);
        given = true;
    }
    return {};
}

std::string one_of(std::span<const std::string_view> links) {
    std::string all;
    for (const std::string_view link : links) all.append(all.empty() ? "; use one of " : ", ").append(link);
    return all;
}

Fault read_link(std::string_view word, std::span<const std::string_view> links, std::vector<std::string>& chosen) {
    if (std::find(links.begin(), links.end(), word) == links.end())
        return "there is no link " + ano::in_quotes(word) + ano::did_you_mean(word, links) + one_of(links);
    if (std::find(chosen.begin(), chosen.end(), word) == chosen.end()) chosen.emplace_back(word);
    return {};
}

Fault read_direction(std::string_view word, bool given, std::array<bool, 3>& chosen) {
    const auto* const found = std::find(std::begin(directions), std::end(directions), word);
    if (found == std::end(directions))
        return is_not("direction", word, "is not in, out or dropped") + ano::did_you_mean(word, directions);
    if (!given) chosen = {};
    chosen[static_cast<std::size_t>(found - std::begin(directions))] = true;
    return {};
}

Fault read_format(std::string_view word, FrameFormat& format) {
    constexpr std::string_view formats[] = {"json", "binary"};
    if (word != "json" && word != "binary")
        return is_not("format", word, "is neither json nor binary") + ano::did_you_mean(word, formats);
    format = word == "binary" ? FrameFormat::binary : FrameFormat::json;
    return {};
}

Fault read_flag(std::string_view name, std::string_view word, bool& flag) {
    const auto given = parse_flag(name, word);
    if (given) flag = *given;
    return given ? Fault{} : given.error();
}

Fault read_batch(std::string_view word, ano::Duration& batch) {
    constexpr ano::Duration min_batch = std::chrono::milliseconds{1}, max_batch = std::chrono::seconds{1};
    const auto time = parse_duration(word);
    if (!time || *time < min_batch || *time > max_batch) return is_not("batch", word, "is not a time from 1ms to 1s");
    batch = *time;
    return {};
}

Fault read_samples(std::string_view word, unsigned& samples) {
    constexpr unsigned max_samples = 100;
    unsigned number = 0;
    const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (ec != std::errc{} || end != word.data() + word.size() || number < 1 || number > max_samples)
        return is_not("samples", word, "is not a number from 1 to 100");
    samples = number;
    return {};
}

Fault read_limit(std::string_view message, std::string_view rate, std::vector<LimitRule>& limits) {
    const LimitText limit = parse_limit(message, rate);
    return limit.rule ? add_limit(*limit.rule, limits) : limit.error;
}

class QueryReader {
public:
    explicit QueryReader(std::span<const std::string_view> links) : links_{links} {}

    Fault read(const http::Field& field) {
        if (field.name.starts_with(limit_name))
            return read_limit(std::string_view{field.name}.substr(limit_name.size()), field.value, query.filter.limit);
        const auto* const found = std::find(std::begin(filter_names), std::end(filter_names), field.name);
        if (found == std::end(filter_names))
            return "unknown filter " + ano::in_quotes(field.name) + ano::did_you_mean(field.name, filter_names) +
                   "; filters are from, to, id, link, direction, limit.ID, samples, elsewhere, batch, format and raw";
        if (field.name == "raw" && field.value.empty()) return query.filter.raw = true, Fault{};
        if (field.value.empty()) return field.name + "= has no value: omit it";
        bool& given = given_[static_cast<std::size_t>(found - std::begin(filter_names))];
        for (const std::string_view word : split(field.value, ',')) {
            if (Fault fault = read(field.name, word, given); !fault.empty()) return fault;
            given = true;
        }
        return {};
    }

    FrameQuery query;

private:
    Fault read(std::string_view name, std::string_view word, bool given) {
        FrameFilterSettings& f = query.filter;
        if (name == "from") return read_address(name, word, given, f.from);
        if (name == "to") return read_address(name, word, given, f.to);
        if (name == "id") return read_id(word, given, f.ids);
        if (name == "link") return read_link(word, links_, f.links);
        if (name == "direction") return read_direction(word, given, f.directions);
        if (name == "samples") return read_samples(word, f.samples);
        if (name == "elsewhere") return read_flag(name, word, f.elsewhere);
        if (name == "raw") return read_flag(name, word, f.raw);
        if (name == "batch") return read_batch(word, f.batch);
        return read_format(word, query.format);
    }

    std::span<const std::string_view> links_;
    std::array<bool, std::size(filter_names)> given_{};
};

}    // namespace

Expected<bool> parse_flag(std::string_view name, std::string_view value) {
    constexpr std::string_view words[] = {"yes", "no"};
    if (value.empty() || value == "yes" || value == "no") return value != "no";
    return Unexpected{is_not(name, value, "is neither yes nor no") + ano::did_you_mean(value, words)};
}

std::variant<FrameQuery, std::string> parse_frame_query(std::span<const http::Field> query,
                                                        std::span<const std::string_view> links) {
    QueryReader reader{links};
    for (const http::Field& field : query)
        if (Fault fault = reader.read(field); !fault.empty()) return fault;
    return reader.query;
}

namespace {

bool accepts_all(FrameFilterSettings settings) {
    settings.directions = {true, true, true};
    settings.batch = FrameFilterSettings{}.batch;
    settings.elsewhere = true;
    settings.raw = false;
    return settings == FrameFilterSettings{};
}

}    // namespace

FrameFilter::FrameFilter(const FrameFilterSettings& settings)
    : ids_{settings.ids},
      from_{settings.from},
      to_{settings.to},
      accepts_all_{accepts_all(settings)},
      elsewhere_{settings.elsewhere},
      directions_{settings.directions} {
    if (settings.samples > 0) samples_ = std::make_unique<FrameSamples>(settings.samples);
    if (settings.limit.empty()) return;
    limits_ = std::make_unique<std::array<Limit, 3>>();
    for (Limit& limit : *limits_)
        for (const LimitRule& rule : settings.limit) limit.set(rule.id, rule.per_second);
}

}    // namespace anogate
