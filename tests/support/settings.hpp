// Link settings in one line, for tests.
#pragma once
#include <gateway/settings.hpp>
#include <link/kinds.hpp>
#include <link/serial/pty_settings.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/sim_settings.hpp>
#include <link/udp/udp_settings.hpp>

#include <stdexcept>
#include <string>

namespace support {

inline anogate::EndpointSpec endpoint(const std::string& text) {
    const auto parsed = anogate::EndpointSpec::parse(text);
    if (!parsed) throw std::invalid_argument{"no endpoint: " + text};
    return *parsed;
}

inline anogate::LinkSettings link(const std::string& kind, const std::string& name) {
    anogate::LinkSettings s;
    s.kind = anogate::find_link_kind(kind);
    s.of_kind = s.kind->settings();
    s.name = name;
    return s;
}
inline anogate::LinkSettings serial(const std::string& name, const std::string& device) {
    auto s = link("serial", name);
    s.as<anogate::SerialSettings>().device = device;
    return s;
}
inline anogate::LinkSettings udp_listen(const std::string& name, const std::string& local = "127.0.0.1:0") {
    auto s = link("udp-listen", name);
    s.as<anogate::UdpListenSettings>().local = endpoint(local);
    return s;
}
inline anogate::LinkSettings udp(const std::string& name, const std::string& peer) {
    auto s = link("udp", name);
    s.as<anogate::UdpSettings>().peer = *anogate::HostSpec::parse(peer);
    return s;
}
inline anogate::LinkSettings pty(const std::string& name, const std::string& path) {
    auto s = link("pty", name);
    s.as<anogate::PtySettings>().path = path;
    return s;
}
inline anogate::LinkSettings sim(const std::string& name, std::uint16_t hz = 50) {
    auto s = link("sim", name);
    s.as<anogate::SimSettings>().hz = hz;
    return s;
}

}    // namespace support
