#include <ano_json/nearest.hpp>
#include <config/config_error.hpp>
#include <config/fields.hpp>

#include <algorithm>
#include <cctype>

namespace anogate {
namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }
bool is_beyond_hex(char c) { return (c >= 'g' && c <= 'z') || (c >= 'G' && c <= 'Z'); }

/// The bytes, baud or frames that a number with a unit or a multiple means: 500k, 64KiB, 115200bps.
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

/// "12333", ":12333" and "*:12333": every interface is meant, or was forgotten to be named.
std::string_view port_alone(std::string_view text) {
    if (text.starts_with('*')) text.remove_prefix(1);
    if (text.starts_with(':')) text.remove_prefix(1);
    return parse_number(text).value_or(UINT64_MAX) <= UINT16_MAX ? text : std::string_view{};
}

/// The half that people get wrong, where it can be told.
std::string endpoint_error(const KeyFacts& key, std::string_view text) {
    const std::string shown = printable(std::string{text});
    if (const auto address = IpAddress::parse(text)) {
        const std::string better = address->v6 ? "[" + shown + "]:PORT" : shown + ":PORT";
        return "'" + shown + "' has no port: write " + better;
    }
    if (const std::string port{port_alone(text)}; !port.empty()) {
        const bool local = key.name == "bind" || key.is_of("udp-listen");
        return "'" + shown + "' has no IP address: write " + (local ? "0.0.0.0:" + port + " for every interface" : "IP:" + port);
    }
    if (const std::size_t percent = text.find('%'), end = text.find(']'); percent < end && end != text.npos) {
        const std::string_view interface = text.substr(percent + 1, end - percent - 1);
        const auto plain = Endpoint::parse(std::string{text.substr(0, percent)}.append(text.substr(end)));
        if (plain && plain->address.is_link_local())
            return "'" + shown + "': " + in_quotes(interface) + " is not the name of a network interface";
        if (plain) return "'" + shown + "': only a link-local address (fe80::...) takes an interface";
    }
    const std::size_t colon = text.rfind(':');
    if (colon != text.npos && parse_number(text.substr(colon + 1)).value_or(0) > UINT16_MAX)
        return must_be(key, in_quotes(text)) + ": a port is at most 65535";
    const std::string_view host = text.substr(0, colon);
    const std::string port = colon == std::string_view::npos ? "PORT" : shown.substr(std::min(colon + 1, shown.size()));
    if (host.find_first_of(":[]%") == std::string_view::npos && std::any_of(host.begin(), host.end(), is_beyond_hex))
        return "'" + shown + "': host names are not looked up, give an IP address such as 127.0.0.1:" + port;
    return must_be(key, in_quotes(text));
}

}    // namespace

std::string read_text(const KeyFacts& key, std::string_view text, std::string& field) {
    if (!is_utf8(text) || std::any_of(text.begin(), text.end(), is_control))
        return in_quotes(key.name) + " must be printable text in UTF-8, not " + in_quotes(text);
    std::size_t chosen = 0;
    if (key.form == Form::choice) {
        if (std::string error = read_choice(key, text, chosen); !error.empty()) return error;
    } else if (text.size() < key.least || text.size() > key.most) {
        return must_be(key, in_quotes(text));
    }
    field = text;
    return {};
}

std::string read_endpoint(const KeyFacts& key, std::string_view text, EndpointSpec& field) {
    auto value = EndpointSpec::parse(text);
    if (!value) return endpoint_error(key, text);
    field = *std::move(value);
    return {};
}

std::string read_duration(const KeyFacts& key, std::string_view text, Duration& field) {
    using Milliseconds = std::chrono::duration<std::uint64_t, std::milli>;
    const auto value = parse_duration(text);
    if (!value || *value < Milliseconds{key.least} || *value > Milliseconds{key.most}) return must_be(key, in_quotes(text));
    field = *value;
    return {};
}

std::string read_boolean(const KeyFacts& key, std::string_view text, bool& field) {
    const auto value = parse_boolean(text);
    if (!value) return must_be(key, in_quotes(text));
    field = *value;
    return {};
}

std::string read_number(const KeyFacts& key, std::string_view text, std::uint64_t& field) {
    std::optional<std::uint64_t> value;
    switch (key.form) {
    case Form::address: value = parse_address(text); break;
    case Form::can_id: value = parse_can_id(text); break;
    case Form::size: value = parse_size(text); break;
    default: value = parse_number(text);
    }
    if (value && *value >= key.least && *value <= key.most) return field = *value, std::string{};
    std::string fault = must_be(key, in_quotes(text));
    if (const auto meant = key.form == Form::integer ? without_unit(text) : std::nullopt;
        meant && *meant >= key.least && *meant <= key.most)
        fault += " (did you mean '" + std::to_string(*meant) + "'?)";
    if (key.form == Form::address) fault += ano::did_you_mean_hex(text);
    if (key.form == Form::can_id) fault += ano::did_you_mean_hex(text, 8);
    return fault;
}

std::string read_ranges(const KeyFacts& key, std::string_view text, std::vector<ByteRange>& field) {
    std::vector<ByteRange> ranges;
    for (const std::string_view word : split(text, '+')) {
        if (key.form == Form::frames) {
            const auto ids = parse_frames(word);
            if (!ids) return must_be(key, in_quotes(word)) + meant_frames(word);
            ranges.insert(ranges.end(), ids->begin(), ids->end());
        } else {
            const auto range = parse_addresses(word);
            if (!range) return must_be(key, in_quotes(word)) + meant_addresses(word);
            ranges.push_back({range->first, range->last});
        }
    }
    field = std::move(ranges);
    return {};
}

std::string read_choice(const KeyFacts& key, std::string_view text, std::size_t& field) {
    const auto choices = split(key.choices, '|');
    const auto found = std::find(choices.begin(), choices.end(), text);
    if (found == choices.end()) return must_be(key, in_quotes(text)) + ano::did_you_mean(text, choices);
    field = static_cast<std::size_t>(found - choices.begin());
    return {};
}

}    // namespace anogate
