#include <ano/address.hpp>
#include <config/link_kind.hpp>
#include <gateway/far_peer.hpp>
#include <link/datagram_batch.hpp>
#include <link/datagram_sender.hpp>
#include <link/error_queue.hpp>
#include <link/errors.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>
#include <link/udp_keys.hpp>
#include <link/udp_listen_link.hpp>
#include <link/udp_settings.hpp>

#include <algorithm>
#include <new>
#include <random>

namespace anogate {
namespace {

constexpr Duration quiet = std::chrono::milliseconds{100};
constexpr Duration networks_kept = std::chrono::seconds{1};    // a sender outside makes us look again this often
constexpr Duration look_slack = std::chrono::seconds{1};
constexpr Duration read_first = std::chrono::seconds{1};
constexpr Duration look_at_suspect = std::chrono::seconds{1};    // whether it is time to ask it again

PeerBook::Options book_options(const UdpListenSettings& udp) {
    const std::size_t quarter = std::max<std::size_t>(2, udp.max_peers / 4u);
    return {udp.peer_timeout, udp.max_peers, udp.max_per_address ? *udp.max_per_address : quarter};
}

// From the system each time: what one sender is given tells nothing of what another one is.
std::uint64_t random_number() {
    std::random_device source;
    return std::uint64_t{source()} << 32 | source();
}

void hold_back_all(Outbox& outbox, TimePoint now) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (outbox.gather(next, now) > 0) outbox.drop_frame(&SendCounters::held_back);
}

// The frames of which it is known when they arrive.
void remember(FarPeer& far, Outbox& outbox, std::size_t budget, TimePoint now) {
    std::array<std::span<const std::uint8_t>, 32> next;
    const std::size_t count = outbox.gather(next, now, budget);
    for (std::size_t i = 0; i < count; ++i) far.sent(ano::FrameView{next[i]}, now);
}

}    // namespace

struct UdpListenLink::Peer {
    Peer(UdpListenLink& link, const Endpoint& e, Channel& c)
        : endpoint{e},
          address{SocketAddress::of(e, link.local_.address.v6)},
          channel{c},
          expiry{link.context_.alarms, [&link, this] { link.expire(*this); }},
          again{link.context_.alarms, [&link, this] { link.flush(channel); }} {}

    Endpoint endpoint;
    SocketAddress address;
    Channel& channel;
    Alarm expiry;
    Alarm again;                     // after the system had no memory to send
    std::unique_ptr<FarPeer> far;    // outside our networks, until it has shown that it is there
    TimePoint ask_at{};              // a suspect, whether it is a listening gateway
    TimePoint silenced_until{};      // nothing of it is taken before
    bool is_gateway = false;         // it said so: to be forgotten when what it sent has been read
};

UdpListenLink::UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      reconnect_{context, *this, [this] { return open(); }},
      look_{context.alarms, [this] { forget_overdue_peers(); }, look_slack},
      interface_watch_{context, [this](std::string why) { fail(std::move(why)); }},
      pacing_{context.alarms, [this] { flush_all(); }},
      probe_{{this->settings().max_data, 0, quiet}},
      book_{book_options(this->settings().as<UdpListenSettings>())},
      random_{random_number},
      check_{random_},
      take_reports_{[this] { return take_reports(); }} {}

UdpListenLink::~UdpListenLink() = default;

Expected<void> UdpListenLink::open() {
    const UdpListenSettings& listen = settings().as<UdpListenSettings>();
    auto socket = open_udp(listen.local, false, listen.interface);
    if (!socket) return Unexpected{std::move(socket.error())};
    reconnect_.came_up(context_.host.now());
    local_ = local_endpoint(socket->get());
    keep_error_reports(socket->get(), local_.address.v6);
    pacing_.start(settings().rate, settings().latency);
    if (pacing_.is_on()) keep_send_buffer_small(socket->get());
    descriptor_.open(std::move(*socket));
    arrival_.found_empty(context_.host.turn().clocks());
    opened(local_);
    descriptor_.read_with([this] { read(); });
    interface_watch_.start(listen.interface.empty() ? listen.local : EndpointSpec{listen.local, listen.interface});
    context_.host.link_up(*this);
    return {};
}

void UdpListenLink::fail(std::string why) {
    descriptor_.close();
    interface_watch_.stop();
    pacing_.stop();
    while (!peers_.empty()) forget(*peers_.back());
    reconnect_.lost(std::move(why));
}

void UdpListenLink::stop_reading() {
    descriptor_.stop_reading();
    reconnect_.stop();
}

void UdpListenLink::stop() {
    reconnect_.stop();
    look_.cancel();
    interface_watch_.stop();
    pacing_.stop();
    peers_.clear();
    book_.clear();
    descriptor_.close();
}

void UdpListenLink::read() {
    const int count = context_.batch.receive(descriptor_.fd());
    if (count <= 0) {
        const int error = count < 0 ? errno : 0;
        if (take_reports() || error == 0 || error == ENOMEM || may_be_reported(error)) return;
        return fail(error_text(local_.text(), error));
    }
    const LoopWatch& loop = context_.host.turn();
    const ClockReading asked = loop.before();
    const TimePoint now = loop.now();
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        take(context_.batch.sender(at), context_.batch.datagram(at), context_.batch.arrived_at(at, arrival_, loop), now);
    }
    if (static_cast<std::size_t>(count) < DatagramBatch::most) arrival_.found_empty(asked);
    context_.host.flush();
}

void UdpListenLink::take(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint arrived_at,
                         TimePoint now) {
    const Endpoint endpoint = endpoint_of(sender);
    Peer* peer = find(endpoint);
    if (!peer) peer = admit(endpoint, datagram, now);
    if (!peer) return;
    latest_ = peer;
    peer->channel.arrived_at = arrived_at;
    if (peer->far) peer->far->came(datagram.size(), now);
    feed_datagram(peer->channel.parser, datagram, now, [&](ano::FrameView frame) { take(*peer, frame, now); });
    delivered();
    if (const auto due = peer->channel.parser.deadline()) peer->expiry.set(*due);
    end_of_datagram(*peer, now);
}

void UdpListenLink::take(Peer& peer, ano::FrameView frame, TimePoint now) {
    if (const auto notice = listening_notice(frame)) {
        if (joins_gateways()) return;
        heard_notice(peer.endpoint, *notice, now);
        peer.is_gateway = peer.is_gateway || check_.is_refused(peer.endpoint);
        if (now >= peer.silenced_until && check_.is_suspended(peer.endpoint, now))
            peer.silenced_until = now + ListenerCheck::suspended_for;
        return;
    }
    if (peer.is_gateway || now < peer.silenced_until) {
        ++peer.channel.routed.denied_in;
        return;
    }
    book_.heard(peer.channel.id, frame.source(), now);
    if (!ano::address::is_host(frame.source())) ask_suspect(peer, now);
    if (peer.far && peer.far->heard(frame, now)) return;
    deliver(peer.channel, peer.endpoint, frame);
}

// What might forget it waits until nothing of it is in use.
void UdpListenLink::end_of_datagram(Peer& peer, TimePoint now) {
    if (peer.is_gateway) return forget(peer);
    if (!peer.far) return;
    if (peer.far->is_there()) {
        peer.far.reset();
    } else if (const auto question = peer.far->question(random_, now)) {
        if (send(peer.endpoint, *question) == 0) peer.far->left(question->size());
    }
}

// A peer that brings frames of devices, or is to get those of a host, may be another gateway's listening socket. Those of this
// machine are not: no datagram from outside has such a source.
void UdpListenLink::ask_suspect(Peer& peer, TimePoint now) {
    if (now < peer.ask_at || joins_gateways() || peer.endpoint.address.is_loopback()) return;
    peer.ask_at = now + look_at_suspect;
    if (peer.far && peer.far->allowance(now) < NoticeFrame{}.size()) return;
    if (const auto question = check_.question(peer.endpoint, now)) {
        if (peer.far) peer.far->left(NoticeFrame{}.size());
        say(peer.endpoint, question);
    }
}

void UdpListenLink::heard_notice(const Endpoint& from, const ListeningNotice& notice, TimePoint now) {
    if (notice.kind == ListeningNotice::Kind::question) {
        say(from, check_.asked(from, notice.number, now));
        if (!check_.is_refused(from)) say(from, check_.question_back(from, now));
    } else if (check_.answered(from, notice.number, now)) {
        ++gateways_;
        ++unassigned_.denied_in;
        last_gateway_ = from.text();
    }
}

void UdpListenLink::say(const Endpoint& to, const std::optional<ListeningNotice>& notice) {
    if (notice) send(to, frame_of(*notice));
}

UdpListenLink::Peer* UdpListenLink::find(const Endpoint& endpoint) noexcept {
    if (latest_ && latest_->endpoint == endpoint) return latest_;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->endpoint == endpoint; });
    return found == peers_.end() ? nullptr : found->get();
}

// A stranger must be allowed, must say something in V8, and may take the place of another.
UdpListenLink::Peer* UdpListenLink::admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram, TimePoint now) try {
    if (!allowed(endpoint, now) || !can_be_peer(endpoint, now)) return refuse(datagram), nullptr;
    if (!is_welcome(endpoint, datagram, now)) return nullptr;
    if (check_.is_refused(endpoint)) {    // it does not know yet
        say(endpoint, check_.question_back(endpoint, now));
        return refuse(datagram), nullptr;
    }
    if (check_.is_suspended(endpoint, now)) return refuse(datagram), nullptr;
    const PeerBook::Place place = book_.place_for(endpoint, now);
    if (!place.free) {
        ++no_place_;
        return refuse(datagram), nullptr;
    }
    if (place.gives_way)
        forget(**std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->channel.id == *place.gives_way; }));
    Peer* peer = make_peer(endpoint, now);
    if (!peer) refuse(datagram);
    return peer;
} catch (const std::bad_alloc&) {
    return refuse(datagram), nullptr;    // nobody is worth the end of the program
}

void UdpListenLink::refuse(std::span<const std::uint8_t> datagram) {
    ++unassigned_.denied_in;
    unassigned_.bytes_in += datagram.size();
}

// What a peer needs is some 100 KB: memory may be too short for it.
UdpListenLink::Peer* UdpListenLink::make_peer(const Endpoint& endpoint, TimePoint now) {
    const bool near = is_near(endpoint.address, now), far = is_far(endpoint.address, now);
    Channel* channel = context_.host.open_channel(*this, endpoint.text());
    if (!channel) return nullptr;
    try {
        auto peer = std::make_unique<Peer>(*this, endpoint, *channel);
        if (far) peer->far = std::make_unique<FarPeer>(now);
        peers_.push_back(std::move(peer));
    } catch (const std::bad_alloc&) {
        context_.host.close_channel(*channel);
        throw;
    }
    channel->heard_at = now;         // the frame it is here for may wait behind a false header
    context_.host.link_up(*this);    // for the new channel
    book_.add(channel->id, endpoint, near, now);
    look_.set_no_later(book_.next_look(now));
    return peers_.back().get();
}

// Our own socket is no peer either, nor is that of another link of ours.
bool UdpListenLink::can_be_peer(const Endpoint& sender, TimePoint now) {
    const bool near = is_near(sender.address, now);    // looks at our networks, if need be
    if (!anogate::can_be_peer(sender, networks_)) return false;
    if (!near || !context_.host.is_own_port(sender.port)) return true;
    return !sender.address.is_loopback() && std::none_of(networks_.begin(), networks_.end(), [&](const Network& network) {
        return network.address == sender.address;
    });
}

bool UdpListenLink::is_far(const IpAddress& address, TimePoint now) {
    const UdpListenSettings& udp = settings().as<UdpListenSettings>();
    return !joins_gateways() && !udp.trusted_any && !contains(udp.trusted, address) && !is_near(address, now);
}

bool UdpListenLink::allowed(const Endpoint& sender, TimePoint now) {
    const UdpListenSettings& udp = settings().as<UdpListenSettings>();
    if (udp.allow_any || contains(udp.allow, sender.address)) return true;
    return udp.allow.empty() && is_near(sender.address, now);
}

bool UdpListenLink::is_near(const IpAddress& address, TimePoint now) {
    if (contains(networks_, address)) return true;
    // Interfaces come and go: what was true when we opened need not be true now.
    if (networks_read_at_ != TimePoint{} && now - networks_read_at_ < networks_kept) return false;
    networks_read_at_ = now;
    networks_ = own_networks();
    return contains(networks_, address);
}

bool UdpListenLink::is_welcome(const Endpoint& sender, std::span<const std::uint8_t> datagram, TimePoint now) {
    const ano::ParserCounters before = probe_.counters();
    bool found = false;
    std::uint64_t unwelcome = 0;
    bool is_notice = false;
    const auto look = [&](ano::FrameView frame) {
        if (const auto notice = listening_notice(frame)) {
            is_notice = true;
            if (!joins_gateways()) heard_notice(sender, *notice, now);
        } else if (found || welcomes(sender, frame)) found = true;
        else ++unwelcome;
    };
    feed_datagram(probe_, datagram, now, look);
    probe_.finish();
    while (const auto frame = probe_.next()) look(*frame);
    if (found && !is_notice) return true;
    unassigned_.denied_in += unwelcome;
    const ano::ParserCounters& after = probe_.counters();
    unassigned_.bytes_in += datagram.size();
    unassigned_.skipped_bytes += after.skipped_bytes - before.skipped_bytes;
    unassigned_.bad_check += after.bad_check - before.bad_check;
    unassigned_.bad_length += after.bad_length - before.bad_length;
    unassigned_.expired += after.expired - before.expired;
    return false;
}

void UdpListenLink::forget(Peer& peer) {
    if (latest_ == &peer) latest_ = nullptr;
    Channel& channel = peer.channel;
    book_.remove(channel.id);
    check_.forget(peer.endpoint);
    std::erase_if(peers_, [&](const auto& p) { return p.get() == &peer; });
    context_.host.close_channel(channel);
}

void UdpListenLink::forget_peer(ChannelId channel) {
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->channel.id == channel; });
    if (found != peers_.end()) forget(**found);
}

void UdpListenLink::forget_overdue_peers() {
    const LoopWatch& loop = context_.host.turn();
    const TimePoint now = loop.now();
    if (now < loop.last_standstill() + read_first) return look_.set(now + read_first);    // what they said meanwhile may wait
    const ChannelSet overdue = book_.overdue(now);
    for (std::size_t i = peers_.size(); i-- > 0;)
        if (overdue.contains(peers_[i]->channel.id) || peers_[i]->is_gateway) forget(*peers_[i]);
    if (!peers_.empty()) look_.set(book_.next_look(now));
}

// Nobody is forgotten here: frames of the one it is about may be on their way out.
bool UdpListenLink::take_reports() {
    const TimePoint now = context_.host.now();
    return take_error_reports(descriptor_.fd(), [&](const Endpoint& there) {
               const Peer* peer = find(there);
               // Where an alarm does the sending, a later look each time would never be due.
               if (peer && book_.refused(peer->channel.id, now)) look_.set_no_later(now);
           }) > 0;
}

int UdpListenLink::send(const Endpoint& to, std::span<const std::uint8_t> bytes) {
    constexpr int max_tries = 16;
    int error = EBADF;
    for (int i = 0; i < max_tries && descriptor_.is_open(); ++i) {
        error = send_datagram(descriptor_.fd(), to, bytes, local_.address.v6);
        if (!may_be_reported(error) || !take_reports()) break;
    }
    return error;
}

void UdpListenLink::expire(Peer& peer) {
    const TimePoint now = context_.host.now();
    if (peer.channel.parser.expire(now)) {
        while (const auto frame = peer.channel.parser.next()) take(peer, *frame, now);
        delivered();
        context_.host.flush();
    }
    if (const auto due = peer.channel.parser.deadline()) peer.expiry.set(*due);
    if (peer.is_gateway) look_.set_no_later(now);    // not here: the alarm that called is its own
}

void UdpListenLink::flush(Channel& channel) {
    if (!descriptor_.is_open()) return;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return &p->channel == &channel; });
    if (found == peers_.end()) return;
    Peer& peer = **found;
    if (channel.hosts_spoke) ask_suspect(peer, context_.host.now());
    DatagramSender::Way way{descriptor_.fd(), &peer.address, settings().pack ? settings().mtu : 0u, &take_reports_, SIZE_MAX};
    for (;;) {
        const TimePoint now = context_.host.now();
        const std::uint64_t sent_before = channel.outbox.counters().bytes_out;
        if (peer.far) {
            way.most = peer.far->allowance(now);
            remember(*peer.far, channel.outbox, way.most, now);
        }
        const SendResult result = context_.sender.send_all(way, channel.outbox, pacing_, now).result;
        if (peer.far) peer.far->left(static_cast<std::size_t>(channel.outbox.counters().bytes_out - sent_before));
        switch (result) {
        case SendResult::done:
            if (peer.far) hold_back_all(channel.outbox, now);
            return;
        case SendResult::paced: return;
        case SendResult::full: descriptor_.when_writable([this] { flush_all(); }); return;
        case SendResult::no_memory: peer.again.set(now + no_memory_pause); return;
        case SendResult::broken: channel.outbox.drop_frame(&SendCounters::send_failed); break;    // towards this peer only
        }
    }
}

void UdpListenLink::flush_all() {
    ++first_served_;
    for (std::size_t i = 0; i < peers_.size(); ++i) flush(peers_[(first_served_ + i) % peers_.size()]->channel);
}

LinkFacts UdpListenLink::facts() const {
    const std::string local = descriptor_.is_open() ? local_.text() : settings().as<UdpListenSettings>().local.text();
    LinkFacts facts{{"address", local}, {"port", std::int64_t{local_port()}}};
    if (descriptor_.is_open()) facts.push_back({"kernel_drops", kernel_drops(descriptor_.fd())});
    return facts;
}

std::string UdpListenLink::trouble() const {
    if (gateways_ > 0) return "another gateway listens at " + last_gateway_ + " and was refused";
    if (no_place_ > 0) return std::to_string(no_place_) + " datagrams of strangers were refused: all places are taken";
    return unassigned_.denied_in > 0 && peers_.empty() ? "senders outside `allow` were refused" : std::string{};
}

namespace {

using namespace key_rows;
using Listen = UdpListenSettings;

constexpr Key<LinkSettings> listen_keys[] = {
    endpoint<own<Listen>, &Listen::local>("address", "local IP:PORT to listen on") | needed | key_rows::local,
    text<own<Listen>, &Listen::interface>("interface", 1, max_interface, one_interface_help),
    duration<own<Listen>, &Listen::peer_timeout>(
        "peer_timeout", second, day, "a peer silent for so long is forgotten; a host of our networks may listen for an hour"),
    integer<own<Listen>, &Listen::max_peers>("max_peers", 1, max_channels, "most peers at a time; one that is silent gives way"),
    integer<own<Listen>, &Listen::max_per_address>("max_per_address", 1, max_channels,
                                                   "most peers of one IP address, loopback excepted (default: a quarter of "
                                                   "max_peers, two at least)"),
    networks<Listen, &Listen::allow_any, &Listen::allow>(
        "allow", "networks whose members may become peers, or any (default: the networks of our interfaces)"),
    networks<Listen, &Listen::trusted_any, &Listen::trusted>(
        "trusted",
        "networks outside those of our interfaces whose peers are sent to at once, or any; others get at most three "
        "times what they send, until they answer (default: none)"),
};

void validate_listener(const LinkSettings& link, LinkFaults& faults) {
    const Listen& listen = link.as<Listen>();
    constexpr std::uint64_t much_memory = 64'000'000;    // bytes that wait, on a small computer
    const std::uint64_t memory = std::uint64_t{link.queue} * listen.max_peers;
    if (link.hello && *link.hello != Duration{})
        faults.error("hello",
                     "'hello' is not possible on udp-listen: it knows nobody to speak to before they have spoken; "
                     "for a device at a known address use udp:IP:PORT,hello=on");
    if (memory > much_memory)
        faults.warning("queue", "queue " + std::to_string(link.queue) + " for each of " + std::to_string(listen.max_peers) +
                                    " peers is " + std::to_string(memory / 1'000'000) +
                                    " MB, more than 64 MB: lower 'queue' or 'max_peers'");
    check_interface(listen.interface, listen.local, faults);
}

Reach reach_of_listener(const LinkSettings& link) {
    const Listen& listen = link.as<Listen>();
    if (listen.local.address.is_loopback()) return Reach::here;
    const bool all = listen.local.address.is_any() && listen.interface.empty() && (listen.allow_any || listen.allow.empty());
    return all ? Reach::whole_networks : Reach::network;
}

}    // namespace

extern const LinkKind udp_listen_kind;    // listed in kinds.cpp
constinit const LinkKind udp_listen_kind{
    .name = "udp-listen",
    .address = "address",
    .example = "0.0.0.0:12333",
    .help = "a UDP socket whose peers are learned: one exists after one whole good frame; port 0: the kernel chooses",
    .carries = Carries::datagrams,
    .listens = true,
    .may_be_paced = true,
    .keys = listen_keys,
    .settings = [] { return KindSettings{Listen{}}; },
    .make = make_link_of<UdpListenLink>,
    .usual_name = [](const LinkSettings& link) { return "udp-listen-" + std::to_string(link.as<Listen>().local.port); },
    .bound_port =
        [](const LinkSettings& link) {
            const Listen& listen = link.as<Listen>();
            return std::optional{BoundPort{listen.local, listen.interface, "address"}};
        },
    .reach = reach_of_listener,
    .validate = validate_listener,
};

}    // namespace anogate
