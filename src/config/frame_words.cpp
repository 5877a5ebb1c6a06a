#include <ano/messages.hpp>
#include <ano/traffic.hpp>
#include <ano_json/nearest.hpp>
#include <config/frame_words.hpp>
#include <config/key_facts.hpp>
#include <config/values.hpp>

#include <algorithm>
#include <charconv>

namespace anogate {
namespace {

constexpr double min_rate = 0.001, max_rate = 1'000'000;    // frames per second

std::vector<ByteRange> ids_of(ano::TrafficClass traffic) {
    std::vector<ByteRange> ranges;
    for (unsigned n = 0; n < 256; ++n) {
        const auto id = static_cast<std::uint8_t>(n);
        if (ano::traffic_class_of(id) != traffic) continue;
        if (!ranges.empty() && ranges.back().last + 1u == n) ranges.back().last = id;
        else ranges.push_back({id, id});
    }
    return ranges;
}

}    // namespace

std::optional<std::vector<ByteRange>> parse_frames(std::string_view text) {
    for (std::size_t i = 0; i < ano::traffic_class_names.size(); ++i)
        if (text == ano::traffic_class_names[i]) return ids_of(static_cast<ano::TrafficClass>(i));
    if (const ano::Message* message = ano::find_message(text)) return {{ByteRange{message->id, message->id}}};
    const auto range = parse_addresses(text);
    if (!range) return std::nullopt;
    return {{ByteRange{range->first, range->last}}};
}

std::vector<std::string_view> frame_words() {
    std::vector<std::string_view> words{ano::traffic_class_names.begin(), ano::traffic_class_names.end()};
    for (const ano::Message& message : ano::messages)
        if (std::find(words.begin(), words.end(), message.name) == words.end()) words.push_back(message.name);
    return words;
}

std::string meant_addresses(std::string_view text) {
    std::string meant;
    bool lacks_0x = false;
    for (const std::string_view number : split(text, '-')) {
        const std::string in_hex = ano::as_hex(number);
        lacks_0x = lacks_0x || !in_hex.empty();
        meant += meant.empty() ? "" : "-";
        if (!in_hex.empty()) meant += in_hex;
        else meant.append(number.starts_with("0x") ? "" : "0x").append(number);    // such as the 30 in 30-4F
    }
    return lacks_0x && parse_addresses(meant) ? " (did you mean '" + meant + "'?)" : "";
}

std::string meant_frames(std::string_view text) {
    const std::string meant = meant_addresses(text);
    return meant.empty() ? ano::did_you_mean(text, frame_words()) : meant;
}

std::string range_text(ByteRange range) {
    return address_text(range.first) + (range.last != range.first ? "-" + address_text(range.last) : "");
}

LimitText parse_limit(std::string_view name, std::string_view rate) {
    const auto ids = parse_frames(name);
    if (!ids || ids->size() != 1 || ids->front().first != ids->front().last)
        return {{},
                "a limit is for one id such as 0x01, or one message such as inertial, not for " + in_quotes(name) +
                    (ids ? ", which covers several" : meant_frames(name))};
    double value = 0;
    const auto [end, error] = std::from_chars(rate.data(), rate.data() + rate.size(), value);
    if (error != std::errc{} || end != rate.data() + rate.size() || !(value >= min_rate && value <= max_rate))
        return {{},
                in_quotes(name) + " must be a number of frames per second from 0.001 to 1000000, not " + in_quotes(rate) +
                    (rate == "0" ? "; to block them all: send.deny=" + std::string{name} : "")};
    return {LimitRule{ids->front().first, value}, {}};
}

std::string add_limit(const LimitRule& rule, std::vector<LimitRule>& limits) {
    const auto place = std::lower_bound(limits.begin(), limits.end(), rule.id,
                                        [](const LimitRule& known, std::uint8_t id) { return known.id < id; });
    if (place != limits.end() && place->id == rule.id) return address_text(rule.id) + " already has a limit";
    limits.insert(place, rule);
    return {};
}

}    // namespace anogate
