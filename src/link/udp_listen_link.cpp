#include <link/error_queue.hpp>
#include <link/errors.hpp>
#include <link/feed.hpp>
#include <link/udp_listen_link.hpp>

#include <algorithm>

namespace anogate {
namespace {

constexpr Duration quiet = std::chrono::milliseconds{100};
constexpr Duration networks_age = std::chrono::seconds{1};    // a sender outside makes us look again this often
constexpr Duration look_slack = std::chrono::seconds{1};
constexpr Duration no_memory_pause = std::chrono::milliseconds{5};

}  // namespace

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
    Alarm again;    // after the system had no memory to send
};

UdpListenLink::UdpListenLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      retry_{context.alarms, [this] { try_open(); }, retry_slack},
      look_{context.alarms, [this] { forget_overdue_peers(); }, look_slack},
      interface_watch_{context, [this](std::string why) { fail(std::move(why)); }},
      pacing_{context.alarms, [this] { flush_all(); }},
      probe_{{this->settings().max_data, 0, quiet}},
      book_{{this->settings().udp_listen.peer_timeout}},
      take_reports_{[this] { return take_reports(); }} {}

UdpListenLink::~UdpListenLink() = default;

void UdpListenLink::try_open() {
    OpenedSocket socket = open_udp(settings().udp_listen.local, false);
    const TimePoint now = context_.host.now();
    if (!socket.fd) {
        context_.host.link_down(*this, std::move(socket.error));
        retry_.set(backoff_.retry_at(now));
        return;
    }
    backoff_.came_up(now);
    local_ = local_endpoint(socket.fd.get());
    keep_error_reports(socket.fd.get(), local_.address.v6);
    pacing_.start(settings().rate, settings().latency);
    if (pacing_.is_on()) keep_send_buffer_small(socket.fd.get());
    descriptor_.open(std::move(socket.fd));
    opened(local_);
    descriptor_.read_with([this] { read(); });
    interface_watch_.start(settings().udp_listen.local);
    context_.host.link_up(*this);
}

void UdpListenLink::fail(std::string why) {
    descriptor_.close();
    interface_watch_.stop();
    pacing_.stop();
    while (!peers_.empty()) forget(*peers_.back());
    context_.host.link_down(*this, std::move(why));
    retry_.set(backoff_.retry_at(context_.host.now()));
}

void UdpListenLink::stop_reading() {
    descriptor_.stop_reading();
    retry_.cancel();
}

void UdpListenLink::stop() {
    retry_.cancel();
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
    const TimePoint now = context_.host.now();
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        take(context_.batch.sender(at), context_.batch.datagram(at), now);
    }
    context_.host.flush();
}

void UdpListenLink::take(const sockaddr_storage& sender, std::span<const std::uint8_t> datagram, TimePoint now) {
    const Endpoint endpoint = endpoint_of(sender);
    Peer* peer = find(endpoint);
    if (!peer) peer = admit(endpoint, datagram, now);
    if (!peer) return;
    latest_ = peer;
    feed_datagram(peer->channel.parser, datagram, now,
                  [&](ano::FrameView frame) { take(*peer, frame, now); });
    delivered();
    if (const auto due = peer->channel.parser.deadline()) peer->expiry.set(*due);
}

void UdpListenLink::take(Peer& peer, ano::FrameView frame, TimePoint now) {
    book_.heard(peer.channel.id, frame.source(), now);
    deliver(peer.channel, peer.endpoint, frame);
}

UdpListenLink::Peer* UdpListenLink::find(const Endpoint& endpoint) noexcept {
    if (latest_ && latest_->endpoint == endpoint) return latest_;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return p->endpoint == endpoint; });
    return found == peers_.end() ? nullptr : found->get();
}

// A stranger must be allowed, must say something in V8, and then takes the place of the one silent longest if need be.
UdpListenLink::Peer* UdpListenLink::admit(const Endpoint& endpoint, std::span<const std::uint8_t> datagram,
                                          TimePoint now) {
    if (endpoint.port == 0 || !allowed(endpoint, now)) {
        ++stray_.denied_in;
        stray_.bytes_in += datagram.size();
        return nullptr;
    }
    if (!is_welcome(endpoint, datagram, now)) return nullptr;
    if (peers_.size() >= settings().udp_listen.max_peers) {
        forget(**std::min_element(peers_.begin(), peers_.end(), [](const auto& a, const auto& b) {
            return a->channel.heard_at < b->channel.heard_at;
        }));
    }
    Channel* channel = context_.host.open_channel(*this, endpoint.text());
    if (!channel) {
        ++stray_.denied_in;
        stray_.bytes_in += datagram.size();
        return nullptr;
    }
    channel->heard_at = now;         // the frame it is here for may wait behind a false header
    context_.host.link_up(*this);    // for the new channel
    peers_.push_back(std::make_unique<Peer>(*this, endpoint, *channel));
    book_.add(channel->id, endpoint, is_near(endpoint.address, now), now);
    if (!look_.is_set()) look_.set(book_.next_look(now));
    return peers_.back().get();
}

bool UdpListenLink::allowed(const Endpoint& sender, TimePoint now) {
    const UdpListenSettings& udp = settings().udp_listen;
    if (udp.allow_any || contains(udp.allow, sender.address)) return true;
    return udp.allow.empty() && is_near(sender.address, now);
}

bool UdpListenLink::is_near(const IpAddress& address, TimePoint now) {
    if (contains(networks_, address)) return true;
    // Interfaces come and go: what was true when we opened need not be true now.
    if (networks_read_at_ != TimePoint{} && now - networks_read_at_ < networks_age) return false;
    networks_read_at_ = now;
    networks_ = own_networks();
    return contains(networks_, address);
}

bool UdpListenLink::is_welcome(const Endpoint& sender, std::span<const std::uint8_t> datagram, TimePoint now) {
    const ano::ParserCounters before = probe_.counters();
    bool found = false;
    std::uint64_t unwelcome = 0;
    const auto look = [&](ano::FrameView frame) {
        if (found || welcomes(sender, frame)) found = true;
        else ++unwelcome;
    };
    feed_datagram(probe_, datagram, now, look);
    probe_.finish();
    while (const auto frame = probe_.next()) look(*frame);
    if (found) return true;
    stray_.denied_in += unwelcome;
    const ano::ParserCounters& after = probe_.counters();
    stray_.bytes_in += datagram.size();
    stray_.skipped_bytes += after.skipped_bytes - before.skipped_bytes;
    stray_.bad_check += after.bad_check - before.bad_check;
    stray_.bad_length += after.bad_length - before.bad_length;
    stray_.expired += after.expired - before.expired;
    return false;
}

void UdpListenLink::forget(Peer& peer) {
    if (latest_ == &peer) latest_ = nullptr;
    Channel& channel = peer.channel;
    book_.remove(channel.id);
    std::erase_if(peers_, [&](const auto& p) { return p.get() == &peer; });
    context_.host.close_channel(channel);
}

void UdpListenLink::forget_overdue_peers() {
    const TimePoint now = context_.host.now();
    const ChannelSet overdue = book_.overdue(now);
    for (std::size_t i = peers_.size(); i-- > 0;)
        if (overdue.contains(peers_[i]->channel.id)) forget(*peers_[i]);
    if (!peers_.empty()) look_.set(book_.next_look(now));
}

// Nobody is forgotten here: frames of the one it is about may be on their way out.
bool UdpListenLink::take_reports() {
    const TimePoint now = context_.host.now();
    return take_error_reports(descriptor_.fd(), [&](const Endpoint& there) {
               const Peer* peer = find(there);
               if (peer && book_.refused(peer->channel.id, now)) look_.set(now);
           }) > 0;
}

int UdpListenLink::send(const Endpoint& to, std::span<const std::uint8_t> bytes) {
    constexpr int most_tries = 16;
    int error = EBADF;
    for (int i = 0; i < most_tries && descriptor_.is_open(); ++i) {
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
}

void UdpListenLink::flush(Channel& channel) {
    if (!descriptor_.is_open()) return;
    const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const auto& p) { return &p->channel == &channel; });
    if (found == peers_.end()) return;
    Peer& peer = **found;
    const DatagramSender::Way way{descriptor_.fd(), &peer.address, settings().pack ? settings().mtu : 0u, &take_reports_};
    for (;;) {
        const TimePoint now = context_.host.now();
        switch (context_.sender.send_all(way, channel.outbox, pacing_, now).result) {
        case SendResult::done:
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
    const std::string local = descriptor_.is_open() ? local_.text() : settings().udp_listen.local.text();
    LinkFacts facts{{"address", local}, {"port", std::int64_t{local_port()}}};
    if (descriptor_.is_open()) facts.push_back({"kernel_drops", kernel_drops(descriptor_.fd())});
    return facts;
}

std::string UdpListenLink::trouble() const {
    return stray_.denied_in > 0 && peers_.empty() ? "senders outside `allow` were refused" : std::string{};
}

}  // namespace anogate
