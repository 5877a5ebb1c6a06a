#include <ano/hex.hpp>
#include <gateway/hints.hpp>

#include <chrono>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t enough_bytes = 64;     // so many without a frame are enough for a hint
constexpr std::uint64_t enough_frames = 20;    // so many are enough for a share of them
constexpr std::uint64_t enough_long = 5;       // among good frames: noise would damage others as well
constexpr ano::Duration patience = 3s;         // shorter silences are normal
constexpr ano::Duration still = 2s;            // bytes younger than that still come

std::string seconds(ano::Duration d) {
    return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(d).count()) + " s";
}

// For a link to a device that may itself wait to be spoken to.
std::string or_hello(const LinkFigures& link) {
    return link.waits_to_hear && link.words.may_wait_for_hello && !link.for_hosts
               ? " (some speak only when spoken to: try hello=on)"
               : "";
}

std::string nothing_at_all(const LinkFigures& link) {
    if (link.listens && link.channels == 0) return "no peer yet: a peer is known after its first whole frame";
    return std::string{link.words.nothing_yet};
}

/// For how long bytes have come without frames, on a link that had frames before; nothing: that is not so.
std::optional<ano::Duration> garbled_for(const LinkFigures& link) {
    if (link.received.frames_in == 0 || link.skipped_since < enough_bytes) return std::nullopt;
    if (!link.bytes_ago || *link.bytes_ago >= still) return std::nullopt;
    const ano::Duration without = link.silent_for.value_or(link.up_for);
    return without >= patience ? std::optional{without} : std::nullopt;
}

// The time changes with every look: a hint that is reported once is written without it.
std::string garbled(const LinkFigures& link, ano::Duration time, bool with_time) {
    std::string text = "bytes but no frames ";
    text += with_time ? "for " : "any more";
    if (with_time) text += seconds(time);
    return text.append(link.words.no_frames_any_more);
}

std::string ring(const LinkFigures& link) {
    const std::string back{link.ring_back};
    if (!link.ring_is_certain)
        return "the same device on two links? give them one `group`; or a ring: what goes out comes back by " + back;
    if (link.ring_out == link.ring_back) return "a ring: what goes out comes back by " + back;
    return "a ring: what goes out by " + std::string{link.ring_out} + " comes back by " + back;
}

std::string trouble(const LinkFigures& link, bool with_time) {
    const ReceiveCounters& in = link.received;
    if (!link.up) return {};
    if (link.v7_frames > 0 && link.v7_frames * 10 > in.frames_in)
        return "older V7 frames (0xAA) seen: switch the device to protocol V8";
    if (in.frames_in == 0 && in.skipped_bytes >= enough_bytes) return std::string{link.words.no_frames};
    if (const auto time = garbled_for(link)) return garbled(link, *time, with_time);
    const bool too_long = in.frames_in == 0 ? in.bad_length > 0 && in.bad_length >= in.bad_check
                                            : in.bad_length >= enough_long && in.bad_check == 0;
    if (too_long) return "frames longer than max_data are refused: raise max_data on this link";
    if (link.gateways > 0)
        return "a listening port of another gateway was refused: to join two gateways, give one of them a udp: link to the other";
    if (link.no_place > 0) return "strangers were refused, the places of peers are taken: raise max_peers or max_per_address";
    if (link.sent.held_back > 0) return "a peer outside our networks gets little until it answers: name its network in `trusted`";
    if (link.listens && link.channels == 0 && in.denied_in > 0)
        return "senders outside `allow` were refused: add their network to `allow`";
    if (!link.ring_back.empty()) return ring(link);    // first: its copies look like one device on two links
    if (link.shared == SharedSource::one_device) return "the same device on two links? give them one `group`";
    if (link.shared == SharedSource::two_devices) return "two devices have the same id: give one of them another";
    if (link.shared == SharedSource::two_peers) return "two peers speak as one device: `conflicts` in the status says who";
    if (link.hidden != 0) {
        const std::string device = "device " + ano::hex_byte(link.hidden);
        return device + " can't be reached: its address is the port id of a link, change one of them";
    }
    if (link.untaken_for && *link.untaken_for >= patience)
        return "no host takes what comes here: it must send something first, or say where it is: --route 0xFE=LINK";
    const std::uint64_t damaged = in.bad_check + in.expired;
    if (in.frames_in + damaged >= enough_frames && damaged * 10 > in.frames_in)
        return "many damaged frames: check cable, ground and baud rate";
    const std::uint64_t dropped = link.sent.queue_full + link.sent.superseded + link.sent.stale - link.came_stale;
    if (dropped > 0 && dropped * 10 > link.sent.frames_out)
        return "frames are dropped: the link is slower than what is sent to it";
    if (in.bytes_in == 0 && link.up_for >= patience && !link.for_hosts) {
        std::string nothing = nothing_at_all(link);
        return nothing.empty() ? nothing : nothing + or_hello(link);
    }
    return {};
}

}    // namespace

std::string hint_of_trouble(const LinkFigures& link) { return trouble(link, false); }

std::string hint(const LinkFigures& link) {
    std::string text = trouble(link, true);
    if (!text.empty() || !link.up || !link.silent_for || *link.silent_for < patience) return text;
    const bool spoke_by_itself = link.received.frames_in >= enough_frames;
    text = "silent for " + seconds(*link.silent_for);
    return spoke_by_itself ? text : text + or_hello(link);
}

}    // namespace anogate
