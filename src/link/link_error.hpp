// Why a link is not up.
#pragma once
#include <sys/expected.hpp>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

/// A text for the user; and for programs that translate it, one of link_error_ids with its named arguments.
struct LinkError {
    using Arguments = std::vector<std::pair<std::string_view, std::string>>;

    LinkError() = default;
    /// Without an id of its own: "other".
    LinkError(std::string its_text) : text{std::move(its_text)} {}
    LinkError(const char* its_text) : text{its_text} {}
    LinkError(std::string_view its_id, std::string its_text, Arguments its_arguments)
        : text{std::move(its_text)}, id{its_id}, arguments{std::move(its_arguments)} {}

    std::string text{};
    std::string_view id = "other";
    Arguments arguments{};
};

/// What was opened, or why it could not be.
template <class T>
using Opened = tl::expected<T, LinkError>;
using NotOpened = tl::unexpected<LinkError>;

struct LinkErrorId {
    std::string_view id;
    std::string_view arguments;    // names, separated by spaces
    std::string_view meaning;
};

/// Listed in the manual.
inline constexpr LinkErrorId link_error_ids[] = {
    {"absent", "device", "there is no such port; it is waited for"},
    {"in_use", "device", "another program has it open"},
    {"no_permission", "device", "this user may not open it"},
    {"unusable", "device", "it is not a serial port, or its driver refuses the settings"},
    {"unplugged", "device", "it was there and is gone"},
    {"nobody_there", "path", "no program has the other side of the pseudo-terminal open"},
    {"no_interface", "interface", "there is no such network or CAN interface now"},
    {"interface_down", "interface", "the CAN interface is down"},
    {"bus_off", "interface", "the CAN controller has left the bus after too many errors"},
    {"not_can", "interface", "it is not a CAN interface"},
    {"no_can_fd", "interface", "the interface carries no CAN FD frames now"},
    {"no_kernel_support", "what", "the kernel has no such sockets"},
    {"no_address", "address", "no interface has the local address now"},
    {"port_in_use", "port", "another program has the UDP port"},
    {"no_port_permission", "port", "this user may not listen there"},
    {"no_such_host", "host", "the name can't be resolved; it is tried again; of the tunnel while it is up"},
    {"moved", "host", "the name of a UDP peer has another address now; the link goes on there"},
    {"tls", "", "certificates can't be used, or the other end's is not accepted"},
    {"certificate_expires", "days", "while it is up: our certificate expires within 14 days, or has expired"},
    {"closed_by_peer", "peer", "the other end closed the connection"},
    {"peer_silent", "peer", "the other end acknowledged nothing for `dead_after`"},
    {"no_way", "address", "no route leads there now"},
    {"refused", "peer", "nothing listens at the peer's port; of UDP while it is up"},
    {"no_answer", "", "the peer does not answer; of ISO-TP while it is up"},
    {"other_gateway", "peer", "while it is up: another gateway listens there and was refused"},
    {"no_place", "count", "while it is up: datagrams of strangers were refused, all places are taken"},
    {"handshakes", "count", "while it is up: strangers held all places for TLS handshakes"},
    {"no_memory", "count", "while it is up: datagrams of strangers were refused, there was too little memory"},
    {"sender_refused", "", "while it is up: senders outside `allow` were refused"},
    {"bus_errors", "interface", "while it is up: the CAN controller counts many errors"},
    {"bus_passive", "interface", "while it is up: the CAN controller is error-passive"},
    {"bus_blocked", "interface", "while it is up: the CAN bus takes nothing"},
    {"no_recording", "file what", "the recording can't be read, or is none; it is waited for"},
    {"recording_damaged", "file what", "while it is up: the recording is damaged or was cut, and is said as far as it is whole"},
    {"nothing_to_replay", "file what", "while it is up: no frame of the recording is one that is to be said"},
    {"recording_slow", "file", "while it is up: the disk does not give the recording in time"},
    {"no_channel", "", "while it is up: all channels of the gateway are in use"},
    {"disabled", "", "its configuration, or the parameter of the gateway, says enabled=false"},
    {"other", "", "anything else: the text says it"},
};

}    // namespace anogate
