// Link settings in one line, for tests.
#pragma once
#include <gateway/settings.hpp>

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
    s.kind = kind;
    s.name = name;
    return s;
}
inline anogate::LinkSettings serial(const std::string& name, const std::string& device) {
    auto s = link("serial", name);
    s.serial.device = device;
    return s;
}
inline anogate::LinkSettings udp_listen(const std::string& name, const std::string& local = "127.0.0.1:0") {
    auto s = link("udp-listen", name);
    s.udp_listen.local = endpoint(local);
    return s;
}
inline anogate::LinkSettings udp(const std::string& name, const std::string& peer) {
    auto s = link("udp", name);
    s.udp.peer = endpoint(peer);
    return s;
}
inline anogate::LinkSettings pty(const std::string& name, const std::string& path) {
    auto s = link("pty", name);
    s.pty.path = path;
    return s;
}
inline anogate::LinkSettings sim(const std::string& name, std::uint16_t hz = 50) {
    auto s = link("sim", name);
    s.sim.hz = hz;
    return s;
}

}    // namespace support
