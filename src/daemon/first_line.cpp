#include <config/link_kind.hpp>
#include <daemon/first_line.hpp>

namespace anogate {
namespace {

constexpr std::size_t max_addresses = 4;    // more than four are not shown: a machine with containers has dozens

std::string count(std::uint64_t n, const std::string& one) { return std::to_string(n) + " " + one + (n == 1 ? "" : "s"); }

/// Our addresses at which others can reach a socket that is bound to `bound`.
std::vector<Endpoint> reachable(const EndpointSpec& bound, const std::vector<Network>& own) {
    std::vector<Endpoint> all;
    for (const bool v6 : {false, true})
        for (const Network& network : own)
            if (network.address.v6 == v6 && (bound.address.v6 || !v6) && !network.address.is_loopback() &&
                !network.address.is_link_local())
                all.push_back({network.address, bound.port});
    return all;
}

std::string addresses(const EndpointSpec& bound, const std::vector<Network>& own) {
    if (bound.port == 0) return "a port chosen by the system (see the status)";
    if (bound.address.is_loopback()) return bound.text() + " (from this computer only)";
    if (!bound.address.is_any()) return bound.text();
    const std::vector<Endpoint> all = reachable(bound, own);
    if (all.empty()) return "port " + std::to_string(bound.port) + " of this computer, which has no network address yet";
    std::string text;
    for (std::size_t i = 0; i < all.size() && i < max_addresses; ++i) text += (i == 0 ? "" : " or ") + all[i].text();
    return all.size() > max_addresses ? text + " ..." : text;
}

std::string duration(Duration time) {
    const auto s = std::chrono::duration_cast<std::chrono::seconds>(time).count();
    const std::string minutes = std::to_string(s / 60 % 60) + " min", seconds = std::to_string(s % 60) + " s";
    if (s >= 3600) return std::to_string(s / 3600) + " h " + minutes;
    return s >= 60 ? minutes + " " + seconds : seconds;
}

}    // namespace

std::string first_line(const Settings& settings, std::string_view source, const std::vector<Network>& own) {
    std::string line = "anogated " ANOGATE_VERSION ", " + std::string{source} + ", " + count(settings.links.size(), "link");
    for (const LinkSettings& link : settings.links)
        if (const auto bound = bound_port_of(link); bound && link.kind->listens)
            line += "; " + link.name + (bound->is_tcp || uses_v7(link) ? ": " : ", for ground stations: ") +
                    (bound->is_tcp ? "TCP " : "UDP ") + addresses(bound->local, own);
    return line;
}

std::string last_line(std::string_view why, Duration uptime, std::uint64_t frames_in, std::uint64_t frames_out) {
    return "stopping (" + std::string{why} + ") after " + duration(uptime) + ", " + count(frames_in, "frame") + " in, " +
           std::to_string(frames_out) + " out";
}

}    // namespace anogate
