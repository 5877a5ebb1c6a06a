#include <link/kinds.hpp>

namespace anogate {

// Each is defined in the source file of its links.
extern const LinkKind serial_kind, hid_kind, udp_listen_kind, udp_kind, tcp_kind, tcp_listen_kind, tls_kind, tls_listen_kind,
    can_kind, pty_kind, sim_kind, replay_kind;

namespace {

constexpr const LinkKind* kinds[] = {&serial_kind, &hid_kind,        &udp_listen_kind, &udp_kind, &tcp_kind, &tcp_listen_kind,
                                     &tls_kind,    &tls_listen_kind, &can_kind,        &pty_kind, &sim_kind, &replay_kind};

}    // namespace

LinkKinds link_kinds() noexcept { return kinds; }

}    // namespace anogate
