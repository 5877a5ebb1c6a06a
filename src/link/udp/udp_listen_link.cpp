#include <ano/address.hpp>
#include <config/link_kind.hpp>
#include <gateway/peers/far_peer.hpp>
#include <link/check_listener.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <link/udp/error_queue.hpp>
#include <link/udp/udp_keys.hpp>
#include <link/udp/udp_listen_link.hpp>
#include <link/udp/udp_listen_peer.hpp>
#include <link/udp/udp_settings.hpp>
#include <link/v7_keys.hpp>
#include <sys/errors.hpp>

#include <algorithm>
#include <random>
#include <utility>

namespace anogate {
namespace {

constexpr Duration quiet = std::chrono::milliseconds{100};
constexpr Duration look_slack = std::chrono::seconds{1};
// A peer of our networks that does not answer the kernel's search for its hardware address. Meanwhile the kernel keeps up to 256
// datagrams to it, which use the send buffer of all peers.
constexpr Duration absent_for = std::chrono::seconds{10};
constexpr Duration between_tries = std::chrono::seconds{1};
// A datagram shows that the peer is back, at most once in this time: its sender may be forged.
constexpr Duration between_returns = std::chrono::minutes{5};
constexpr Duration look_at_suspect = std::chrono::seconds{1};    // shortest time between checks whether a peer is a gateway

// While datagrams are waiting for their turn, the socket is read again after this time, before its buffer is full.
constexpr Duration turn = std::chrono::microseconds{500};
constexpr int max_batches = 16;                                    // per turn: other links wait meanwhile
constexpr Duration at_the_end = std::chrono::milliseconds{100};    // for datagrams that wait when reading stops

// From the system's random source each time, so that the number of one sender does not help to guess that of another.
std::uint64_t random_number() {
    std::random_device source;
    return std::uint64_t{source()} << 32 | source();
}

PeerBook::Options book_options(const UdpListenSettings& udp) {
    const std::size_t quarter = std::max<std::size_t>(2, udp.max_peers / 4u);
    const std::size_t kept = udp.max_peers / 4u;
    const std::size_t for_trusted = udp.trusted.empty() ? 0 : kept / 2;
    const std::size_t of_address = udp.max_per_address ? *udp.max_per_address : quarter;
    return {udp.peer_timeout, udp.max_peers, of_address, kept, for_trusted, false, random_number()};
}

void drop_all(Outbox& outbox, TimePoint now, std::uint64_t SendCounters::*cause) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (outbox.gather(next, now) > 0) outbox.drop_frame(cause);
}

// Passes the frames about to be sent to `far`: an answer to one of them proves that the peer receives.
void remember(FarPeer& far, Outbox& outbox, std::size_t budget, TimePoint now) {
    std::array<std::span<const std::uint8_t>, 32> next;
    const std::size_t count = outbox.gather(next, now, budget);
    for (std::size_t i = 0; i < count; ++i) far.sent(ano::FrameView{next[i]}, now);
}

}    // namespace

UdpListenLink::UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      reconnect_{context, *this, [this] { return open(); }},
      look_{context.alarms, [this] { forget_overdue_peers(); }, look_slack},
      interface_watch_{context, [this](LinkError why) { fail(std::move(why)); }},
      pacing_{context.alarms, [this] { flush_all(); }},
      next_turn_{context.alarms, [this] { read(); }},
      probe_{{this->settings().max_data, 0, quiet}},
      book_{book_options(this->settings().as<UdpListenSettings>())},
      random_{random_number},
      check_{random_},
      reports_again_{context.alarms, [this] { keep_error_reports(descriptor_.fd(), local_.address.v6); }},
      read_reports_{[this] { return read_reports(); }} {
    if (this->settings().as<UdpListenSettings>().v7.is_on())
        v7_probe_.emplace(ano::v7::FrameParser::Options{std::min<std::size_t>(this->settings().max_data, ano::v7::max_len)});
}

UdpListenLink::~UdpListenLink() = default;

Opened<void> UdpListenLink::open() {
    const UdpListenSettings& listen = settings().as<UdpListenSettings>();
    auto stored = context_.host.claim_stored(*this);
    UniqueFd wire = stored ? reuse_udp(std::move(stored->wire), listen.local, listen.interface) : UniqueFd{};
    const bool is_stored{wire};
    auto socket = is_stored ? Opened<UniqueFd>{std::move(wire)} : open_udp(listen.local, false, listen.interface);
    if (!socket) return NotOpened{std::move(socket.error())};
    reconnect_.came_up(context_.host.now());
    local_ = local_endpoint(socket->get());
    keep_error_reports(socket->get(), local_.address.v6);
    pacing_.start(settings().rate, settings().latency);
    if (pacing_.is_on()) keep_send_buffer_small(socket->get());
    descriptor_.open(std::move(*socket));
    const ClockReading clocks = context_.host.turn().clocks();
    begin_arrival(arrival_, descriptor_.fd(), is_stored ? &*stored : nullptr, clocks);
    opened(local_);
    descriptor_.read_with([this] { read(); });
    interface_watch_.start(listen.interface.empty() ? listen.local : EndpointSpec{listen.local, listen.interface});
    context_.host.link_up(*this);
    if (is_stored) restore_peers(std::move(stored->peers), clocks.now);
    return {};
}

void UdpListenLink::fail(LinkError why) {
    descriptor_.close();
    reports_again_.cancel();
    next_turn_.cancel();
    interface_watch_.stop();
    pacing_.stop();
    while (!peers_.empty()) forget(*peers_.back());
    reconnect_.lost(std::move(why));
}

void UdpListenLink::stop_reading() {
    if (descriptor_.is_open()) process_waiting(at_the_end);
    next_turn_.cancel();
    descriptor_.stop_reading();
    reconnect_.stop();
}

void UdpListenLink::stop() {
    reconnect_.stop();
    look_.cancel();
    next_turn_.cancel();
    interface_watch_.stop();
    pacing_.stop();
    reports_again_.cancel();
    waiting_.clear();
    peers_.clear();
    book_.clear();
    descriptor_.close();
}

// Reads first, so that no datagram is lost in the kernel while those of others are forwarded.
void UdpListenLink::read() {
    if (!descriptor_.is_open()) return;
    turn_ends_ = ano::Clock::now() + turn;
    for (int batches = 1; read_batch() && is_crowded() && batches < max_batches;) ++batches;
    if (!descriptor_.is_open()) return;
    process_waiting(turn);
    context_.host.flush();
}

// False: the socket is empty, or reading failed.
bool UdpListenLink::read_batch() {
    const int count = context_.batch.receive(descriptor_.fd());
    if (count <= 0) {
        const int error = count < 0 ? errno : 0;
        if (!read_reports() && error != 0 && error != ENOMEM && !may_be_reported(error)) fail(error_text(local_.text(), error));
        return false;
    }
    const StallDetector& loop = context_.host.turn();
    const ClockReading asked = loop.before();
    const TimePoint now = loop.now();
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        receive(context_.batch.sender(at), context_.batch.datagram(at), context_.batch.arrived_at(at, arrival_, loop), now);
    }
    if (static_cast<std::size_t>(count) == DatagramBatch::max_datagrams) return true;
    arrival_.found_empty(asked);
    return false;
}

void UdpListenLink::receive(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint arrived_at,
                            TimePoint now) {
    const Endpoint endpoint = endpoint_of(sender);
    Peer* peer = find(endpoint);
    const bool is_new = !peer;
    if (is_new) peer = admit(endpoint, datagram, now);
    if (!peer) return;
    latest_ = peer;
    // The first datagram of a peer is processed at once: frames sent before the channel was opened can't be copies of frames sent
    // on it.
    if (is_crowded() && !is_new) store(*peer, datagram, arrived_at);
    else receive(*peer, datagram, arrived_at, now);
}

// May remove the peer.
void UdpListenLink::receive(Peer& peer, std::span<const std::uint8_t> datagram, TimePoint arrived_at, TimePoint now) {
    peer.channel.arrived_at = arrived_at;
    if (now < peer.absent_until && now >= peer.believed_again) {
        peer.absent_until = {};
        peer.believed_again = now + between_returns;
    }
    if (std::exchange(peer.came, true)) book_.came(peer.channel.id);
    if (peer.far) peer.far->came(datagram.size(), now);
    if (peer.v7) {
        peer.v7->receive_datagram(datagram, now);
        delivered();
        flush_v7(peer);
        return end_of_datagram(peer, now);
    }
    feed_datagram(peer.channel.parser, datagram, now, [&](ano::FrameView frame) { receive(peer, frame, now); });
    delivered();
    await_rest(peer);
    end_of_datagram(peer, now);
}

void UdpListenLink::receive(Peer& peer, ano::FrameView frame, TimePoint now) {
    if (const auto notice = listening_notice(frame)) {
        if (joins_gateways()) return;
        heard_notice(peer.endpoint, *notice, now);
        peer.is_gateway = peer.is_gateway || check_.is_refused(peer.endpoint);
        peer.suspended_until = check_.suspended_until(peer.endpoint, now);
        return;
    }
    if (peer.is_gateway || now < peer.suspended_until) {
        ++(peer.is_gateway ? peer.channel.routed.denied_in : peer.channel.routed.suspended);
        return;
    }
    book_.heard(peer.channel.id, frame.source(), now);
    if (is_command_of_host(frame)) book_.commanded(peer.channel.id, now);
    if (!ano::address::is_host(frame.source())) ask_suspect(peer, now);
    if (peer.far && peer.far->heard(frame, now)) return;
    deliver(peer.channel, peer.endpoint, frame);
}

// No question of another gateway can be among them, and none is sent to V7 devices.
void UdpListenLink::receive_v7(Peer& peer, ano::FrameView frame) {
    const TimePoint now = context_.host.now();
    book_.heard(peer.channel.id, frame.source(), now);
    if (is_command_of_host(frame)) book_.commanded(peer.channel.id, now);
    if (peer.far && peer.far->heard(frame, now)) return;
    deliver(peer.channel, peer.endpoint, frame);
}

// May remove the peer: no reference to it is in use here.
void UdpListenLink::end_of_datagram(Peer& peer, TimePoint now) {
    if (peer.is_gateway) return forget(peer);
    if (!peer.far) return;
    if (peer.far->is_there()) {
        peer.far.reset();
    } else if (peer.v7) {
        return;    // an acknowledgement of a request shows that it receives
    } else if (const auto question = peer.far->question(random_, now)) {
        if (send(peer.endpoint, *question) == 0) peer.far->left(question->size());
    }
}

// A peer that sends frames of devices, or receives those of a host, may be another gateway's listening socket. A loopback address
// is not checked: no datagram from outside has such a source.
void UdpListenLink::ask_suspect(Peer& peer, TimePoint now) {
    if (now < peer.ask_at || joins_gateways() || peer.endpoint.address.is_loopback()) return;
    peer.ask_at = now + look_at_suspect;
    if (peer.far && peer.far->allowance(now) < NoticeFrame{}.size()) return;
    if (const auto question = check_.question(peer.endpoint, now)) {
        if (peer.far) peer.far->left(NoticeFrame{}.size());
        send_notice(peer.endpoint, question);
    }
}

void UdpListenLink::heard_notice(const Endpoint& from, const ListeningNotice& notice, TimePoint now) {
    if (notice.kind == ListeningNotice::Kind::question) {
        send_notice(from, check_.asked(from, notice.number, now));
        if (!check_.is_refused(from)) send_notice(from, check_.question_back(from, now));
    } else if (check_.answered(from, notice.number, now)) {
        ++gateways_;
        ++unassigned_.denied_in;
        last_gateway_ = from.text();
    }
}

void UdpListenLink::send_notice(const Endpoint& to, const std::optional<ListeningNotice>& notice) {
    if (notice) send(to, frame_of(*notice));
}

// Does not remove peers: the outbox of the refused peer may be in use by the sender.
bool UdpListenLink::read_reports() {
    const TimePoint now = context_.host.now();
    const auto refused = [&](const Endpoint& there, const IpAddress& by) {
        // Only that host knows which of its ports are closed. The scope of `by` is not reported.
        if (by.v6 != there.address.v6 || by.bytes != there.address.bytes) return;
        const Peer* peer = find(there);
        // set_no_later(): if an alarm triggers the sending, postponing look_ each time would delay it for ever.
        if (peer && book_.refused(peer->channel.id, now)) look_.set_no_later(now);
    };
    const auto absent = [&](const Endpoint& there, const IpAddress& by) {
        Peer* const peer = find(there);
        if (!peer || !networks_.have(by, now)) return;    // others may forge it
        peer->absent_until = now + absent_for;
        peer->is_tried = false;
    };
    const std::size_t count = read_error_reports(descriptor_.fd(), refused, absent);
    limit_reports(count, now);
    return count > 0;
}

void UdpListenLink::limit_reports(std::size_t count, TimePoint now) {
    if (!report_limit_.is_exceeded(count, now)) return;
    keep_error_reports(descriptor_.fd(), local_.address.v6, false);
    reports_again_.set(now + ReportLimit::period);
}

// The kernel has sent the last try, so the neighbor has answered.
bool UdpListenLink::has_returned(const Peer& peer, TimePoint now) const {
    return peer.is_tried && now >= peer.next_try && unsent_datagrams(descriptor_.fd()) == 0;
}

int UdpListenLink::send(const Endpoint& to, std::span<const std::uint8_t> bytes) {
    constexpr int max_tries = 16;
    int error = EBADF;
    for (int i = 0; i < max_tries && descriptor_.is_open(); ++i) {
        error = send_datagram(descriptor_.fd(), to, bytes, local_.address.v6);
        if (!may_be_reported(error) || !read_reports()) break;
    }
    return error;
}

void UdpListenLink::expire(Peer& peer) {
    const TimePoint now = context_.host.now();
    if (peer.channel.parser.expire(now)) {
        while (const auto frame = peer.channel.parser.next()) receive(peer, *frame, now);
        delivered();
        context_.host.flush();
    }
    await_rest(peer);
    if (peer.is_gateway) look_.set_no_later(now);    // not removed here: its own alarm is calling
}

// Sets the expiry of an incomplete frame.
void UdpListenLink::await_rest(Peer& peer) {
    if (const auto due = peer.channel.parser.deadline()) peer.expiry.set(*due);
}

void UdpListenLink::flush(Channel& channel) {
    if (!descriptor_.is_open()) return;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return &p->channel == &channel; });
    if (found == peers_.end()) return;
    Peer& peer = **found;
    if (peer.v7) return flush_v7(peer);
    if (channel.had_host_frames) ask_suspect(peer, context_.host.now());
    DatagramSender::Path way{descriptor_.fd(), &peer.address, settings().pack ? settings().mtu : 0u, &read_reports_, SIZE_MAX};
    for (;;) {
        const TimePoint now = context_.host.now();
        if (has_returned(peer, now)) peer.absent_until = {};
        if (now < peer.absent_until) {
            if (now < peer.next_try) return drop_all(channel.outbox, now, &SendCounters::send_failed);
            peer.next_try = now + between_tries;
            peer.is_tried = true;
            way.max_bytes = channel.outbox.next(now).size;
        }
        const std::uint64_t sent_before = channel.outbox.counters().bytes_out;
        if (peer.far) {
            way.max_bytes = std::min(way.max_bytes, peer.far->allowance(now));
            remember(*peer.far, channel.outbox, way.max_bytes, now);
        }
        const SendResult result = context_.sender.send_all(way, channel.outbox, pacing_, now).result;
        if (peer.far) peer.far->left(static_cast<std::size_t>(channel.outbox.counters().bytes_out - sent_before));
        switch (result) {
        case SendResult::done:
            if (peer.far) drop_all(channel.outbox, now, &SendCounters::held_back);
            else if (now < peer.absent_until) drop_all(channel.outbox, now, &SendCounters::send_failed);
            return;
        case SendResult::paced: return;
        case SendResult::full: descriptor_.when_writable([this] { flush_all(); }); return;
        case SendResult::no_memory: peer.again.set(now + no_memory_pause); return;
        case SendResult::broken: channel.outbox.drop_frame(&SendCounters::send_failed); break;    // for this peer only
        }
    }
}

// One datagram for each V7 frame. A frame is taken only when the previous one is sent.
void UdpListenLink::flush_v7(Peer& peer) {
    constexpr std::size_t growth = 8;    // the largest by which a frame grows: 0xC0 without values
    Outbox& outbox = peer.channel.outbox;
    while (write_v7(peer) && !outbox.empty()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        if (has_returned(peer, now)) peer.absent_until = {};
        if (now < peer.absent_until) {
            if (now < peer.next_try) return drop_all(outbox, now, &SendCounters::send_failed);
            peer.next_try = now + between_tries;
            peer.is_tried = true;
        }
        std::span<const std::uint8_t> first;
        if (budget == 0 || outbox.gather({&first, 1}, now, budget) == 0) return;
        if (peer.far && peer.far->allowance(now) < first.size() + growth) return drop_all(outbox, now, &SendCounters::held_back);
        if (peer.far) peer.far->sent(ano::FrameView{first}, now);
        peer.v7->take(outbox, ano::FrameView{first}, now);
    }
}

// False: the rest waits.
bool UdpListenLink::write_v7(Peer& peer) {
    while (descriptor_.is_open() && !peer.v7->unsent().empty()) {
        const TimePoint now = context_.host.now();
        const auto frame = peer.v7->first_unsent();
        const bool is_allowed = !peer.far || peer.far->allowance(now) >= frame.size();
        const int error = is_allowed ? send(peer.endpoint, frame) : 0;
        if (error == EAGAIN || error == ENOBUFS || error == ENOMEM) {
            peer.channel.outbox.set_congested();
            if (error == EAGAIN) descriptor_.when_writable([this] { flush_all(); });
            else peer.again.set(now + no_memory_pause);
            return false;
        }
        if (is_allowed && peer.far) peer.far->left(frame.size());
        if (is_allowed) pacing_.sent(frame.size(), now);
        peer.v7->written(frame.size());
    }
    return descriptor_.is_open();
}

void UdpListenLink::flush_all() {
    read_reports();    // first, so that nothing more is sent to an absent peer
    ++first_served_;
    for (std::size_t i = 0; i < peers_.size(); ++i) flush(peers_[(first_served_ + i) % peers_.size()]->channel);
}

LinkFacts UdpListenLink::facts() const {
    const std::string local = descriptor_.is_open() ? local_.text() : settings().as<UdpListenSettings>().local.text();
    LinkFacts facts{{"address", local}, {"port", std::int64_t{local_port()}}};
    if (descriptor_.is_open()) facts.push_back({"kernel_drops", kernel_drops(descriptor_.fd())});
    if (v7_probe_) {
        V7Counters all = v7_of_gone_;
        for (const auto& peer : peers_) add(all, peer->v7->counters());
        add_v7_facts(facts, all);
    }
    return facts;
}

LinkError UdpListenLink::trouble() const {
    if (gateways_ > 0)
        return {"other_gateway",
                "another gateway listens at " + last_gateway_ + "; it was refused as a peer",
                {{"peer", last_gateway_}}};
    if (no_channel_.is_recent(context_.host.now())) return all_channels_used();
    if (const std::string count = std::to_string(no_place_); no_place_ > 0)
        return {
            "no_place", count + " datagrams from new senders were refused: the limit of peers is reached", {{"count", count}}};
    if (const std::string count = std::to_string(no_memory_); no_memory_ > 0)
        return {"no_memory", count + " datagrams from new senders were refused: not enough memory", {{"count", count}}};
    if (outsiders_ == 0 || !peers_.empty()) return {};
    return {"sender_refused", "senders outside `allow` were refused", {}};
}

namespace {

using namespace key_rows;
using Listen = UdpListenSettings;

constexpr Key<LinkSettings> own_listen_keys[] = {
    endpoint<own<Listen>, &Listen::local>("address", "local IP:PORT to listen on") | needed | key_rows::local,
    text<own<Listen>, &Listen::interface>("interface", 1, max_interface, one_interface_help),
    duration<own<Listen>, &Listen::peer_timeout>(
        "peer_timeout", second, day,
        "forget a peer after this time without frames; hosts in the local networks may listen for an hour"),
    integer<own<Listen>, &Listen::max_peers>("max_peers", 1, max_channels,
                                             "maximum number of peers; a silent one is replaced first"),
    integer<own<Listen>, &Listen::max_per_address>(
        "max_per_address", 1, max_channels,
        "maximum number of peers per IP address, except loopback (default: a quarter of "
        "max_peers, at least two)"),
    networks<Listen, &Listen::allow_any, &Listen::allow>(
        "allow", "networks whose hosts are accepted as peers, or any (default: the local networks)"),
    networks<Listen, &Listen::trusted_any, &Listen::trusted>(
        "trusted",
        "networks outside the local ones whose peers are sent to at once, or any; others get at most three "
        "times what they send until they answer; of a group only these peers are members (default: none)"),
};
constexpr auto listen_keys = with_v7(own_listen_keys, v7_rows<Listen>());

void validate_listener(const LinkSettings& link, LinkFaults& faults) {
    const Listen& listen = link.as<Listen>();
    constexpr std::uint64_t much_memory = 64'000'000;    // bytes of waiting frames, much for a small computer
    const std::uint64_t memory = std::uint64_t{link.queue} * listen.max_peers;
    if (link.hello && *link.hello != Duration{})
        faults.error("hello",
                     "'hello' is not possible on udp-listen, which learns its peers from the frames they send; "
                     "for a device at a known address use udp:IP:PORT,hello=on");
    if (memory > much_memory)
        faults.warning("queue", "queue " + std::to_string(link.queue) + " for each of " + std::to_string(listen.max_peers) +
                                    " peers is " + std::to_string(memory / 1'000'000) +
                                    " MB, more than 64 MB: reduce 'queue' or 'max_peers'");
    check_interface(listen.interface, listen.local, faults);
    check_per_address(listen.max_per_address, listen.max_peers, faults);
    check_group(link, listen.trusted_any || !listen.trusted.empty(), faults);
    check_v7(listen.v7, faults);
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
    .help = "a listening UDP port; a sender becomes a peer with its first valid frame; port 0: chosen by the kernel",
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
