#include <link/errors.hpp>
#include <link/feed.hpp>
#include <link/udp_link.hpp>

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>

namespace anogate {
namespace {

constexpr Duration networks_age = std::chrono::seconds{5};
constexpr Duration no_memory_pause = std::chrono::milliseconds{5};

}  // namespace

UdpLink::UdpLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      retry_{context.alarms, [this] { try_open(); }, retry_slack},
      expiry_{context.alarms, [this] {
                  if (channel_->parser.expire(context_.host.now())) deliver();
                  if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
              }},
      again_{context.alarms, [this] { flush(*channel_); }} {}

void UdpLink::start() {
    channel_ = context_.host.open_channel(*this, settings().udp.peer.text());
    try_open();
}

void UdpLink::try_open() {
    OpenedSocket opened = open_to_peer();
    const TimePoint now = context_.host.now();
    if (!opened.fd) {
        context_.host.link_down(*this, std::move(opened.error));
        retry_.set(backoff_.retry_at(now));
        return;
    }
    backoff_.came_up(now);
    trouble_.clear();
    local_ = local_endpoint(opened.fd.get());
    descriptor_.open(std::move(opened.fd));
    descriptor_.read_with([this] { read(); });
    context_.host.link_up(*this);
}

OpenedSocket UdpLink::open_to_peer() {
    const Endpoint& peer = settings().udp.peer;
    const bool multicast = peer.address.is_multicast();
    Endpoint local;
    local.address.v6 = peer.address.v6;
    if (multicast) local.port = peer.port;
    if (settings().udp.bind) local = *settings().udp.bind;
    OpenedSocket opened = open_udp(local, multicast);
    if (!opened.fd) return opened;
    to_ = SocketAddress::of(peer, local.address.v6);
    connected_ = !multicast && !is_broadcast(peer.address, own_networks());
    if (multicast) {
        if (std::string error = join_group(opened.fd.get()); !error.empty()) return {{}, std::move(error)};
    } else if (connected_ && ::connect(opened.fd.get(), to_.get(), to_.size) != 0) {
        return {{}, "no way to " + peer.text() + " now: " + error_text(errno)};
    }
    return opened;
}

std::string UdpLink::join_group(int fd) const {
    const Endpoint& peer = settings().udp.peer;
    group_req group{};
    group.gr_interface = peer.address.scope;
    std::memcpy(&group.gr_group, &to_.storage, sizeof to_.storage);
    const int level = peer.address.v6 ? IPPROTO_IPV6 : IPPROTO_IP;
    if (::setsockopt(fd, level, MCAST_JOIN_GROUP, &group, sizeof group) == 0) return {};
    return "can't join the multicast group " + peer.address.text() + ": " + error_text(errno);
}

void UdpLink::fail(std::string why) {
    descriptor_.close();
    expiry_.cancel();
    channel_->parser.finish();
    deliver();
    context_.host.link_down(*this, std::move(why));
    retry_.set(backoff_.retry_at(context_.host.now()));
}

void UdpLink::stop_reading() {
    descriptor_.stop_reading();
    retry_.cancel();
}

void UdpLink::stop() {
    retry_.cancel();
    expiry_.cancel();
    again_.cancel();
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
        return fail(error_text(settings().udp.peer.text(), error));
    }
    const TimePoint now = context_.host.now();
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!connected_ && own(context_.batch.sender(at), now)) continue;
        trouble_.clear();
        feed_datagram(channel_->parser, context_.batch.datagram(at), now,
                      [&](ano::FrameView frame) { context_.host.receive(*channel_, frame); });
    }
    if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
    context_.host.flush();
}

// What we send to a group or to everybody comes back to us.
bool UdpLink::own(const sockaddr_storage& sender, TimePoint now) {
    const Endpoint from = endpoint_of(sender);
    if (from.port != local_.port) return false;
    if (from.address == local_.address) return true;
    if (!local_.address.is_any()) return false;
    if (networks_.empty() || now - networks_read_at_ > networks_age) {
        networks_ = own_networks();
        networks_read_at_ = now;
    }
    return std::any_of(networks_.begin(), networks_.end(), [&](const Network& n) { return n.address == from.address; });
}

void UdpLink::deliver() {
    while (const auto frame = channel_->parser.next()) context_.host.receive(*channel_, *frame);
    context_.host.flush();
}

void UdpLink::flush(Channel& channel) {
    if (!descriptor_.is_open()) return;
    const SendReport report = send_all(descriptor_.fd(), channel.outbox, connected_ ? nullptr : &to_);
    note(report);
    switch (report.result) {
    case SendResult::done: return;
    case SendResult::full: descriptor_.when_writable([this] { flush(*channel_); }); return;
    case SendResult::no_memory: again_.set(context_.host.now() + no_memory_pause); return;
    case SendResult::broken: return fail(error_text("the way to " + settings().udp.peer.text(), report.error));
    }
}

void UdpLink::note(const SendReport& report) {
    refused_ += report.refused;
    if (report.error == ECONNREFUSED) trouble_ = "refused: nothing listens at " + settings().udp.peer.text();
    else if (report.error != 0 && report.error != EAGAIN && report.error != EINTR) trouble_ = error_text(report.error);
}

LinkFacts UdpLink::facts() const {
    LinkFacts facts{{"peer", settings().udp.peer.text()}};
    if (!descriptor_.is_open()) return facts;
    facts.push_back({"address", local_.text()});
    facts.push_back({"port", std::int64_t{local_.port}});
    facts.push_back({"refused", static_cast<std::int64_t>(refused_)});
    return facts;
}

}  // namespace anogate
