#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/strict_json.hpp>
#include <link/udp/ip_socket.hpp>
#include <runtime/gateway.hpp>
#include <runtime/restart_state.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>

#include <fcntl.h>
#include <sys/stat.h>

namespace anogate {
namespace {

constexpr int format = 2;

std::int64_t nanoseconds(ano::Duration time) { return std::chrono::nanoseconds{time}.count(); }
std::int64_t nanoseconds(ano::TimePoint time) { return nanoseconds(time.time_since_epoch()); }
ano::Duration duration(const nlohmann::json& value) { return std::chrono::nanoseconds{value.get<std::int64_t>()}; }

// A stored time can't be after the start of this program.
ano::TimePoint past(const nlohmann::json& value, ano::TimePoint now) {
    const ano::TimePoint time{duration(value)};
    return std::min(time, now);
}

// Only the boot clock runs while the machine is suspended.
ano::Duration suspended_since(const ClockReading& then, const ClockReading& now) {
    const ano::Duration asleep = (now.boot - then.boot) - (now.now - then.now);
    return asleep > StallDetector::lateness ? asleep : ano::Duration{};
}

void grow_older(RestartState& state, ano::Duration time) {
    for (RestartState::OfLink& link : state.links) {
        for (StoredPeer& peer : link.link.peers) peer.memory.heard_at -= time;
        for (StoredChannel& channel : link.channels)
            for (StoredAddress& address : channel.addresses) address.heard_at -= time;
        for (DuplicateGuard::Memory& frame : link.brought) frame.at -= time;
    }
}

StoredChannel stored_channel(const Channel& channel, const Router& router) {
    StoredChannel stored{channel.peer};
    for (unsigned a = 0; a < 256; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (const auto heard_at = router.heard_at(address, channel.id)) stored.addresses.push_back({address, *heard_at});
        if (router.was_first(address, channel.id)) stored.first.push_back(address);
    }
    return stored;
}

nlohmann::json json_of(const StoredPeer& peer) {
    return {{"endpoint", peer.endpoint.text()}, {"heard_at", nanoseconds(peer.memory.heard_at)},
            {"is_host", peer.memory.is_host},   {"came_again", peer.memory.has_returned},
            {"once", peer.memory.once},         {"commands", peer.memory.commands},
            {"is_proven", peer.is_proven}};
}

// std::nullopt: the endpoint is on an interface that no longer exists.
std::optional<StoredPeer> peer_of(const nlohmann::json& from, ano::TimePoint now) {
    const auto written = EndpointSpec::parse(from.at("endpoint").get<std::string>());
    const auto endpoint = written ? endpoint_now(*written) : std::nullopt;
    if (!endpoint) return std::nullopt;
    return StoredPeer{*endpoint,
                      {past(from.at("heard_at"), now), from.at("is_host").get<bool>(), from.at("came_again").get<bool>(),
                       from.value("once", false), from.value("commands", false)},
                      from.at("is_proven").get<bool>()};
}

nlohmann::json json_of(const StoredChannel& channel) {
    nlohmann::json addresses = nlohmann::json::array();
    for (const StoredAddress& a : channel.addresses) addresses.push_back({a.address, nanoseconds(a.heard_at)});
    return {{"peer", channel.peer}, {"addresses", std::move(addresses)}, {"first", channel.first}};
}

std::optional<std::uint8_t> address_of(const nlohmann::json& value) {
    const int address = value.get<int>();
    return address >= 0 && address <= 0xFF ? std::optional{static_cast<std::uint8_t>(address)} : std::nullopt;
}

StoredChannel channel_of(const nlohmann::json& from, ano::TimePoint now) {
    StoredChannel channel{from.at("peer").get<std::string>()};
    for (const nlohmann::json& a : from.at("addresses"))
        if (const auto address = address_of(a.at(0))) channel.addresses.push_back({*address, past(a.at(1), now)});
    for (const nlohmann::json& a : from.at("first"))
        if (const auto address = address_of(a)) channel.first.push_back(*address);
    return channel;
}

nlohmann::json json_of(const RestartState::OfLink& link) {
    nlohmann::json peers = nlohmann::json::array(), channels = nlohmann::json::array();
    for (const StoredPeer& peer : link.link.peers) peers.push_back(json_of(peer));
    for (const StoredChannel& channel : link.channels) channels.push_back(json_of(channel));
    nlohmann::json brought = nlohmann::json::array();
    for (const DuplicateGuard::Memory& frame : link.brought) brought.push_back({frame.key, nanoseconds(frame.at), frame.repeats});
    return {{"name", link.name},
            {"brought", std::move(brought)},
            {"wire", {link.wire.device, link.wire.inode}},
            {"rest", ano::hex(link.link.rest)},
            {"peers", std::move(peers)},
            {"channels", std::move(channels)}};
}

RestartState::OfLink link_of(const nlohmann::json& from, const ClockReading& unread_since, ano::TimePoint now) {
    RestartState::OfLink link{from.at("name").get<std::string>()};
    link.wire = {from.at("wire").at(0).get<std::uint64_t>(), from.at("wire").at(1).get<std::uint64_t>()};
    link.link.unread_since = unread_since;
    link.link.rest = ano::from_hex(from.at("rest").get<std::string>()).value_or(std::vector<std::uint8_t>{});
    for (const nlohmann::json& p : from.at("peers"))
        if (auto peer = peer_of(p, now)) link.link.peers.push_back(*peer);
    for (const nlohmann::json& frame : from.at("brought"))
        link.brought.push_back({frame.at(0).get<std::uint64_t>(), frame.at(2).get<bool>(), past(frame.at(1), now)});
    for (const nlohmann::json& channel : from.at("channels")) link.channels.push_back(channel_of(channel, now));
    return link;
}

// Keeps the same number of frames for each link.
void keep_newest(RestartState& state) {
    const auto links = std::count_if(state.links.begin(), state.links.end(),
                                     [](const auto& link) { return !link.brought.empty(); });
    const std::size_t max_frames = max_stored_frames / static_cast<std::size_t>(std::max<std::ptrdiff_t>(links, 1));
    for (RestartState::OfLink& link : state.links) {
        std::sort(link.brought.begin(), link.brought.end(), [](const auto& a, const auto& b) { return a.at > b.at; });
        link.brought.resize(std::min(link.brought.size(), max_frames));
    }
}

}    // namespace

// A serial port is identified by its device file: another port under the same path is a different one.
WireIdentity WireIdentity::of(int fd) noexcept {
    struct stat info {};
    return fd >= 0 && ::fstat(fd, &info) == 0 ? WireIdentity{info.st_dev, info.st_ino} : WireIdentity{};
}

RestartState state_of(const Gateway& gateway, const ClockReading& unread_since) {
    RestartState state{unread_since};
    for (const LinkState& s : gateway.links()) {
        RestartState::OfLink stored{s.link->name()};
        const StorableLink* const storable = s.link->as<StorableLink>();
        const int wire = storable ? storable->storable_wire() : -1;
        if (wire >= 0) stored.link.wire = UniqueFd{::fcntl(wire, F_DUPFD_CLOEXEC, 0)};
        stored.wire = WireIdentity::of(stored.link.wire.get());
        if (storable) stored.link.peers = storable->peers();
        stored.brought = gateway.forwarder().brought_by(s.link->id(), state.unread_since.now - DuplicateGuard::usual_window);
        for (const ChannelId id : gateway.forwarder().traffic(s.link->id()).channels) {
            const Channel& channel = gateway.forwarder().channel(id);
            stored.channels.push_back(stored_channel(channel, gateway.forwarder().router()));
            if (stored.link.peers.empty()) stored.link.rest.assign(channel.parser.rest().begin(), channel.parser.rest().end());
        }
        state.links.push_back(std::move(stored));
    }
    keep_newest(state);
    return state;
}

std::string to_string(const RestartState& state) {
    nlohmann::json links = nlohmann::json::array();
    for (const RestartState::OfLink& link : state.links) links.push_back(json_of(link));
    const nlohmann::json unread_since{nanoseconds(state.unread_since.now), nanoseconds(state.unread_since.boot),
                                      nanoseconds(state.unread_since.real)};
    return ano::compact_json(nlohmann::json{{"format", format}, {"unread_since", unread_since}, {"links", std::move(links)}});
}

std::optional<RestartState> parse_restart_state(std::string_view text, const ClockReading& now) try {
    const auto strict = ano::strict_json<nlohmann::json>(text);
    if (!strict) return std::nullopt;
    const nlohmann::json& all = *strict;
    if (all.at("format") != format) return std::nullopt;
    const nlohmann::json& since = all.at("unread_since");
    RestartState state{{ano::TimePoint{duration(since.at(0))}, duration(since.at(1)), duration(since.at(2))}};
    if (state.unread_since.now > now.now || state.unread_since.boot > now.boot) return std::nullopt;
    for (const nlohmann::json& link : all.at("links")) state.links.push_back(link_of(link, state.unread_since, now.now));
    grow_older(state, suspended_since(state.unread_since, now));
    return state;
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

}    // namespace anogate
