#include <ano/address.hpp>
#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <gateway/peers/host_command.hpp>
#include <link/check_listener.hpp>
#include <link/make_link.hpp>
#include <link/tcp/tcp_keys.hpp>
#include <link/tcp/tcp_listen_link.hpp>
#include <link/tcp/tcp_session.hpp>
#include <link/tcp/tcp_socket.hpp>
#include <link/udp/ip_socket.hpp>
#include <link/v7_keys.hpp>
#include <sys/descriptors_left.hpp>
#include <sys/errors.hpp>

#include <fcntl.h>

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <new>
#include <random>
#include <utility>

namespace anogate {
namespace {

constexpr int accepts_per_turn = 64;
constexpr Duration accept_pause = std::chrono::milliseconds{100};
constexpr std::size_t for_one_peer = 2;                         // descriptors, until its channel is open
constexpr Duration between_silent = std::chrono::seconds{1};    // looks for room for those that only receive
constexpr Duration one_exchange = std::chrono::seconds{1};      // longest silence of a device during an exchange
// After its last frame, a host that has ended its output still receives, as in printf ... | nc. A host that is gone resets the
// connection at the next frame.
constexpr Duration for_answers = std::chrono::seconds{2};

PeerBook::Options book_options(const TcpListenSettings& tcp) {
    const std::size_t quarter = tcp.max_peers / 4u;
    const bool has_trusted = tcp.trusted_any || !tcp.trusted.empty();
    PeerBook::Options options;
    options.max_peers = tcp.max_peers;
    options.max_of_address = tcp.max_per_address ? *tcp.max_per_address : std::max<std::size_t>(2, quarter);
    options.kept = quarter;
    options.kept_for_trusted = has_trusted ? quarter / 2 : 0;
    options.has_connections = true;
    options.seed = std::random_device{}();
    return options;
}

ClientsWithoutFrame::Options options_without_frame(const LinkSettings& link) {
    ClientsWithoutFrame::Options options;
    options.parser.max_data = link.max_data;
    if (link.frame_gap) options.parser.frame_gap = *link.frame_gap;
    options.v7 = link.as<TcpListenSettings>().v7;
    return options;
}

std::string connections_were(const std::string& count) {
    return count + (count == "1" ? " connection was" : " connections were");
}

}    // namespace

class TcpListenLink::Connection final : public TcpSession {
public:
    Connection(TcpListenLink& link, const Endpoint& peer, Channel& its_channel)
        : TcpSession{link.context_, link.settings(), link.settings().as<TcpListenSettings>().dead_after},
          id{its_channel.id},
          address{peer.address},
          since{link.context_.host.now()},
          answered_{link.context_.alarms, [this] { link_.end(*this, cause_of(0)); }},
          link_{link} {
        translate(link.settings().as<TcpListenSettings>().v7, link.settings());
    }

    bool has_heard(std::uint8_t source) const { return heard_[source]; }
    /// The peer sends no more, and awaits answers to its last frames.
    bool only_awaits_answers() const { return answered_.is_set(); }
    TimePoint heard_at() const { return heard_at_; }
    using StreamSession::channel;
    using StreamSession::translation;
    using TcpSession::not_acknowledged;
    using TcpSession::not_acknowledged_for;

    const ChannelId id;
    const IpAddress address;
    const TimePoint since;

private:
    void opened() override {
        pacing().start(link_.settings().rate, link_.settings().latency, link_.settings().gap);
        resume_reading();
        link_.context_.host.link_up(link_);    // for the new channel
    }
    void receive(ano::FrameView frame) override {
        heard_at_ = context_.host.now();
        if (heard_.any()) link_.book_.came(id);
        link_.book_.heard(id, frame.source(), heard_at_);
        if (is_command_of_host(frame)) link_.book_.commanded(id, heard_at_);
        if (!heard_[frame.source()] || has_rival_) has_rival_ = link_.has_rival(*this, frame.source());
        heard_.set(frame.source());
        StreamSession::receive(frame);
    }
    void acknowledges_nothing() override { context_.host.report_unreachable(link_); }
    void read_ended(int error) override {
        const TimePoint by = heard_at_ + for_answers;
        if (error != 0 || !tls_fault().empty() || !is_of_hosts_alone() || context_.host.now() >= by)
            return link_.end(*this, cause_of(error));
        pause_reading();
        if (!translation()) end_of_input();
        if (is_open()) answered_.set(by);
    }
    void failed(int error) override { link_.end(*this, cause_of(error)); }
    std::string cause_of(int error) const {
        if (const std::string fault = tls_fault(); !fault.empty()) return "TLS: " + fault;
        if (error == 0 || error == ECONNRESET || error == EPIPE) return "it closed the connection";
        return error == ETIMEDOUT ? "it acknowledged nothing for too long" : error_text(error);
    }

    bool is_of_hosts_alone() const {
        for (std::size_t source = 0; source < heard_.size(); ++source)
            if (heard_[source] && !ano::address::is_host(static_cast<std::uint8_t>(source))) return false;
        return heard_.any();
    }

    bool has_rival_ = false;    // another connection of the same device was active recently
    Alarm answered_;
    TcpListenLink& link_;
    std::bitset<256> heard_;    // the sources of its frames
    TimePoint heard_at_{};
};

TcpListenLink::TcpListenLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      listener_{context.io},
      reconnect_{context, *this, [this] { return open(); }},
      book_{book_options(this->settings().as<TcpListenSettings>())},
      clients_without_frame_{context, options_without_frame(this->settings()),
                             [this](int fd, const ClientsWithoutFrame::Sender& sender) { return admit(fd, sender); }},
      sweep_{context.alarms, [this] { ended_.clear(); }},
      accept_again_{context.alarms, [this] { accept_on(); }},
      silent_again_{context.alarms, [this] { admit_silent(); }} {
    if (!this->settings().kind->encrypts) return;
    certificates_ = std::make_unique<CertificateReader>(context, *this, this->settings().as<TcpListenSettings>().tls,
                                                        TlsContext::Side::listens);
    handshakes_.emplace(
        context_, *certificates_,
        [this](UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> tls) {
            await_frame(std::move(fd), peer, std::move(tls));
        },
        [this](const std::string& why) {
            failed_handshakes_.add(context_.host.now());
            last_fault_ = why;
        });
}

TcpListenLink::~TcpListenLink() = default;

Opened<void> TcpListenLink::open() {
    if (!certificates_) return listen();
    certificates_->read([this](Opened<void> usable) {
        if (usable) usable = listen();
        if (!usable) reconnect_.lost(std::move(usable.error()));
    });
    return {};
}

Opened<void> TcpListenLink::listen() {
    auto socket = listen_tcp(settings().as<TcpListenSettings>().local);
    if (!socket) return NotOpened{std::move(socket.error())};
    reconnect_.came_up(context_.host.now());
    local_ = local_endpoint(socket->get());
    listener_.open(std::move(*socket));
    listener_.read_with([this] { accept(); });
    context_.host.link_up(*this);
    return {};
}

// Without a free descriptor, the listener would report the waiting connection again and again, so it pauses.
void TcpListenLink::accept() {
    for (int i = 0; i < accepts_per_turn; ++i) {
        if (descriptors_left() < for_one_peer + descriptors_of_links() / 2) return pause_accepting();
        Accepted next = accept_tcp(listener_.fd());
        if (next.fd) {
            on_accepted(std::move(next.fd), next.peer);
            continue;
        }
        if (errno == ECONNABORTED || errno == EINTR) continue;
        if (errno == EAGAIN) return;
        return pause_accepting();
    }
}

void TcpListenLink::pause_accepting() {
    no_memory_.add(context_.host.now());
    listener_.stop_reading();
    accept_again_.set(context_.host.now() + accept_pause);
}

void TcpListenLink::accept_on() {
    if (listener_.is_open() && !is_ending_ && !accept_again_.is_set()) listener_.read_with([this] { accept(); });
}

void TcpListenLink::on_accepted(UniqueFd fd, const Endpoint& peer) try {
    const TimePoint now = context_.host.now();
    if (!is_allowed(peer.address, now)) {
        ++outsiders_;
        return;
    }
    set_tcp_options(fd.get(), settings().as<TcpListenSettings>().dead_after);
    if (!handshakes_) return await_frame(std::move(fd), peer, {});
    if (!handshakes_->add(std::move(fd), peer, is_trusted(peer.address))) no_place_.add(now);
} catch (const std::bad_alloc&) {
    no_memory_.add(context_.host.now());
}

void TcpListenLink::await_frame(UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> encrypted) try {
    const TimePoint now = context_.host.now();
    if (!fd) return no_memory_.add(now);
    if (has_room_for_silent(peer, now) && admit(fd.get(), {peer, encrypted})) return;
    if (!clients_without_frame_.add(std::move(fd), peer, std::move(encrypted), is_trusted(peer.address)))
        return no_place_.add(now);
    if (!silent_again_.is_set()) silent_again_.set(now + between_silent);
} catch (const std::bad_alloc&) {
    no_memory_.add(context_.host.now());
}

// It may be a peer that only receives. Channels are left to those that send.
bool TcpListenLink::has_room_for_silent(const Endpoint& peer, TimePoint now) {
    if (context_.host.free_channels() <= max_channels / 2 || descriptors_left() <= descriptors_of_links()) return false;
    const PeerBook::Rank rank = is_trusted(peer.address) ? PeerBook::Rank::trusted : PeerBook::Rank::ordinary;
    const PeerBook::Place place = book_.place_for(peer, now, rank);
    return place.free && !place.evicted;
}

void TcpListenLink::admit_silent() {
    const TimePoint now = context_.host.now();
    clients_without_frame_.admit_silent([&](const Endpoint& peer) { return has_room_for_silent(peer, now); });
    if (clients_without_frame_.size() > 0) silent_again_.set(now + between_silent);
}

bool TcpListenLink::is_trusted(const IpAddress& address) const {
    const TcpListenSettings& tcp = settings().as<TcpListenSettings>();
    return tcp.trusted_any || contains(tcp.trusted, address);
}

PeerBook::Rank TcpListenLink::rank_of(const ClientsWithoutFrame::Sender& sender) const {
    if (is_trusted(sender.peer.address)) return PeerBook::Rank::trusted;
    return sender.commands ? PeerBook::Rank::commands : PeerBook::Rank::ordinary;
}

bool TcpListenLink::admit(int fd, const ClientsWithoutFrame::Sender& sender) try {
    const TimePoint now = context_.host.now();
    const PeerBook::Rank rank = rank_of(sender);
    if (!make_place(sender, rank, now)) return no_place_.add(now), false;
    context_.host.make_channel_free(rank);
    Channel* const channel = context_.host.open_channel(*this, sender.peer.text());
    if (!channel) return no_channel_.add(now), false;
    try {
        begin(fd, sender, *channel);
    } catch (const std::bad_alloc&) {
        if (Connection* const connection = connection_of(channel->id)) end(*connection, {});
        else context_.host.close_channel(*channel, {});
        throw;
    }
    return true;
} catch (const std::bad_alloc&) {
    return no_memory_.add(context_.host.now()), false;
}

// Everything that may fail comes before the connection is in use.
void TcpListenLink::begin(int fd, const ClientsWithoutFrame::Sender& sender, Channel& channel) {
    const TcpListenSettings& tcp = settings().as<TcpListenSettings>();
    const TimePoint now = context_.host.now();
    StoredLink received;
    received.unread_since = context_.host.turn().clocks();
    received.rest = sender.bytes;
    UniqueFd own{::fcntl(fd, F_DUPFD_CLOEXEC, 0)};
    if (!own) throw std::bad_alloc{};
    auto connection = std::make_unique<Connection>(*this, sender.peer, channel);
    const bool is_near = networks_.contain(sender.peer.address, now);
    connections_.push_back(std::move(connection));
    book_.add(channel.id, sender.peer, is_near, now, rank_of(sender));
    const bool is_known = is_trusted(sender.peer.address) || (sender.tls && tcp.tls.verify == TlsVerify::peer);
    if (!settings().group.empty() && !is_known) context_.host.leave_group(channel);
    connections_.back()->encrypt_by(sender.tls);
    if (!received.rest.empty()) connections_.back()->go_on_from(std::move(received));
    connections_.back()->open(std::move(own), channel);
}

bool TcpListenLink::make_place(const ClientsWithoutFrame::Sender& sender, PeerBook::Rank rank, TimePoint now) {
    const PeerBook::Place place = book_.place_for(sender.peer, now, rank, sender.commands);
    if (place.free && !place.evicted) return true;
    const auto ending = std::ranges::find_if(connections_, [](const auto& one) { return one->only_awaits_answers(); });
    if (ending != connections_.end()) {
        end(**ending, "it closed the connection");
        return make_place(sender, rank, now);
    }
    Connection* leaves = former_of(sender, rank, now);
    if (!leaves && place.evicted) leaves = connection_of(*place.evicted);
    if (leaves) end(*leaves, "another peer needed the connection");
    return leaves;
}

// A program or device that reconnected: the kernel notices only later that its old connection is lost. Hosts share one address, so
// that of a host must also have acknowledged nothing.
TcpListenLink::Connection* TcpListenLink::former_of(const ClientsWithoutFrame::Sender& sender, PeerBook::Rank rank,
                                                    TimePoint now) {
    if (!sender.source) return nullptr;
    for (const auto& one : connections_) {
        const bool is_same = one->address == sender.peer.address && one->has_heard(*sender.source);
        const bool is_silent = now - one->heard_at() >= one_exchange;
        const bool is_lost = !ano::address::is_host(*sender.source) || one->not_acknowledged_for() >= one_exchange;
        if (is_same && is_silent && is_lost && book_.rank(one->id) <= rank) return one.get();
    }
    return nullptr;
}

TcpListenLink::Connection* TcpListenLink::connection_of(ChannelId channel) const {
    const auto at = std::find_if(connections_.begin(), connections_.end(), [&](const auto& c) { return c->id == channel; });
    return at == connections_.end() ? nullptr : at->get();
}

bool TcpListenLink::is_allowed(const IpAddress& address, TimePoint now) {
    const TcpListenSettings& tcp = settings().as<TcpListenSettings>();
    if (tcp.allow_any || contains(tcp.allow, address)) return true;
    return tcp.allow.empty() && networks_.contain(address, now);
}

// A restarted device connects again, while its old connection still appears open. The old connection is closed once it has been
// silent for `one_exchange`. Hosts share one address, so they are not checked. True: an old connection was active recently.
bool TcpListenLink::has_rival(const Connection& from, std::uint8_t source) {
    if (ano::address::is_host(source)) return false;
    bool has = false;
    const TimePoint now = context_.host.now();
    for (std::size_t i = connections_.size(); i-- > 0;) {
        Connection& other = *connections_[i];
        if (&other == &from || other.address != from.address || other.since > from.since || !other.has_heard(source)) continue;
        if (now - other.heard_at() >= one_exchange) end(other, "its device reconnected");
        else has = true;
    }
    return has;
}

void TcpListenLink::end(Connection& connection, const std::string& why) {
    const auto at = std::find_if(connections_.begin(), connections_.end(), [&](const auto& c) { return c.get() == &connection; });
    if (at == connections_.end()) return;
    ended_.push_back(std::move(*at));
    connections_.erase(at);
    book_.remove(connection.id);
    Channel& channel = connection.channel();
    connection.close();
    connection.end_of_input();
    if (const V7Edge* translation = connection.translation()) add(v7_of_ended_, translation->counters());
    context_.host.close_channel(channel, why);
    sweep_.set(context_.host.now());
}

void TcpListenLink::forget_peer(ChannelId channel) {
    if (Connection* const connection = connection_of(channel)) end(*connection, "another peer needed the channel");
}

void TcpListenLink::flush(Channel& channel) {
    if (Connection* const connection = connection_of(channel.id)) connection->write();
}

void TcpListenLink::stop_reading() {
    is_ending_ = true;
    listener_.stop_reading();
    accept_again_.cancel();
    silent_again_.cancel();
    reconnect_.stop();
    if (certificates_) certificates_->stop();
    if (handshakes_) handshakes_->close();
    clients_without_frame_.stop_reading();
    for (const auto& one : connections_) one->pause_reading();
}

void TcpListenLink::stop() {
    reconnect_.stop();
    if (certificates_) certificates_->stop();
    accept_again_.cancel();
    silent_again_.cancel();
    sweep_.cancel();
    listener_.close();
    if (handshakes_) handshakes_->close();
    clients_without_frame_.close();
    connections_.clear();
    ended_.clear();
    book_.clear();
}

std::size_t TcpListenLink::unsent() const {
    std::size_t bytes = 0;
    for (const auto& one : connections_) bytes += one->not_acknowledged();
    return bytes;
}

std::optional<std::chrono::milliseconds> TcpListenLink::unacknowledged_for(ChannelId channel) const {
    const Connection* const connection = connection_of(channel);
    return connection ? std::optional{connection->not_acknowledged_for()} : std::nullopt;
}

LinkFacts TcpListenLink::facts() const {
    const EndpointSpec& written = settings().as<TcpListenSettings>().local;
    LinkFacts facts{{"address", listener_.is_open() ? local_.text() : written.text()},
                    {"port", std::int64_t{listener_.is_open() ? local_.port : written.port}}};
    if (const auto days = certificates_ ? certificates_->days_left() : std::nullopt) facts.push_back({"certificate_days", *days});
    if (listener_.is_open()) facts.push_back({"without_frame", static_cast<std::int64_t>(clients_without_frame_.size())});
    if (settings().as<TcpListenSettings>().v7.is_on()) {
        V7Counters all = v7_of_ended_;
        for (const auto& one : connections_) add(all, one->translation()->counters());
        add_v7_facts(facts, all);
    }
    if (handshakes_) facts.push_back({"handshakes_gave_way", static_cast<std::int64_t>(handshakes_->evicted().count)});
    return facts;
}

LinkError TcpListenLink::trouble() const {
    if (LinkError files = certificates_ ? tls_trouble(*certificates_) : LinkError{}; !files.text.empty()) return files;
    const TimePoint now = context_.host.now();
    if (const std::string count = handshakes_ ? handshakes_->evicted().recent(now) : ""; !count.empty())
        return {"handshakes",
                connections_were(count) + " closed during the TLS handshake: unknown senders held all places for it",
                {{"count", count}}};
    if (no_channel_.is_recent(now)) return all_channels_used();
    if (const std::string count = no_place_.recent(now); !count.empty())
        return {"no_place",
                count +
                    (count == "1" ? " connection or frame of a new sender was" : " connections or frames of new senders were") +
                    " refused: the limit of peers is reached",
                {{"count", count}}};
    if (const std::string count = no_memory_.recent(now); !count.empty())
        return {"no_memory", connections_were(count) + " refused: not enough memory or file descriptors", {{"count", count}}};
    if (const std::string count = failed_handshakes_.recent(now); !count.empty())
        return {"tls", connections_were(count) + " refused, most recently: " + last_fault_, {}};
    if (outsiders_ == 0 || !connections_.empty()) return {};
    return {"sender_refused", "senders outside `allow` were refused", {}};
}

UnassignedTraffic TcpListenLink::unassigned_traffic() const {
    UnassignedTraffic traffic;
    traffic.received = clients_without_frame_.received();
    traffic.v7_frames = clients_without_frame_.v7_frames();
    traffic.parser = clients_without_frame_.parser();
    traffic.without_frame = clients_without_frame_.size();
    traffic.no_place = no_place_.count;
    traffic.no_memory = no_memory_.count;
    traffic.outsiders = outsiders_;
    if (handshakes_ && handshakes_->evicted().is_recent(context_.host.now())) traffic.handshakes = handshakes_->evicted().count;
    return traffic;
}

namespace {

using namespace key_rows;
using TcpListen = TcpListenSettings;

constexpr Key<LinkSettings> own_tcp_listen_keys[] = {
    endpoint<own<TcpListen>, &TcpListen::local>("address", "local IP:PORT to listen on") | needed | key_rows::local,
    duration<own<TcpListen>, &TcpListen::dead_after>("dead_after", second, day, dead_after_help),
    integer<own<TcpListen>, &TcpListen::max_peers>("max_peers", 1, max_channels,
                                                   "maximum number of peers; a quarter is reserved for hosts that send commands"),
    integer<own<TcpListen>, &TcpListen::max_per_address>(
        "max_per_address", 1, max_channels,
        "maximum number of peers per IPv4 address or IPv6 /64, except loopback (default: a quarter of "
        "max_peers, at least two)"),
    networks<TcpListen, &TcpListen::allow_any, &TcpListen::allow>(
        "allow", "networks that may connect, or any (default: the local networks)"),
    networks<TcpListen, &TcpListen::trusted_any, &TcpListen::trusted>(
        "trusted",
        "networks for which a quarter of max_peers is reserved, or any; of a group only these peers are members "
        "(default: none)"),
};
constexpr auto tcp_listen_keys = with_v7(own_tcp_listen_keys, v7_rows<TcpListen>());

constexpr Key<LinkSettings> own_tls_listen_keys[] = {
    endpoint<own<TcpListen>, &TcpListen::local>("address", "local IP:PORT to listen on") | needed | key_rows::local,
    duration<own<TcpListen>, &TcpListen::dead_after>("dead_after", second, day, dead_after_help),
    integer<own<TcpListen>, &TcpListen::max_peers>("max_peers", 1, max_channels,
                                                   "maximum number of peers; a quarter is reserved for hosts that send commands"),
    integer<own<TcpListen>, &TcpListen::max_per_address>(
        "max_per_address", 1, max_channels,
        "maximum number of peers per IPv4 address or IPv6 /64, except loopback (default: a quarter of "
        "max_peers, at least two)"),
    networks<TcpListen, &TcpListen::allow_any, &TcpListen::allow>(
        "allow", "networks that may connect, or any (default: the local networks)"),
    networks<TcpListen, &TcpListen::trusted_any, &TcpListen::trusted>(
        "trusted",
        "networks for which a quarter of max_peers is reserved, or any; of a group only these peers are members "
        "(default: none)"),
    text<own<TcpListen>, &TcpListen::tls, &LinkCertificates::certificate>("certificate", 1, max_path, certificate_help) |
        as("FILE") | needed,
    text<own<TcpListen>, &TcpListen::tls, &LinkCertificates::key>("key", 1, max_path, key_help) | as("FILE") | needed,
    text<own<TcpListen>, &TcpListen::tls, &LinkCertificates::ca>("ca", 1, max_path, ca_help) | as("FILE"),
    choice<own<TcpListen>, &TcpListen::tls, &LinkCertificates::verify>("verify", "peer|none",
                                                                       "none: clients need no certificate"),
};
constexpr auto tls_listen_keys = with_v7(own_tls_listen_keys, v7_rows<TcpListen>());

void validate_tcp_listener(const LinkSettings& link, LinkFaults& faults) {
    if (link.hello && *link.hello != Duration{})
        faults.error("hello", "'hello' is not possible where the device connects; for a device at a known address use " +
                                  std::string{link.kind->encrypts ? "tls" : "tcp"} + ":HOST:PORT,hello=on");
    const TcpListen& listen = link.as<TcpListen>();
    if (faults.is_whole()) check_tcp_address(listen.local, faults);
    check_per_address(listen.max_per_address, listen.max_peers, faults);
    const bool has_certificates = link.kind->encrypts && listen.tls.verify == TlsVerify::peer;
    check_group(link, has_certificates || listen.trusted_any || !listen.trusted.empty(), faults);
    check_v7(listen.v7, faults);
}

void validate_tls_listener(const LinkSettings& link, LinkFaults& faults) {
    validate_tcp_listener(link, faults);
    const LinkCertificates& tls = link.as<TcpListen>().tls;
    if (tls.certificate.empty()) faults.error("certificate", "'certificate' is missing: create one with 'anoctl certificate'");
    if (tls.key.empty()) faults.error("key", "'key' is missing: the private key file of the certificate");
    if (tls.verify == TlsVerify::peer && tls.ca.empty())
        faults.error("ca",
                     "'ca' is missing: the certificate file that the peers' certificates are signed with; or set verify=none to "
                     "let anyone "
                     "connect");
}

Reach reach_of_tcp(const LinkSettings& link) {
    const TcpListen& listen = link.as<TcpListen>();
    if (listen.local.address.is_loopback()) return Reach::here;
    if (link.kind->encrypts && listen.tls.verify == TlsVerify::peer) return Reach::network;    // only peers with a certificate
    return listen.local.address.is_any() && (listen.allow_any || listen.allow.empty()) ? Reach::whole_networks : Reach::network;
}

std::optional<BoundPort> port_of_tcp(const LinkSettings& link) {
    return BoundPort{link.as<TcpListen>().local, {}, "address", true};
}

}    // namespace

extern const LinkKind tcp_listen_kind;    // listed in kinds.cpp
constinit const LinkKind tcp_listen_kind{
    .name = "tcp-listen",
    .address = "address",
    .example = "0.0.0.0:12333",
    .help = "a listening TCP port; each connection is a peer; port 0: chosen by the kernel",
    .carries = Carries::bytes,
    .over_network = true,
    .listens = true,
    .may_be_paced = true,
    .keys = tcp_listen_keys,
    .settings = [] { return KindSettings{TcpListen{}}; },
    .make = make_link_of<TcpListenLink>,
    .usual_name = [](const LinkSettings& link) { return "tcp-listen-" + std::to_string(link.as<TcpListen>().local.port); },
    .bound_port = port_of_tcp,
    .reach = reach_of_tcp,
    .validate = validate_tcp_listener,
};

extern const LinkKind tls_listen_kind;    // listed in kinds.cpp
constinit const LinkKind tls_listen_kind{
    .name = "tls-listen",
    .address = "address",
    .example = "0.0.0.0:12334",
    .help = "an encrypted listening TCP port; clients present a certificate",
    .carries = Carries::bytes,
    .over_network = true,
    .encrypts = true,
    .listens = true,
    .may_be_paced = true,
    .keys = tls_listen_keys,
    .settings = [] { return KindSettings{TcpListen{}}; },
    .make = make_link_of<TcpListenLink>,
    .usual_name = [](const LinkSettings& link) { return "tls-listen-" + std::to_string(link.as<TcpListen>().local.port); },
    .bound_port = port_of_tcp,
    .reach = reach_of_tcp,
    .validate = validate_tls_listener,
};

}    // namespace anogate
