#include <ano/hex.hpp>
#include <config/values.hpp>

#include <charconv>
#include <cstdio>

namespace anogate {
namespace {

struct Unit {
    std::string_view name;
    std::uint64_t worth;
};

constexpr Unit time_units[] = {{"h", 3'600'000}, {"m", 60'000}, {"s", 1000}, {"ms", 1}};    // in ms
constexpr Unit size_units[] = {{"GB", 1'000'000'000}, {"MB", 1'000'000},   {"kB", 1000},  {"KB", 1000},
                               {"GiB", 1ULL << 30},   {"MiB", 1ULL << 20}, {"KiB", 1024}, {"", 1}};

/// A whole number and one of `units`; at most `max`, in the smallest unit.
template <std::size_t N>
std::optional<std::uint64_t> parse_with_unit(std::string_view text, const Unit (&units)[N], std::uint64_t max) {
    const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    const auto count = parse_number(text.substr(0, digits));
    if (!count) return std::nullopt;
    for (const Unit& unit : units)
        if (text.substr(digits) == unit.name && *count <= max / unit.worth) return *count * unit.worth;
    return std::nullopt;
}

template <std::size_t N>
std::string text_with_unit(std::uint64_t count, const Unit (&units)[N]) {
    for (const Unit& unit : units)
        if (count != 0 && count % unit.worth == 0) return std::to_string(count / unit.worth) + std::string{unit.name};
    return std::to_string(count) + std::string{units[N - 1].name};
}

std::optional<std::uint64_t> parse_digits(std::string_view text, int base) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}    // namespace

std::optional<bool> parse_boolean(std::string_view text) {
    if (text == "true" || text == "yes" || text == "on") return true;
    if (text == "false" || text == "no" || text == "off") return false;
    return std::nullopt;
}

std::optional<std::uint64_t> parse_number(std::string_view text) { return parse_digits(text, 10); }

std::optional<std::uint64_t> parse_thousandths(std::string_view text) {
    constexpr std::uint64_t max_whole = 1'000'000'000;
    const std::size_t point = text.find('.');
    const auto whole = parse_number(text.substr(0, point));
    if (!whole || *whole > max_whole) return std::nullopt;
    std::string places{point == text.npos ? "0" : text.substr(point + 1)};
    while (places.size() > 3 && places.ends_with('0')) places.pop_back();
    const auto behind = places.size() <= 3 ? parse_number(places) : std::nullopt;
    if (!behind) return std::nullopt;
    constexpr std::uint64_t worth[] = {1000, 100, 10, 1};
    return *whole * 1000 + *behind * worth[places.size()];
}

std::optional<std::uint8_t> parse_address(std::string_view text) {
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    const auto value = hex ? parse_digits(text.substr(2), 16) : parse_digits(text, 10);
    if (!value || *value > 255) return std::nullopt;
    return static_cast<std::uint8_t>(*value);
}

std::optional<std::uint64_t> parse_can_id(std::string_view text) {
    const bool hex = text.starts_with("0x") || text.starts_with("0X");
    return hex ? parse_digits(text.substr(2), 16) : parse_digits(text, 10);
}

std::string can_id_text(std::uint64_t id) {
    char text[19];
    std::snprintf(text, sizeof text, "0x%llX", static_cast<unsigned long long>(id));
    return text;
}

std::optional<ByteRange> parse_addresses(std::string_view text) {
    const std::size_t dash = text.find('-');
    const auto first = parse_address(text.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : parse_address(text.substr(dash + 1));
    if (!first || !last || *first > *last) return std::nullopt;
    return ByteRange{*first, *last};
}

std::string addresses_text(ByteRange range) {
    if (range.first == range.last) return address_text(range.first);
    return std::to_string(range.first) + "-" + std::to_string(range.last);
}

std::string address_text(std::uint8_t address) { return ano::hex_byte(address); }

std::optional<ano::Duration> parse_duration(std::string_view text) {
    constexpr std::uint64_t max_ms = 1'000'000'000'000;    // 31 years; Duration can represent far more
    const auto ms = parse_with_unit(text, time_units, max_ms);
    if (!ms) return std::nullopt;
    return std::chrono::milliseconds{*ms};
}

std::string duration_text(ano::Duration duration) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(duration).count();
    return text_with_unit(static_cast<std::uint64_t>(ms), time_units);
}

std::optional<std::uint64_t> parse_size(std::string_view text) { return parse_with_unit(text, size_units, UINT64_MAX); }

std::string size_text(std::uint64_t bytes) { return text_with_unit(bytes, size_units); }

}    // namespace anogate
