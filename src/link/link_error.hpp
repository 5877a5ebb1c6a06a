// Why a link is not up.
#pragma once
#include <sys/expected.hpp>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

/// A text for the user, and for programs that translate it: one of link_error_ids with its named arguments.
struct LinkError {
    using Arguments = std::vector<std::pair<std::string_view, std::string>>;

    LinkError() = default;
    /// An error without an id of its own: "other".
    LinkError(std::string its_text) : text{std::move(its_text)} {}
    LinkError(const char* its_text) : text{its_text} {}
    LinkError(std::string_view its_id, std::string its_text, Arguments its_arguments)
        : text{std::move(its_text)}, id{its_id}, arguments{std::move(its_arguments)} {}

    std::string text{};
    std::string_view id = "other";
    Arguments arguments{};
};

/// The opened object, or the error.
template <class T>
using Opened = tl::expected<T, LinkError>;
using NotOpened = tl::unexpected<LinkError>;

/// A listening link refuses new peers.
inline LinkError all_channels_used() {
    return {"no_channel",
            "new senders were refused: all 64 channels of the gateway are in use; lower `max_peers` or restrict `allow`",
            {}};
}

inline LinkError no_descriptor() {
    return {"no_descriptor", "too few file descriptors are left to open it: raise LimitNOFILE= of the service, or ulimit -n", {}};
}

struct LinkErrorId {
    std::string_view id;
    std::string_view arguments;    // names, separated by spaces
    std::string_view meaning;
};

/// Listed in the manual.
inline constexpr LinkErrorId link_error_ids[] = {
    {"absent", "device", "port not found; waiting for it"},
    {"in_use", "device", "another program is using it"},
    {"no_permission", "device", "permission denied"},
    {"unusable", "device", "not a device of this kind, or its driver does not support the settings"},
    {"unplugged", "device", "the device was unplugged"},
    {"nobody_there", "path", "no program has opened the other side of the pseudo-terminal"},
    {"no_interface", "interface", "network or CAN interface not found"},
    {"interface_down", "interface", "the CAN interface is down"},
    {"bus_off", "interface", "the CAN controller has left the bus after too many errors"},
    {"not_can", "interface", "it is not a CAN interface"},
    {"no_can_fd", "interface", "the interface is not set up for CAN FD"},
    {"no_descriptor", "", "too few file descriptors are left to open it (ulimit -n, LimitNOFILE=)"},
    {"no_kernel_support", "what", "the kernel does not support such sockets"},
    {"no_address", "address", "no network interface has the local address"},
    {"port_in_use", "port", "another program is using the port"},
    {"no_port_permission", "port", "permission denied for this port"},
    {"no_such_host", "host", "the name can't be resolved; retrying (for the tunnel: while it is up)"},
    {"moved", "host", "the name of a UDP peer has a new address; the link uses it"},
    {"tls", "", "certificates can't be used, or the peer's certificate is not accepted"},
    {"certificate_unusable", "why", "while it is up: the certificate files can't be used; the previous ones stay in use"},
    {"certificate_expires", "days", "while it is up: our certificate expires within 14 days, or has expired"},
    {"closed_by_peer", "peer", "the peer closed the connection"},
    {"peer_silent", "peer", "the peer acknowledged nothing for `dead_after`"},
    {"no_way", "address", "no route to this address"},
    {"refused", "peer", "nothing listens on the peer's port (for UDP: while it is up)"},
    {"no_answer", "", "the peer does not answer (for ISO-TP: while it is up)"},
    {"other_gateway", "peer", "while it is up: another gateway listens there and was refused"},
    {"no_place", "count", "while it is up: new senders were refused because the limit of peers is reached"},
    {"handshakes", "count", "while it is up: unknown senders held all places for TLS handshakes"},
    {"no_memory", "count", "while it is up: new senders were refused for lack of memory"},
    {"sender_refused", "", "while it is up: senders outside `allow` were refused"},
    {"bus_errors", "interface", "while it is up: many CAN errors"},
    {"bus_passive", "interface", "while it is up: the CAN controller is error-passive"},
    {"bus_blocked", "interface", "while it is up: frames are not acknowledged on the CAN bus"},
    {"no_recording", "file what", "the recording can't be read, or the file is not a recording; waiting for it"},
    {"recording_damaged", "file what", "while it is up: the recording is damaged or truncated; its intact part is replayed"},
    {"nothing_to_replay", "file what", "while it is up: the recording has no frame that is to be replayed"},
    {"recording_slow", "file", "while it is up: the disk is too slow for the recording"},
    {"no_channel", "", "while it is up: all channels of the gateway are in use"},
    {"disabled", "", "disabled by the configuration or by a parameter of the gateway"},
    {"other", "", "anything else: see the text"},
};

}    // namespace anogate
