#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <config/values.hpp>
#include <link/make_link.hpp>
#include <link/tcp/tcp_keys.hpp>
#include <link/tcp/tcp_link.hpp>
#include <link/tcp/tcp_socket.hpp>
#include <link/v7_keys.hpp>
#include <sys/errors.hpp>

#include <cerrno>
#include <utility>

namespace anogate {
namespace {

const HostSpec& tcp_peer(const LinkSettings& link) { return link.as<TcpSettings>().peer; }

}    // namespace

TcpLink::TcpLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      TcpSession{context, this->settings(), this->settings().as<TcpSettings>().dead_after},
      connector_{context, tcp_peer(this->settings()), this->settings().as<TcpSettings>().dead_after,
                 [this](UniqueFd fd, const Endpoint& peer) { connected(std::move(fd), peer); },
                 [this](LinkError why) { reconnect_.lost(std::move(why)); }},
      reconnect_{context, *this,
                 [this]() -> Opened<void> {
                     connect();
                     return {};
                 },
                 Backoff::network} {
    if (this->settings().kind->encrypts)
        certificates_ = std::make_unique<CertificateReader>(context, *this, this->settings().as<TcpSettings>().tls,
                                                            TlsContext::Side::connects);
    translate(this->settings().as<TcpSettings>().v7, this->settings());
}

void TcpLink::connect() {
    if (!certificates_) return connector_.start();
    certificates_->read([this](Opened<void> usable) {
        if (usable) connector_.start();
        else reconnect_.lost(std::move(usable.error()));
    });
}

void TcpLink::connected(UniqueFd fd, const Endpoint& peer) {
    if (certificates_) {
        const HostSpec& to = tcp_peer(settings());
        auto encrypted = certificates_->connection(fd.get(), to.host.empty() ? to.address.text() : to.host);
        if (!encrypted) return reconnect_.lost(std::move(encrypted.error()));
        encrypt_by(std::move(*encrypted));
    }
    connected_to_ = peer.text();
    open(std::move(fd), *channel_);
}

void TcpLink::start() {
    channel_ = context_.host.open_channel(*this, tcp_peer(settings()).text());
    reconnect_.start();
}

void TcpLink::opened() {
    reconnect_.came_up(context_.host.now());
    pacing().start(settings().rate, settings().latency, settings().gap);
    resume_reading();
    context_.host.link_up(*this);
}

void TcpLink::read_ended(int error) {
    const std::string peer = tcp_peer(settings()).text();
    if (const std::string fault = tls_fault(); !fault.empty()) return fail({"tls", "TLS with " + peer + ": " + fault, {}});
    if (error == 0 || error == ECONNRESET || error == EPIPE)
        return fail({"closed_by_peer", peer + " closed the connection", {{"peer", peer}}});
    if (error == ETIMEDOUT || error == EHOSTUNREACH || error == ENETUNREACH)
        return fail({"peer_silent",
                     peer + " acknowledged nothing for " + duration_text(silent_for()) + ": the connection is broken",
                     {{"peer", peer}}});
    fail(error_text(peer, error));
}

void TcpLink::fail(LinkError why) {
    connected_to_.clear();
    close();
    end_of_input();
    reconnect_.lost(std::move(why));
}

void TcpLink::stop_reading() {
    pause_reading();
    if (certificates_) certificates_->stop();
    connector_.stop();
    reconnect_.stop();
}

void TcpLink::stop() {
    if (certificates_) certificates_->stop();
    connector_.stop();
    reconnect_.stop();
    close();
}

LinkError TcpLink::trouble() const { return certificates_ ? tls_trouble(*certificates_) : LinkError{}; }

std::size_t TcpLink::unsent() const { return not_acknowledged(); }

LinkFacts TcpLink::facts() const {
    LinkFacts facts{{"peer", tcp_peer(settings()).text()}};
    if (const auto days = certificates_ ? certificates_->days_left() : std::nullopt) facts.push_back({"certificate_days", *days});
    add_facts(facts);
    if (!is_open()) return facts;
    facts.push_back({"address", connected_to_});
    facts.push_back({"unacknowledged_ms", std::int64_t{not_acknowledged_for().count()}});
    return facts;
}

namespace {

using namespace key_rows;
using Tcp = TcpSettings;

constexpr Key<LinkSettings> own_tcp_keys[] = {
    host<own<Tcp>, &Tcp::peer>("address", "HOST:PORT to connect to; a name or an IP address") | needed,
    duration<own<Tcp>, &Tcp::dead_after>("dead_after", second, day, dead_after_help),
};
constexpr auto tcp_keys = with_v7(own_tcp_keys, v7_rows<Tcp>());

void validate_tcp(const LinkSettings& link, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    check_v7(link.as<Tcp>().v7, faults);
    const HostSpec& peer = tcp_peer(link);
    const std::string text = peer.text();
    if (peer.port == 0) faults.error("address", in_quotes(text) + " has port 0: give the port of the peer, 1 to 65535");
    if (!peer.host.empty()) return;
    if (peer.address.is_any())
        faults.error("address", in_quotes(text) + " is not the address of a peer; to accept connections there, use " +
                                    (link.kind->encrypts ? "tls-listen:" : "tcp-listen:") + text);
    check_tcp_address(peer, faults);
}

std::optional<PeerPort> port_of_peer(const LinkSettings& link) { return PeerPort{tcp_peer(link), "address", true}; }

// The device would be received twice, and the gateway at the other end would see a loop.
std::optional<SharedByTwo> shared_peer(const LinkSettings& a, const LinkSettings& b) {
    if (tcp_peer(a) != tcp_peer(b)) return std::nullopt;
    return SharedByTwo{"address", in_quotes(tcp_peer(b).text()) + " is already the peer of "};
}

Reach reach_of_peer(const LinkSettings& link) { return tcp_peer(link).is_here() ? Reach::here : Reach::network; }

constexpr Key<LinkSettings> own_tls_keys[] = {
    host<own<Tcp>, &Tcp::peer>("address", "HOST:PORT to connect to; a name or an IP address") | needed,
    duration<own<Tcp>, &Tcp::dead_after>("dead_after", second, day, dead_after_help),
    text<own<Tcp>, &Tcp::tls, &LinkCertificates::certificate>("certificate", 1, max_path, certificate_help) | as("FILE"),
    text<own<Tcp>, &Tcp::tls, &LinkCertificates::key>("key", 1, max_path, key_help) | as("FILE"),
    text<own<Tcp>, &Tcp::tls, &LinkCertificates::ca>("ca", 1, max_path, ca_help) | as("FILE"),
    choice<own<Tcp>, &Tcp::tls, &LinkCertificates::verify>("verify", "peer|none", "none: the peer's certificate is not checked"),
};
constexpr auto tls_keys = with_v7(own_tls_keys, v7_rows<Tcp>());

void validate_tls(const LinkSettings& link, LinkFaults& faults) {
    validate_tcp(link, faults);
    check_pair(link.as<Tcp>().tls, faults);
    if (link.as<Tcp>().tls.verify == TlsVerify::none)
        faults.warning("verify", "with verify=none anyone on the network path can impersonate " + tcp_peer(link).text());
}

}    // namespace

extern const LinkKind tcp_kind;    // listed in kinds.cpp
constinit const LinkKind tcp_kind{
    .name = "tcp",
    .address = "address",
    .example = "192.168.4.1:8080",
    .help = "a TCP connection to a listening peer: a Wi-Fi bridge (ESP8266, ESP32), ser2net, another program",
    .carries = Carries::bytes,
    .over_network = true,
    .may_be_paced = true,
    .hints = {.nothing_yet = {"nothing_from_peer", "nothing received yet from the peer"}, .may_wait_for_hello = true},
    .keys = tcp_keys,
    .settings = [] { return KindSettings{Tcp{}}; },
    .make = make_link_of<TcpLink>,
    .usual_name = [](const LinkSettings& link) { return "tcp-" + std::to_string(tcp_peer(link).port); },
    .connects_to = port_of_peer,
    .reach = reach_of_peer,
    .validate = validate_tcp,
    .shared = shared_peer,
};

extern const LinkKind tls_kind;    // listed in kinds.cpp
constinit const LinkKind tls_kind{
    .name = "tls",
    .address = "address",
    .example = "gateway.local:12334",
    .help = "an encrypted TCP connection; both ends present a certificate",
    .carries = Carries::bytes,
    .over_network = true,
    .encrypts = true,
    .may_be_paced = true,
    .hints = {.nothing_yet = {"nothing_from_peer", "nothing received yet from the peer"}, .may_wait_for_hello = true},
    .keys = tls_keys,
    .settings = [] { return KindSettings{Tcp{}}; },
    .make = make_link_of<TcpLink>,
    .usual_name = [](const LinkSettings& link) { return "tls-" + std::to_string(tcp_peer(link).port); },
    .connects_to = port_of_peer,
    .reach = reach_of_peer,
    .validate = validate_tls,
    .shared = shared_peer,
};

}    // namespace anogate
