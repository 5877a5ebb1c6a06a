#include <link/kinds.hpp>

#include <algorithm>

namespace anogate {
namespace {

constexpr LinkKind kinds[] = {
    {"serial", "device", "/dev/ttyUSB0", "a serial port; absent or unplugged, it is waited for"},
    {"udp-listen", "address", "0.0.0.0:12333",
     "a UDP socket whose peers are learned: one exists after one whole good frame; port 0: the kernel chooses"},
    {"udp", "address", "192.168.1.20:6670", "one fixed UDP peer; broadcast and multicast addresses too"},
    {"pty", "path", "/run/anogate/app", "a pseudo-terminal, linked to PATH, for programs that expect a serial port"},
    {"sim", "device", "fc", "a simulated flight controller (0xDC) inside the process: demo, tests, development"},
};

}  // namespace

std::span<const LinkKind> link_kinds() noexcept {
    return kinds;
}

const LinkKind* find_link_kind(std::string_view name) noexcept {
    const auto row =
        std::find_if(std::begin(kinds), std::end(kinds), [name](const LinkKind& k) { return k.name == name; });
    return row != std::end(kinds) ? row : nullptr;
}

}  // namespace anogate
