#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/config_error.hpp>
#include <config/frame_words.hpp>
#include <config/read_value.hpp>
#include <config/values.hpp>

#include <algorithm>
#include <cctype>

namespace anogate::read_value {
namespace {

using Milliseconds = std::chrono::duration<std::uint64_t, std::milli>;

bool has_control(std::string_view text) {
    for (std::size_t at = 0; at < text.size(); ++at)
        if (ano::control_size(text, at) > 0) return true;
    return false;
}
bool is_beyond_hex(char c) { return (c >= 'g' && c <= 'z') || (c >= 'G' && c <= 'Z'); }

/// For suggestions: the number in a text with a unit or multiple, such as 500k, 64KiB, 115200bps.
std::optional<std::uint64_t> without_unit(std::string_view text) {
    const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    if (digits == 0 || digits == text.size() || text.size() > digits + 4) return std::nullopt;
    const std::string unit{text.substr(digits)};
    if (const auto size = parse_size(text)) return size;
    if (unit == "k" || unit == "K" || unit == "M") return parse_size(std::string{text} + "B");
    return std::all_of(unit.begin(), unit.end(), [](char c) { return std::isalpha(static_cast<unsigned char>(c)); })
               ? parse_number(text.substr(0, digits))
               : std::nullopt;
}

/// The port of "12333", ":12333" or "*:12333", where the address is missing; else empty.
std::string_view port_alone(std::string_view text) {
    if (text.starts_with('*')) text.remove_prefix(1);
    if (text.starts_with(':')) text.remove_prefix(1);
    return parse_number(text).value_or(UINT64_MAX) <= UINT16_MAX ? text : std::string_view{};
}

/// Names the wrong part, address or port, if it can be determined.
std::string endpoint_error(const KeyFacts& key, std::string_view text) {
    const std::string shown = printable(std::string{text});
    const bool allows_names = key.form == Form::host;
    if (const auto address = IpAddress::parse(text)) {
        const std::string better = address->v6 ? "[" + shown + "]:PORT" : shown + ":PORT";
        return "'" + shown + "' has no port: write " + better;
    }
    if (const std::string port{port_alone(text)}; !port.empty()) {
        return "'" + shown + "' has no " + (allows_names ? "host name or IP address" : "IP address") + ": write " +
               (key.is_local ? "0.0.0.0:" + port + " for every interface" : (allows_names ? "HOST:" : "IP:") + port);
    }
    if (const std::size_t percent = text.find('%'), end = text.find(']'); percent < end && end != text.npos) {
        const std::string_view interface = text.substr(percent + 1, end - percent - 1);
        const auto plain = Endpoint::parse(std::string{text.substr(0, percent)}.append(text.substr(end)));
        if (plain && plain->address.is_link_local())
            return "'" + shown + "': " + in_quotes(interface) + " is not the name of a network interface";
        if (plain) return "'" + shown + "': only a link-local address (fe80::...) can have an interface";
    }
    const std::size_t colon = text.rfind(':');
    if (colon != text.npos && parse_number(text.substr(colon + 1)).value_or(0) > UINT16_MAX)
        return must_be(key, in_quotes(text)) + ": a port is at most 65535";
    const std::string_view host = text.substr(0, colon);
    const std::string port = colon == std::string_view::npos ? "PORT" : shown.substr(std::min(colon + 1, shown.size()));
    if (!allows_names && host.find_first_of(":[]%") == std::string_view::npos &&
        std::any_of(host.begin(), host.end(), is_beyond_hex))
        return "'" + shown + "': host names are not supported here; give an IP address such as 127.0.0.1:" + port;
    return must_be(key, in_quotes(text));
}

/// Sets `value` to `parsed` if it is from key.min to key.max.
std::string in_range(const KeyFacts& key, const std::string& word, std::optional<std::uint64_t> parsed, Value& value) {
    if (!parsed || *parsed < key.min || *parsed > key.max) return must_be(key, in_quotes(word));
    value = *parsed;
    return {};
}

std::string fault_of_text(const KeyFacts& key, const std::string& text) {
    if (!ano::is_utf8(text) || has_control(text))
        return in_quotes(key.name) + " must be printable text in UTF-8, not " + in_quotes(text);
    return {};
}

/// std::nullopt: not a network, or not one that `key` allows.
std::optional<Network> parse_network(const KeyFacts& key, const std::string& word) {
    const auto network = Network::parse(word);
    return network && !(key.is_v4 && network->address.v6) ? network : std::nullopt;
}

}    // namespace

std::string boolean(const KeyFacts& key, const Words& words, Value& value) {
    const auto parsed = parse_boolean(words[0]);
    if (!parsed) return must_be(key, in_quotes(words[0]));
    value = *parsed;
    return {};
}

std::string integer(const KeyFacts& key, const Words& words, Value& value) {
    std::string fault = in_range(key, words[0], parse_number(words[0]), value);
    if (fault.empty()) return fault;
    const auto meant = without_unit(words[0]);
    const bool fits = meant && *meant >= key.min && *meant <= key.max;
    return fits ? fault + " (did you mean '" + std::to_string(*meant) + "'?)" : fault;
}

std::string decimal(const KeyFacts& key, const Words& words, Value& value) {
    return in_range(key, words[0], parse_thousandths(words[0]), value);
}

std::string address(const KeyFacts& key, const Words& words, Value& value) {
    std::string fault = in_range(key, words[0], parse_address(words[0]), value);
    return fault.empty() ? fault : fault + ano::did_you_mean_hex(words[0]);
}

std::string can_id(const KeyFacts& key, const Words& words, Value& value) {
    std::string fault = in_range(key, words[0], parse_can_id(words[0]), value);
    return fault.empty() ? fault : fault + ano::did_you_mean_hex(words[0], 8);
}

std::string size(const KeyFacts& key, const Words& words, Value& value) {
    return in_range(key, words[0], parse_size(words[0]), value);
}

std::string addresses(const KeyFacts& key, const Words& words, Value& value) {
    const auto range = parse_addresses(words[0]);
    if (!range) return must_be(key, in_quotes(words[0])) + meant_addresses(words[0]);
    if (range->first < key.min || range->last > key.max) return must_be(key, in_quotes(words[0]));
    value = *range;
    return {};
}

std::string duration(const KeyFacts& key, const Words& words, Value& value) {
    const auto parsed = parse_duration(words[0]);
    if (!parsed || *parsed < Milliseconds{key.min} || *parsed > Milliseconds{key.max}) return must_be(key, in_quotes(words[0]));
    value = *parsed;
    return {};
}

std::string interval(const KeyFacts& key, const Words& words, Value& value) {
    if (const auto on = parse_boolean(words[0])) return value = *on, std::string{};
    return duration(key, words, value);
}

std::string silence(const KeyFacts& key, const Words& words, Value& value) {
    constexpr std::string_view silent = "silent ";
    if (!words[0].starts_with(silent) || !duration(key, {words[0].substr(silent.size())}, value).empty())
        return must_be(key, in_quotes(words[0]));
    return {};
}

std::string choice(const KeyFacts& key, const Words& words, Value& value) {
    const auto choices = split(key.choices, '|');
    if (std::find(choices.begin(), choices.end(), words[0]) == choices.end())
        return must_be(key, in_quotes(words[0])) + ano::did_you_mean(words[0], choices);
    value = words[0];
    return {};
}

std::string choice_or_link(const KeyFacts& key, const Words& words, Value& value) {
    const auto choices = split(key.choices, '|');
    if (std::find(choices.begin(), choices.end(), words[0]) != choices.end()) return value = words[0], std::string{};
    return text(key, words, value);
}

std::string text(const KeyFacts& key, const Words& words, Value& value) {
    if (std::string fault = fault_of_text(key, words[0]); !fault.empty()) return fault;
    if (words[0].size() < key.min || words[0].size() > key.max) return must_be(key, in_quotes(words[0]));
    value = words[0];
    return {};
}

std::string names(const KeyFacts& key, const Words& words, Value& value) {
    for (const std::string& name : words)
        if (std::string fault = text(key, {name}, value); !fault.empty()) return fault;
    value = words;
    return {};
}

std::string endpoint(const KeyFacts& key, const Words& words, Value& value) {
    auto parsed = EndpointSpec::parse(words[0]);
    if (!parsed) return endpoint_error(key, words[0]);
    value = *std::move(parsed);
    return {};
}

std::string host(const KeyFacts& key, const Words& words, Value& value) {
    auto parsed = HostSpec::parse(words[0]);
    if (!parsed && HostSpec::parse(words[0] + ":1")) return in_quotes(words[0]) + " has no port: write " + words[0] + ":PORT";
    if (!parsed) return endpoint_error(key, words[0]);
    value = *std::move(parsed);
    return {};
}

std::string networks(const KeyFacts& key, const Words& words, Value& value) {
    NetworkList list;
    list.any = words.size() == 1 && words[0] == "any";
    for (const std::string& word : list.any ? Words{} : words) {
        if (const auto network = parse_network(key, word)) list.networks.push_back(*network);
        else if (key.allows_host_names && is_host_name(word)) list.hosts.push_back(word);
        else return must_be(key, in_quotes(word));
    }
    value = std::move(list);
    return {};
}

std::string network(const KeyFacts& key, const Words& words, Value& value) {
    const auto parsed = parse_network(key, words[0]);
    if (!parsed && key.allows_host_names && is_host_name(words[0])) return value = words[0], std::string{};
    if (!parsed) return must_be(key, in_quotes(words[0]));
    value = *parsed;
    return {};
}

std::string ip(const KeyFacts& key, const Words& words, Value& value) {
    if (!key.choices.empty() && words[0] == key.choices) return value = words[0], std::string{};
    const auto parsed = IpAddress::parse(words[0]);
    if (!parsed && key.allows_host_names && is_host_name(words[0])) return value = words[0], std::string{};
    if (!parsed || parsed->v6 || (!key.choices.empty() && parsed->is_any())) return must_be(key, in_quotes(words[0]));
    value = *parsed;
    return {};
}

std::string frames(const KeyFacts& key, const Words& words, Value& value) {
    std::vector<ByteRange> ranges;
    for (const std::string& word : words) {
        const auto ids = parse_frames(word);
        if (!ids) return must_be(key, in_quotes(word)) + meant_frames(word);
        ranges.insert(ranges.end(), ids->begin(), ids->end());
    }
    value = std::move(ranges);
    return {};
}

std::string senders(const KeyFacts& key, const Words& words, Value& value) {
    std::vector<ByteRange> ranges;
    for (const std::string& word : words) {
        const auto range = parse_addresses(word);
        if (!range) return must_be(key, in_quotes(word)) + meant_addresses(word);
        ranges.push_back(*range);
    }
    value = std::move(ranges);
    return {};
}

std::string limit(const KeyFacts&, const Words& words, Value& value) {
    LimitText parsed = parse_limit(words[0], words[1]);
    if (!parsed.rule) return parsed.error;
    value = std::vector<LimitRule>{*parsed.rule};
    return {};
}

}    // namespace anogate::read_value
