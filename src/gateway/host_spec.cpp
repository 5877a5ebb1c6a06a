#include <gateway/host_spec.hpp>

#include <algorithm>
#include <charconv>

namespace anogate {
namespace {

constexpr std::size_t max_name = 253, max_label = 63;

bool is_alphanumeric(char c) noexcept { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

bool is_label(std::string_view label) noexcept {
    return !label.empty() && label.size() <= max_label && label.front() != '-' && label.back() != '-' &&
           std::all_of(label.begin(), label.end(), [](char c) { return is_alphanumeric(c) || c == '-' || c == '_'; });
}

/// Decimal, octal or hexadecimal ("0x7f"): a name of such labels alone is an IPv4 address for the resolver (inet_aton).
bool is_number_label(std::string_view label) noexcept {
    if (label.size() > 2 && (label.starts_with("0x") || label.starts_with("0X")))
        return label.find_first_not_of("0123456789abcdefABCDEF", 2) == label.npos;
    return label.find_first_not_of("0123456789") == label.npos;
}

}    // namespace

bool is_host_name(std::string_view text) noexcept {
    if (text.ends_with('.')) text.remove_suffix(1);
    if (text.empty() || text.size() > max_name) return false;
    bool is_number = true;
    for (std::size_t from = 0; from <= text.size();) {
        const std::size_t dot = std::min(text.find('.', from), text.size());
        const std::string_view label = text.substr(from, dot - from);
        if (!is_label(label)) return false;
        is_number = is_number && is_number_label(label);
        from = dot + 1;
    }
    return !is_number;
}

bool is_same_name(std::string_view a, std::string_view b) noexcept {
    for (std::string_view* name : {&a, &b})
        if (name->ends_with('.')) name->remove_suffix(1);
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

std::optional<HostSpec> HostSpec::parse(std::string_view text) {
    if (auto endpoint = EndpointSpec::parse(text)) return HostSpec{*std::move(endpoint)};
    const std::size_t colon = text.find(':');
    if (colon == text.npos || !is_host_name(text.substr(0, colon))) return std::nullopt;
    const std::string_view digits = text.substr(colon + 1);
    HostSpec spec;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), spec.port);
    if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    spec.host = text.substr(0, colon);
    return spec;
}

std::string HostSpec::text() const { return host.empty() ? EndpointSpec::text() : host + ":" + std::to_string(port); }

}    // namespace anogate
