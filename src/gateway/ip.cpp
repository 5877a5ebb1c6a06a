#include <gateway/ip.hpp>

#include <arpa/inet.h>
#include <net/if.h>

#include <algorithm>
#include <charconv>

namespace anogate {
namespace {

constexpr std::array<std::uint8_t, 12> mapped_prefix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

std::uint32_t value_of(const IpAddress& v4) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | v4.bytes[i];
    return value;
}

template <class Number>
std::optional<Number> number(std::string_view text, Number max) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value > max) return std::nullopt;
    return value;
}

// Whether `text` has the form of an interface name of the kernel.
bool names_interface(std::string_view text) noexcept {
    return !text.empty() && text.size() < IF_NAMESIZE && text != "." && text != ".." &&
           std::none_of(text.begin(), text.end(), [](unsigned char c) { return c <= ' ' || c == '/' || c == ':' || c == 0x7F; });
}

}    // namespace

std::optional<IpAddress> IpAddress::parse(std::string_view text) {
    IpAddress address;
    const std::size_t percent = text.find('%');
    const std::string host{text.substr(0, percent)};
    if (host.find('\0') != std::string::npos) return std::nullopt;
    if (percent == std::string_view::npos && inet_pton(AF_INET, host.c_str(), address.bytes.data()) == 1) return address;
    if (inet_pton(AF_INET6, host.c_str(), address.bytes.data()) != 1) return std::nullopt;
    address.v6 = true;
    if (percent != std::string_view::npos) {
        if (!address.is_link_local()) return std::nullopt;
        const std::string interface { text.substr(percent + 1) };
        address.scope = if_nametoindex(interface.c_str());
        if (address.scope == 0) {
            const auto given = number<std::uint32_t>(interface, UINT32_MAX);
            if (!given || *given == 0) return std::nullopt;
            address.scope = *given;
        }
    }
    if (std::equal(mapped_prefix.begin(), mapped_prefix.end(), address.bytes.begin()))
        return v4(address.bytes[12], address.bytes[13], address.bytes[14], address.bytes[15]);
    return address;
}

std::string IpAddress::text() const {
    char buffer[INET6_ADDRSTRLEN]{};
    inet_ntop(v6 ? AF_INET6 : AF_INET, bytes.data(), buffer, sizeof buffer);
    std::string result = buffer;
    if (scope != 0) {
        char name[IF_NAMESIZE]{};
        result += '%';
        result += if_indextoname(scope, name) ? std::string{name} : std::to_string(scope);
    }
    return result;
}

bool IpAddress::is_any() const noexcept {
    return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t b) { return b == 0; });
}

bool IpAddress::is_loopback() const noexcept {
    if (!v6) return bytes[0] == 127;
    return bytes[15] == 1 && std::all_of(bytes.begin(), bytes.end() - 1, [](std::uint8_t b) { return b == 0; });
}

bool IpAddress::is_link_local() const noexcept {
    if (!v6) return bytes[0] == 169 && bytes[1] == 254;
    return (bytes[0] == 0xFE && (bytes[1] & 0xC0) == 0x80) || (bytes[0] == 0xFF && (bytes[1] & 0x0F) == 0x02);
}

bool IpAddress::is_multicast() const noexcept { return v6 ? bytes[0] == 0xFF : (bytes[0] & 0xF0) == 0xE0; }

std::optional<Endpoint> Endpoint::parse(std::string_view text) {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string_view::npos) return std::nullopt;
    std::string_view host = text.substr(0, colon);
    const bool bracketed = host.size() >= 2 && host.front() == '[' && host.back() == ']';
    if (bracketed) host = host.substr(1, host.size() - 2);
    const auto address = IpAddress::parse(host);
    const auto port = number<std::uint16_t>(text.substr(colon + 1), UINT16_MAX);
    if (!address || !port || bracketed != (host.find(':') != std::string_view::npos)) return std::nullopt;
    return Endpoint{*address, *port};
}

std::string Endpoint::text() const {
    std::string host = address.text();
    if (address.v6) host.append("]").insert(0, 1, '[');
    return host.append(":").append(std::to_string(port));
}

std::optional<EndpointSpec> EndpointSpec::parse(std::string_view text) {
    const std::size_t percent = text.find('%');
    const std::size_t end = text.rfind("]:");
    if (percent == text.npos) {
        const auto plain = Endpoint::parse(text);
        return plain ? std::optional{EndpointSpec{*plain}} : std::nullopt;
    }
    if (end == text.npos || end < percent) return std::nullopt;
    const std::string_view interface = text.substr(percent + 1, end - percent - 1);
    const auto plain = Endpoint::parse(std::string{text.substr(0, percent)}.append(text.substr(end)));
    if (!plain || !plain->address.v6 || !plain->address.is_link_local() || !names_interface(interface)) return std::nullopt;
    return EndpointSpec{*plain, std::string{interface}};
}

std::string EndpointSpec::text() const {
    std::string result = Endpoint::text();
    if (!interface.empty()) result.insert(result.rfind(']'), "%" + interface);
    return result;
}

std::optional<Network> Network::parse(std::string_view text) {
    const std::size_t slash = text.find('/');
    const auto address = IpAddress::parse(text.substr(0, slash));
    if (!address) return std::nullopt;
    const std::uint8_t max_prefix = address->v6 ? 128 : 32;
    if (slash == std::string_view::npos) return Network{*address, max_prefix};
    const auto prefix = number<std::uint8_t>(text.substr(slash + 1), max_prefix);
    if (!prefix) return std::nullopt;
    return Network{*address, *prefix};
}

std::string Network::text() const { return address.text() + "/" + std::to_string(prefix); }

bool Network::contains(const IpAddress& other) const noexcept {
    if (other.v6 != address.v6) return false;
    const std::size_t whole = prefix / 8;
    if (!std::equal(address.bytes.begin(), address.bytes.begin() + static_cast<std::ptrdiff_t>(whole), other.bytes.begin()))
        return false;
    const unsigned rest = prefix % 8;
    if (rest == 0) return true;
    const auto mask = static_cast<std::uint8_t>(0xFF << (8 - rest));
    return (address.bytes[whole] & mask) == (other.bytes[whole] & mask);
}

bool is_broadcast(const IpAddress& address, const std::vector<Network>& networks) noexcept {
    if (address.v6) return false;
    if (address == IpAddress::v4(255, 255, 255, 255)) return true;
    return std::any_of(networks.begin(), networks.end(), [&](const Network& n) {
        if (n.prefix > 30 || !n.contains(address)) return false;
        const std::uint32_t host = value_of(address) & (UINT32_MAX >> n.prefix);
        return host == 0 || host == UINT32_MAX >> n.prefix;
    });
}

bool contains(const std::vector<Network>& networks, const IpAddress& address) noexcept {
    return std::any_of(networks.begin(), networks.end(), [&](const Network& n) { return n.contains(address); });
}

}    // namespace anogate
