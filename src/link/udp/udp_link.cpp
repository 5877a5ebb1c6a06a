#include <config/link_kind.hpp>
#include <gateway/peers/listening_notice.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>
#include <link/resolver.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <link/udp/udp_keys.hpp>
#include <link/udp/udp_link.hpp>
#include <link/udp/udp_settings.hpp>
#include <link/v7_keys.hpp>
#include <sys/errors.hpp>

#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace anogate {
namespace {

constexpr Duration join_again = std::chrono::seconds{3};
constexpr Duration join_slack = std::chrono::seconds{1};
constexpr Duration look_up_slack = std::chrono::seconds{1};
constexpr Duration trouble_shown = std::chrono::seconds{3};    // a peer may recover without sending anything

// Prefers IPv4, which devices and bridges have even if the name also has IPv6 addresses; `bind` takes precedence.
IpAddress best_of(const std::vector<IpAddress>& addresses, const std::optional<EndpointSpec>& bind) {
    const bool v6 = bind && bind->address.v6;
    const auto found = std::find_if(addresses.begin(), addresses.end(), [v6](const IpAddress& one) { return one.v6 == v6; });
    return found == addresses.end() ? addresses.front() : *found;
}

}    // namespace

UdpLink::UdpLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      reconnect_{context, *this, [this] { return find_and_open(); }},
      expiry_{context.alarms,
              [this] {
                  if (channel_->parser.expire(context_.host.now())) deliver();
                  if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
              }},
      again_{context.alarms, [this] { flush(*channel_); }},
      rejoin_{context.alarms, [this] { keep_joined(); }, join_slack},
      look_up_{context.alarms, [this] { look_up_again(); }, look_up_slack},
      interface_watch_{context, [this](LinkError why) { fail(std::move(why)); }},
      pacing_{context.alarms, [this] { flush(*channel_); }} {
    const V7LinkSettings& v7 = this->settings().as<UdpSettings>().v7;
    if (v7.is_on()) v7_ = std::make_unique<V7Edge>(v7, this->settings(), context_, V7Edge::Calls{[this] { flush(*channel_); }});
}

void UdpLink::start() {
    channel_ = context_.host.open_channel(*this, settings().as<UdpSettings>().peer.text());
    stored_ = context_.host.claim_stored(*this);    // now, because a look-up may take longer than they are kept
    reconnect_.start();
}

UdpLink::~UdpLink() { context_.names.cancel(this); }

Opened<void> UdpLink::find_and_open() {
    const HostSpec& peer = settings().as<UdpSettings>().peer;
    if (peer.host.empty()) {
        const auto endpoint = endpoint_now(peer);
        return endpoint ? open(*endpoint) : NotOpened{no_interface(peer.interface)};
    }
    context_.names.resolve(peer.host, context_.host.now(), this, [this, &peer](const auto& addresses, const auto& fault) {
        auto opened = addresses.empty() ? Opened<void>{NotOpened{no_such_host(peer.host, fault)}}
                                        : open({best_of(addresses, settings().as<UdpSettings>().bind), peer.port});
        if (!opened) reconnect_.lost(std::move(opened.error()));
    });
    return {};
}

// A device may get another address without any error at the socket.
void UdpLink::look_up_again() {
    const HostSpec& peer = settings().as<UdpSettings>().peer;
    look_up_.set(context_.host.now() + context_.names.kept_for());
    context_.names.resolve(peer.host, context_.host.now(), this, [this, &peer](const auto& addresses, const auto&) {
        const IpAddress here = endpoint_of(to_.storage).address;
        if (!addresses.empty() && std::find(addresses.begin(), addresses.end(), here) == addresses.end())
            fail({"moved", peer.host + " has a new address", {{"host", peer.host}}});
    });
}

void UdpLink::stop_looking_up() {
    look_up_.cancel();
    context_.names.cancel(this);
}

Opened<void> UdpLink::open(const Endpoint& peer) {
    arrival_.found_empty(context_.host.turn().clocks());
    auto socket = open_to(peer);
    if (!socket) return NotOpened{std::move(socket.error())};
    const TimePoint now = context_.host.now();
    reconnect_.came_up(now);
    trouble_ = {};
    local_ = local_endpoint(socket->get());
    pacing_.start(settings().rate, settings().latency, settings().gap);
    if (pacing_.is_on()) keep_send_buffer_small(socket->get());
    if (v7_) v7_->begin(*channel_);
    descriptor_.open(std::move(*socket));
    descriptor_.read_with([this] { read(); });
    interface_watch_.start(watched());
    if (peer.address.is_multicast()) rejoin_.set(now + join_again);
    if (!settings().as<UdpSettings>().peer.host.empty()) look_up_.set(now + context_.names.kept_for());
    context_.host.link_up(*this);
    return {};
}

// The endpoint with the interface to watch, if there is one.
EndpointSpec UdpLink::watched() const {
    const UdpSettings& udp = settings().as<UdpSettings>();
    if (!udp.interface.empty()) return {udp.peer, udp.interface};
    return udp.bind && udp.peer.interface.empty() ? *udp.bind : udp.peer;
}

Opened<UniqueFd> UdpLink::open_to(const Endpoint& peer) {
    const bool multicast = is_multicast_ = peer.address.is_multicast();
    EndpointSpec local;
    local.address.v6 = peer.address.v6;
    if (multicast) local.port = peer.port;
    if (settings().as<UdpSettings>().bind) local = *settings().as<UdpSettings>().bind;
    if (multicast) {    // bound to another address, the socket would not receive from the group
        local.address = {local.address.v6, {}, 0};
        local.interface.clear();
    }
    to_ = SocketAddress::of(peer, local.address.v6);
    to_interface_ = peer.address.scope;
    connected_ = !multicast && !is_broadcast(peer.address, own_networks());
    auto stored = std::exchange(stored_, std::nullopt);
    const std::string& interface = settings().as<UdpSettings>().interface;
    UniqueFd wire = stored ? reuse_udp(std::move(stored->wire), local, interface, connected_ ? std::optional{peer} : std::nullopt)
                           : UniqueFd{};
    if (wire) begin_arrival(arrival_, wire.get(), &*stored, context_.host.turn().clocks());
    auto socket = wire ? Opened<UniqueFd>{std::move(wire)} : open_udp(local, multicast, interface);
    if (!socket) return socket;
    if (multicast) {
        if (auto joined = join_group(socket->get()); !joined) return NotOpened{std::move(joined.error())};
    } else if (connected_ && !connected_to(socket->get()) && ::connect(socket->get(), to_.get(), to_.size) != 0) {
        const std::string written = settings().as<UdpSettings>().peer.text();
        return NotOpened{LinkError{"no_way", "can't reach " + written + ": " + error_text(errno), {{"address", written}}}};
    }
    return socket;
}

// Joins on `interface`, or the interface with the address of `bind`, or the one of the kernel's route. It is no error if the
// socket has joined already.
Opened<void> UdpLink::join_group(int fd) const {
    const Endpoint peer = endpoint_of(to_.storage);
    const auto& bind = settings().as<UdpSettings>().bind;
    const std::string& name = settings().as<UdpSettings>().interface;
    unsigned interface = name.empty() ? to_interface_ : ::if_nametoindex(name.c_str());
    if (!name.empty() && interface == 0) return NotOpened{no_interface(name)};
    if (name.empty() && bind && !bind->address.is_any()) {
        const auto now = endpoint_now(*bind);
        interface = now ? interface_of(now->address) : 0;
        if (interface == 0) return NotOpened{no_address(bind->text())};
    }
    const bool v6 = to_.storage.ss_family == AF_INET6;
    group_req group{};
    group.gr_interface = interface;
    std::memcpy(&group.gr_group, &to_.storage, sizeof to_.storage);
    bool done = ::setsockopt(fd, v6 ? IPPROTO_IPV6 : IPPROTO_IP, MCAST_JOIN_GROUP, &group, sizeof group) == 0 ||
                errno == EADDRINUSE;
    if (done && interface != 0) {
        ip_mreqn sender{};
        sender.imr_ifindex = static_cast<int>(interface);
        done = v6 ? ::setsockopt(fd, IPPROTO_IPV6, IPV6_MULTICAST_IF, &sender.imr_ifindex, sizeof sender.imr_ifindex) == 0
                  : ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &sender, sizeof sender) == 0;
    }
    if (done) return {};
    if (interface == 0 && errno == ENODEV)
        return NotOpened{
            LinkError{"no_way",
                      "no route to the multicast group " + peer.address.text() +
                          "; name an interface: interface=NAME, or by its address bind=ADDRESS:" + std::to_string(peer.port),
                      {{"address", peer.address.text()}}}};
    return Unexpected{"can't join the multicast group " + peer.address.text() + ": " + error_text(errno)};
}

// When an interface is removed or the route changes, the membership ends without any error at the socket.
void UdpLink::keep_joined() {
    if (auto joined = join_group(descriptor_.fd()); !joined) return fail(std::move(joined.error()));
    rejoin_.set(context_.host.now() + join_again);
}

void UdpLink::fail(LinkError why) {
    descriptor_.close();
    interface_watch_.stop();
    pacing_.stop();
    rejoin_.cancel();
    stop_looking_up();
    expiry_.cancel();
    if (v7_) v7_->end_of_input();
    channel_->parser.finish();
    deliver();
    reconnect_.lost(std::move(why));
}

void UdpLink::stop_reading() {
    descriptor_.stop_reading();
    reconnect_.stop();
    rejoin_.cancel();
    stop_looking_up();
}

void UdpLink::stop() {
    reconnect_.stop();
    expiry_.cancel();
    if (v7_) v7_->pause();
    again_.cancel();
    rejoin_.cancel();
    stop_looking_up();
    interface_watch_.stop();
    pacing_.stop();
    descriptor_.close();
}

void UdpLink::read() {
    const int count = context_.batch.receive(descriptor_.fd());
    if (count < 0) {
        const int error = errno;
        if (error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH || error == ENOMEM) {
            note({SendResult::done, error, error == ECONNREFUSED ? 1u : 0u});
            return;
        }
        return fail(error_text(settings().as<UdpSettings>().peer.text(), error));
    }
    const StallDetector& loop = context_.host.turn();
    const ClockReading asked = loop.before();
    const TimePoint now = loop.now();
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!connected_ && own(context_.batch.sender(at), now)) continue;
        trouble_ = {};
        if (tap_) [[unlikely]]
            tap_->received(context_.batch.datagram(at));
        channel_->arrived_at = context_.batch.arrived_at(at, arrival_, loop);
        if (v7_) v7_->receive_datagram(context_.batch.datagram(at), now);
        else feed_datagram(channel_->parser, context_.batch.datagram(at), now, [&](ano::FrameView frame) { receive(frame); });
    }
    if (static_cast<std::size_t>(count) < DatagramBatch::max_datagrams) arrival_.found_empty(asked);
    if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
    context_.host.flush();
    if (v7_ && descriptor_.is_open()) flush(*channel_);
}

// The socket also receives our own multicast and broadcast datagrams.
bool UdpLink::own(const sockaddr_storage& sender, TimePoint now) {
    const Endpoint from = endpoint_of(sender);
    if (from.port != local_.port) return false;
    if (from.address == local_.address) return true;
    return local_.address.is_any() && networks_.have(from.address, now);
}

// Notices of a listening gateway are ignored: this link may be connected to one.
void UdpLink::receive(ano::FrameView frame) {
    if (!listening_notice(frame)) context_.host.receive(*channel_, frame);
}

void UdpLink::deliver() {
    while (const auto frame = channel_->parser.next()) receive(*frame);
    context_.host.flush();
}

void UdpLink::flush(Channel& channel) {
    if (!descriptor_.is_open()) return;
    if (v7_) return flush_v7();
    const DatagramSender::Path way{
        descriptor_.fd(), connected_ ? nullptr : &to_, settings().pack ? settings().mtu : 0u, nullptr, SIZE_MAX, tap_};
    const SendReport report = context_.sender.send_all(way, channel.outbox, pacing_, context_.host.now());
    note(report);
    switch (report.result) {
    case SendResult::done:
    case SendResult::paced: return;
    case SendResult::full: descriptor_.when_writable([this] { flush(*channel_); }); return;
    case SendResult::no_memory: again_.set(context_.host.now() + no_memory_pause); return;
    case SendResult::broken: return fail(error_text("sending to " + settings().as<UdpSettings>().peer.text(), report.error));
    }
}

// One datagram for each V7 frame. A frame is taken only when the previous one is sent.
void UdpLink::flush_v7() {
    Outbox& outbox = channel_->outbox;
    while (write_v7() && !outbox.empty()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        std::span<const std::uint8_t> first;
        if (budget == 0 || outbox.gather({&first, 1}, now, budget) == 0) return;
        v7_->take(outbox, ano::FrameView{first}, now);
    }
}

// False: the rest waits, or the socket failed.
bool UdpLink::write_v7() {
    int failures = 0;    // each frame is tried twice, because an error may belong to an earlier datagram
    while (!v7_->unsent().empty()) {
        const auto frame = v7_->first_unsent();
        if (write_raw(frame)) {
            pacing_.sent(frame.size(), context_.host.now());
            v7_->written(frame.size());
            failures = 0;
            continue;
        }
        const int error = errno;
        if (error == EINTR) continue;
        note({SendResult::done, error, error == ECONNREFUSED ? 1u : 0u});
        switch (error) {
        case EAGAIN:
            channel_->outbox.set_congested();
            descriptor_.when_writable([this] { flush(*channel_); });
            return false;
        case ENOBUFS:
        case ENOMEM:
            channel_->outbox.set_congested();
            again_.set(context_.host.now() + no_memory_pause);
            return false;
        case EBADF:
        case EINVAL:
        case ENODEV:
        case ENETDOWN:
        case EADDRNOTAVAIL:
        case ENOTCONN: fail(error_text("sending to " + settings().as<UdpSettings>().peer.text(), error)); return false;
        default:
            if (++failures < 2) continue;
            failures = 0;
            v7_->written(frame.size());
        }
    }
    return true;
}

bool UdpLink::write_raw(std::span<const std::uint8_t> bytes) {
    if (!descriptor_.is_open()) return false;
    const int fd = descriptor_.fd();
    const ssize_t n = connected_ ? ::send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL)
                                 : ::sendto(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to_.get(), to_.size);
    if (n < 0) return false;
    if (tap_) tap_->sent(bytes);
    return true;
}

void UdpLink::note(const SendReport& report) {
    refused_ += report.refused;
    if (report.refused > 0) context_.host.report_unreachable(*this);
    if (report.error == 0 || report.error == EAGAIN || report.error == EINTR) return;
    trouble_at_ = context_.host.now();
    const std::string peer = settings().as<UdpSettings>().peer.text();
    trouble_ = report.error == ECONNREFUSED
                   ? LinkError{"refused", "connection refused: nothing listens at " + peer, {{"peer", peer}}}
                   : LinkError{error_text(report.error)};
}

LinkError UdpLink::trouble() const { return context_.host.now() - trouble_at_ < trouble_shown ? trouble_ : LinkError{}; }

LinkFacts UdpLink::facts() const {
    LinkFacts facts{{"peer", settings().as<UdpSettings>().peer.text()}};
    if (v7_) add_v7_facts(facts, v7_->counters());
    if (!descriptor_.is_open()) return facts;
    if (!settings().as<UdpSettings>().peer.host.empty()) facts.push_back({"sends_to", endpoint_of(to_.storage).text()});
    facts.push_back({"address", local_.text()});
    facts.push_back({"port", std::int64_t{local_.port}});
    facts.push_back({"refused", static_cast<std::int64_t>(refused_)});
    return facts;
}

namespace {

using namespace key_rows;
using Udp = UdpSettings;

constexpr Key<LinkSettings> own_udp_keys[] = {
    host<own<Udp>, &Udp::peer>("address", "the peer's HOST:PORT; if a name has several addresses, an IPv4 address is used") |
        needed,
    endpoint<own<Udp>, &Udp::bind>("bind", "local IP:PORT to send from (default: chosen by the system)") | local,
    text<own<Udp>, &Udp::interface>("interface", 1, max_interface, one_interface_help),
};
constexpr auto udp_keys = with_v7(own_udp_keys, v7_rows<Udp>());

void validate_udp(const LinkSettings& link, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    const Udp& udp = link.as<Udp>();
    check_v7(udp.v7, faults);
    const std::string peer = udp.peer.text();
    const IpAddress& address = udp.peer.address;
    if (udp.peer.port == 0) faults.error("address", "'" + peer + "' has port 0: give the port of the peer, 1 to 65535");
    check_interface(udp.interface, udp.peer, faults);
    if (udp.bind) check_interface(udp.interface, *udp.bind, faults);
    if (!udp.peer.host.empty()) return;
    if (udp.peer.port != 0 && address.is_any())
        faults.error("address", "'" + peer + "' is not the address of a peer; to accept peers there, use udp-listen:" + peer);
    if (address.v6 && address.is_link_local() && !address.is_multicast() && udp.peer.interface.empty() && udp.interface.empty() &&
        !(udp.bind && !udp.bind->interface.empty()))
        faults.error("address", "'" + peer + "' is a link-local address: add the interface, [" + address.text() +
                                    "%eth0]:" + std::to_string(udp.peer.port));
    if (udp.bind && udp.bind->address.v6 != address.v6)
        faults.error("bind", "'bind' " + udp.bind->text() + " and the peer " + peer + " must both be IPv4 or both IPv6");
}

std::optional<BoundPort> port_of_udp(const LinkSettings& link) {
    const Udp& udp = link.as<Udp>();
    return udp.bind ? std::optional{BoundPort{*udp.bind, udp.interface, "bind"}} : std::nullopt;
}

}    // namespace

extern const LinkKind udp_kind;    // listed in kinds.cpp
constinit const LinkKind udp_kind{
    .name = "udp",
    .address = "address",
    .example = "192.168.1.20:6670",
    .help = "one fixed UDP peer; also a broadcast or multicast address",
    .carries = Carries::datagrams,
    .may_be_paced = true,
    .hints = {.nothing_yet = {"nothing_from_peer", "nothing received yet from the peer"}, .may_wait_for_hello = true},
    .keys = udp_keys,
    .settings = [] { return KindSettings{Udp{}}; },
    .make = make_link_of<UdpLink>,
    .usual_name = [](const LinkSettings& link) { return "udp-" + std::to_string(link.as<Udp>().peer.port); },
    .bound_port = port_of_udp,
    .connects_to =
        [](const LinkSettings& link) {
            return std::optional{PeerPort{link.as<Udp>().peer, "address"}};
        },
    .reach = [](const LinkSettings& link) { return link.as<Udp>().peer.is_here() ? Reach::here : Reach::network; },
    .validate = validate_udp,
    .meant_by =
        [](std::string_view text) {
            return HostSpec::parse(text) ? "'udp:" + std::string{text} + "' or 'udp-listen:...'" : std::string{};
        },
};

}    // namespace anogate
