#include <link/tcp/host_port.hpp>

#include <algorithm>
#include <charconv>
#include <system_error>

namespace anogate {
namespace {

constexpr std::size_t longest_name = 253;    // of DNS

bool is_host_name(std::string_view host) {
    const auto may_be_in_it = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
    };
    if (host.empty() || host.size() > longest_name || host.front() == '-' || host.front() == '.') return false;
    const bool has_letter = std::any_of(host.begin(), host.end(), [](char c) { return c != '.' && (c < '0' || c > '9'); });
    return has_letter && std::all_of(host.begin(), host.end(), may_be_in_it);    // digits and points alone are a mistyped address
}

}    // namespace

std::optional<HostPort> HostPort::parse(std::string_view text) {
    if (auto literal = EndpointSpec::parse(text)) {
        if (literal->port == 0) return std::nullopt;
        const std::uint16_t port = literal->port;
        return HostPort{{}, port, std::move(literal)};
    }
    const std::size_t colon = text.rfind(':');
    if (colon == text.npos || !is_host_name(text.substr(0, colon))) return std::nullopt;
    HostPort result{std::string{text.substr(0, colon)}};
    const char* const end = text.data() + text.size();
    const auto [last, wrong] = std::from_chars(text.data() + colon + 1, end, result.port);
    if (wrong != std::errc{} || last != end || result.port == 0) return std::nullopt;
    return result;
}

}    // namespace anogate
