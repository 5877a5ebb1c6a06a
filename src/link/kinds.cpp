#include <link/can_link.hpp>
#include <link/kinds.hpp>
#include <link/pty_link.hpp>
#include <link/serial_link.hpp>
#include <link/sim_link.hpp>
#include <link/udp_link.hpp>
#include <link/udp_listen_link.hpp>

#include <algorithm>
#include <stdexcept>

namespace anogate {
namespace {

template <class Kind>
std::unique_ptr<Link> make(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    return std::make_unique<Kind>(id, settings, context);
}

constexpr LinkKind kinds[] = {
    {"serial", "device", "/dev/ttyUSB0", "a serial port; absent or unplugged, it is waited for", make<SerialLink>},
    {"udp-listen", "address", "0.0.0.0:12333",
     "a UDP socket whose peers are learned: one exists after one whole good frame; port 0: the kernel chooses",
     make<UdpListenLink>},
    {"udp", "address", "192.168.1.20:6670", "one fixed UDP peer; broadcast and multicast addresses too", make<UdpLink>},
    {"can", "interface", "can0", "a CAN interface; absent, down or bus-off, it is waited for", make_can_link},
    {"pty", "path", "/run/anogate/app", "a pseudo-terminal, linked to PATH, for programs that expect a serial port",
     make<PtyLink>},
    {"sim", "device", "fc", "a simulated flight controller (0xDC) inside the process: demo, tests, development", make<SimLink>},
};

}    // namespace

std::span<const LinkKind> link_kinds() noexcept { return kinds; }

const LinkKind* find_link_kind(std::string_view name) noexcept {
    const auto row = std::find_if(std::begin(kinds), std::end(kinds), [name](const LinkKind& k) { return k.name == name; });
    return row != std::end(kinds) ? row : nullptr;
}

std::unique_ptr<Link> make_link(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    const LinkKind* kind = find_link_kind(settings.kind);
    if (!kind) throw std::logic_error("no link kind " + settings.kind);    // the configuration was checked for it
    return kind->make(id, settings, context);
}

}    // namespace anogate
