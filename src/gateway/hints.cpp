#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <gateway/hints.hpp>
#include <gateway/v7_guess.hpp>
#include <gateway/wrong_frames.hpp>

#include <chrono>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t enough_bytes = 64;     // minimum without a frame before a hint
constexpr std::uint64_t enough_frames = 20;    // minimum before a share of them is evaluated
constexpr std::uint64_t enough_good = 100;     // valid frames in a row after which the cause of corrupted ones is repaired
constexpr std::uint64_t enough_long = 5;       // among valid frames: noise would damage others as well
constexpr std::uint64_t enough_images = 2;
constexpr ano::Duration patience = 3s;    // shorter silences are normal
constexpr ano::Duration still = 2s;       // a link with bytes within this time is still receiving

std::int64_t in_whole_seconds(ano::Duration d) { return std::chrono::duration_cast<std::chrono::seconds>(d).count(); }
std::string seconds(ano::Duration d) { return std::to_string(in_whole_seconds(d)) + " s"; }

// Adds the advice to set `hello`, if the device may wait until it receives something.
Hint or_hello(const LinkFigures& link, Hint hint) {
    const bool try_hello = link.could_send_hello && link.words.may_wait_for_hello && !link.for_hosts;
    if (hint.id.empty() || !try_hello) return hint;
    hint.text += " (some devices send only after they receive a frame: try hello=on)";
    hint.args.emplace_back("try_hello", true);
    return hint;
}

Hint clients_without_frame(std::size_t count) {
    return {"clients_without_frame",
            "connected clients that have not sent a complete valid frame yet: " + std::to_string(count),
            {{"count", static_cast<std::int64_t>(count)}}};
}

Hint nothing_at_all(const LinkFigures& link) {
    if (link.channels == 0 && link.without_frame > 0) return clients_without_frame(link.without_frame);
    if (link.listens && link.channels == 0)
        return {"no_peer_yet",
                link.has_connections ? "no peer is connected" : "waiting for a peer to send its first valid frame"};
    return {link.words.nothing_yet.id, std::string{link.words.nothing_yet.text}};
}

/// How long bytes have been received without frames on a link that had frames before; std::nullopt: does not apply.
std::optional<ano::Duration> garbled_for(const LinkFigures& link) {
    if (link.received.frames_in == 0 || link.skipped_since < enough_bytes) return std::nullopt;
    if (!link.bytes_ago || *link.bytes_ago >= still) return std::nullopt;
    const ano::Duration without = link.silent_for.value_or(link.up_for);
    return without >= patience ? std::optional{without} : std::nullopt;
}

// The duration changes with every call: a hint that is reported once is written without it.
Hint garbled(const LinkFigures& link, ano::Duration time, bool with_details) {
    std::string text = "data but no valid frames ";
    text += with_details ? "for " : "any more";
    if (with_details) text += seconds(time);
    const LinkHints::Words& words = link.words.no_frames_any_more;
    return {words.id, text.append(words.text), {{"seconds", in_whole_seconds(time)}}};
}

Hint ring(const LinkFigures& link) {
    const std::string back{link.ring_back}, out{link.ring_out};
    return {"ring",
            "loop: frames sent to " + out + " come back" + (out == back ? "" : " from " + back),
            {{"out", out}, {"back", back}}};
}

Hint hidden(std::uint8_t address) {
    const std::string device = ano::hex_byte(address);
    return {"port_id_hides_device",
            "device " + device + " can't be reached: its address is also the port id of a link; change one of them",
            {{"device", device}}};
}

Hint old_device(std::uint8_t address) {
    const std::string device = ano::hex_byte(address);
    return {"answers_for_others",
            "device " + device + " acts on frames for other addresses: set profile=old on this link",
            {{"device", device}}};
}

Hint no_address(std::uint8_t source) {
    const std::string nobody = ano::hex_byte(source);
    return {"no_address",
            "a device sends from " + nobody +
                ", which is not a device address, and receives only broadcasts: set its id, or configure an `alias`",
            {{"source", nobody}}};
}

Hint contradiction(std::uint8_t address, ano::EulerSigns attitude) {
    const std::string device = ano::hex_byte(address), other = attitude == ano::EulerSigns::lx ? "document" : "lx";
    return {"attitude_contradiction",
            "Euler angles and quaternion of " + device + " contradict each other: try attitude=" + other,
            {{"device", device}, {"attitude", other}}};
}

Hint shared_by(SharedSource shared) {
    const auto hint = [shared](std::string_view id, std::string what) -> Hint { return {id, what.append(advice_on(shared))}; };
    switch (shared) {
    case SharedSource::none: break;
    case SharedSource::one_device: return hint("one_device_on_two_links", "the same frames arrive on two links: ");
    case SharedSource::two_devices: return hint("two_devices_one_id", "different frames with one id arrive on two links: ");
    case SharedSource::two_peers: return hint("two_peers_one_device", "two peers send as the same device: ");
    case SharedSource::claims_pinned:
        return hint("pinned_address_claimed", "frames from a pinned address arrive on another link: ");
    case SharedSource::of_a_group:
        return hint("untrusted_peer_of_group",
                    "an untrusted peer sends as a device of the group, `conflicts` in the status names both places: ");
    }
    return {};
}

// Names the address: another link may have a different hint for another address.
Hint shared(const LinkFigures& link) {
    Hint hint = shared_by(link.shared);
    if (link.shared_address == 0) return hint;
    const std::string device = ano::hex_byte(link.shared_address);
    hint.text += " (" + device + ")";
    hint.args.emplace_back("device", device);
    return hint;
}

Hint no_receiver(std::string_view hosts_link) {
    if (hosts_link.empty())
        return {"no_host_takes",
                "no ground station is registered for this telemetry yet (anoctl and the page see it anyway); have it send a "
                "frame, or add "
                "--route 0xFE=LINK"};
    const std::string link{hosts_link};
    return {"hosts_link_down",
            "ground stations were last seen on " + link + ", which is down: restore that link, or add --route 0xFE=LINK",
            {{"link", link}}};
}

// Classifies the bytes without valid frames.
Hint wrong_frames(const LinkFigures& link, bool with_text) {
    switch (find_wrong_frames(link.skipped)) {
    case WrongFrames::none: break;
    case WrongFrames::swapped_checks:
        return {"checks_swapped", "check bytes in the wrong order: the device must send SC first, then AC"};
    case WrongFrames::one_byte_length:
        return {"length_of_one_byte", "LEN has only one byte: the device must send two, low byte first"};
    case WrongFrames::big_endian_length:
        return {"length_big_endian", "LEN is sent high byte first: the device must send the low byte first"};
    case WrongFrames::old_body:
        return {"older_body", "frames of an older protocol with the V8 header 0xAB: use a V8 library on the device"};
    case WrongFrames::text: {
        Hint hint{"text", "text instead of frames: switch the device to V8 output, or read it with anoctl terminal"};
        const std::string shown = first_characters(link.skipped, link.to_utf8);
        if (with_text) hint.text += "; received: '" + shown + "'";
        hint.args.emplace_back("text", shown);
        return hint;
    }
    }
    return {};
}

// The device is guessed from the last bytes; if they contain no V7 frame, it remains open.
Hint v7_frames(const LinkFigures& link) {
    if (!link.may_use_v7) return {"v7_frames_only", "older V7 frames (0xAA) received: switch the device to protocol V8"};
    const std::bitset<256> ids = v7_ids_in(link.skipped);
    std::string keys = ids.none()        ? "protocol=v7,v7_device=ID"
                       : is_v7_host(ids) ? "protocol=v7,v7_role=host,v7_device=ID"
                                         : v7_link_keys(guess_v7_device(ids));
    return {"v7_frames",
            "older V7 frames (0xAA) received: add " + keys + " to this link, or switch its sender to protocol V8",
            {{"keys", keys}}};
}

bool is_repaired(const LinkFigures& link) noexcept { return link.frames_since_skipped.value_or(0) >= enough_good; }

// Why no frames are found, or why frames are refused.
Hint trouble_in(const LinkFigures& link, bool with_details) {
    const ReceiveCounters& in = link.received;
    const bool repaired = is_repaired(link);
    if (link.v7_frames > 0 && link.v7_frames * 10 > in.frames_in && !repaired) return v7_frames(link);
    const auto garbled_time = garbled_for(link);
    const std::uint64_t refused = in.bad_check + in.bad_length + in.expired;
    const bool finds_none = in.frames_in == 0 || garbled_time;
    const auto above_max_data = [] {
        return Hint{"above_max_data", "frames longer than max_data are refused: raise max_data on this link"};
    };
    if (finds_none && link.long_images >= enough_images) return above_max_data();
    if (in.skipped_bytes >= enough_bytes &&
        (finds_none || (refused >= enough_frames && refused * 10 > in.frames_in && !repaired)))
        if (Hint hint = wrong_frames(link, with_details); !hint.id.empty() && (finds_none || hint.id != "text")) return hint;
    if (in.frames_in == 0 && in.skipped_bytes >= enough_bytes)
        return {link.words.no_frames.id, std::string{link.words.no_frames.text}};
    if (garbled_time) return garbled(link, *garbled_time, with_details);
    const bool too_long = in.frames_in == 0 ? in.bad_length > 0 && in.bad_length >= in.bad_check
                                            : in.bad_length >= enough_long && in.bad_check == 0;
    if (too_long) return above_max_data();
    if (link.gateways > 0)
        return {"other_gateway",
                "a listening port of another gateway was refused: to connect two gateways, configure a udp: link to the other on "
                "one of them"};
    if (in.suspended > 0)
        return {"suspended",
                "a peer's frames were refused for one second after each gateway query (0xFB) from its address: a gateway listens "
                "there, or the address is forged; restrict `allow` or `interface`, or use WireGuard"};
    if (link.handshakes > 0)
        return {
            "handshakes",
            "unknown senders hold all places for TLS handshakes: add the operators' network to `trusted`, or restrict `allow`"};
    if (link.no_place > 0)
        return {"no_place",
                "new peers were refused because the limit of peers is reached: add the operators' network to `trusted`, or raise "
                "max_peers or max_per_address"};
    if (link.no_memory > 0)
        return {"no_memory", "new peers were refused for lack of memory: free some, or raise the memory limit of the service"};
    if (link.sent.held_back > 0)
        return {"held_back",
                "few frames are sent to a peer outside the local networks until it answers: add its network to `trusted`"};
    if (link.listens && link.channels == 0 && link.outsiders > 0)
        return {"senders_denied", "senders outside `allow` were refused: add their network to `allow`"};
    return {};
}

Hint trouble(const LinkFigures& link, bool with_details) {
    const ReceiveCounters& in = link.received;
    if (!link.up) return {};
    if (link.is_exclusive) return {"exclusive_use", "a terminal uses this link exclusively: no frames are sent to it"};
    if (link.v7_loops)    // first: frames that are dropped look like bytes without frames
        return {
            "v7_loop",
            "the other end of this line is a V7 link of a gateway: disconnect it, or set v7_role=host at one end if it joins two "
            "gateways"};
    if (Hint hint = trouble_in(link, with_details); !hint.id.empty()) return hint;
    if (!link.ring_back.empty()) return ring(link);    // first: its copies look like one device on two links
    if (link.shared != SharedSource::none) return shared(link);
    if (link.echoes) return {"echo", "the line echoes sent frames: disable the receiver while sending, or ignore this"};
    if (link.v7_commands)
        return {"v7_commands",
                "commands and requests received here are dropped, since V7 devices send none: if a host program is at the other "
                "end, set v7_role=host"};
    if (link.answers_for_others) return old_device(*link.answers_for_others);
    if (link.not_sent) return not_routed(*link.not_sent);
    if (link.nobody) return no_address(*link.nobody);
    if (link.hidden != 0) return hidden(link.hidden);
    if (link.contradictory != 0) return contradiction(link.contradictory, link.attitude);
    if (link.undelivered_for && *link.undelivered_for >= patience) return no_receiver(link.hosts_link);
    const std::uint64_t damaged = in.bad_check + in.expired;
    if (in.frames_in + damaged >= enough_frames && damaged * 10 > in.frames_in && !is_repaired(link))
        return {"many_damaged", "many corrupted frames: check cable, ground and baud rate"};
    const std::uint64_t dropped = link.sent.queue_full + link.sent.superseded + link.sent.stale - link.came_stale;
    if (dropped > 0 && dropped * 10 > link.sent.frames_out)
        return {"link_too_slow", "frames are dropped: more is sent to this link than it can carry"};
    if (in.bytes_in == 0 && link.up_for >= patience && !link.for_hosts) return or_hello(link, nothing_at_all(link));
    return {};
}

const Hint over{"recording_ended", "the recording has ended"};

Hint trouble_or_end(const LinkFigures& link, bool with_details) {
    Hint found = trouble(link, with_details);
    return found.id.empty() && link.is_over ? over : found;
}

}    // namespace

std::string_view advice_on(SharedSource shared) {
    switch (shared) {
    case SharedSource::none: break;
    // a group would drop the answer of a device that equals the frame of a host with its address
    case SharedSource::two_devices: return "if these are two devices, change the id of one";
    case SharedSource::one_device: return "if it is one device, put both links in one `group`; if two, change the id of one";
    case SharedSource::two_peers: return "see `conflicts` in the status; if these are two devices, change the id of one";
    case SharedSource::claims_pinned:
        return "its route does not change; if it is one device, put both links in one `group`; if two, change the id of "
               "the other one";
    case SharedSource::of_a_group: return "add an address to `trusted` only if you know that it is your device's";
    }
    return {};
}

Hint not_routed(std::uint8_t address) {
    if (address == ano::address::broadcast)
        return {
            "no_broadcast",
            "commands and writes to 0xFF, that is, to all devices, are not sent: no other link accepts broadcasts (broadcast=no "
            "or profile=old); send them to the address of the device instead"};
    const std::string device = ano::hex_byte(address);
    return {"unknown_device",
            "commands and writes to " + device +
                " are not sent: no link has received a frame from it, and other devices might act on " + "them; add --route " +
                device + "=LINK",
            {{"device", device}}};
}

Hint waiting_connections_closed() {
    return {"connections", "some waiting connections were closed: limit who can reach this port"};
}

void add_skipped(LinkFigures& link, const ano::FrameParser& parser) {
    if (!link.skipped.empty()) return;
    link.skipped.resize(ano::FrameParser::kept_skipped);
    link.skipped.resize(parser.copy_skipped(link.skipped));
}

std::string hint_of_trouble(const LinkFigures& link) { return trouble_or_end(link, false).text; }

Hint find_hint(const LinkFigures& link) {
    Hint found = trouble_or_end(link, true);
    if (found.id == over.id) return found;
    if (!found.id.empty() || !link.up || !link.silent_for || *link.silent_for < patience || link.for_hosts) return found;
    const bool spoke_by_itself = link.received.frames_in >= enough_frames;
    found.id = "silent";
    found.text = "silent for " + seconds(*link.silent_for);
    found.args.emplace_back("seconds", in_whole_seconds(*link.silent_for));
    return spoke_by_itself ? found : or_hello(link, std::move(found));
}

}    // namespace anogate
