#include <ano_json/nearest.hpp>
#include <config/link_kind.hpp>
#include <control/raw_streams.hpp>
#include <http/routes.hpp>
#include <http/web_socket.hpp>
#include <link/raw_port.hpp>
#include <log/log_line.hpp>
#include <runtime/gateway.hpp>
#include <watch/frame_filter.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Kind = http::WebSocket::Kind;
using Json = nlohmann::ordered_json;

constexpr std::uint16_t going_away = 1001, policy_violation = 1008;    // close codes of WebSocket (RFC 6455)

// As `anoctl links` writes it.
template <class Links>
std::string unknown_link(const std::string& name, const Links& links) {
    std::vector<std::string_view> known;
    known.reserve(std::size(links));
    for (const LinkState& state : links) known.push_back(state.link->name());
    std::string text = "unknown link " + in_quotes(name) + ano::did_you_mean(name, known);
    for (std::size_t i = 0; i < known.size(); ++i) text.append(i == 0 ? "; links: " : ", ").append(known[i]);
    return text;
}

std::string message_of(char direction, std::span<const std::uint8_t> bytes) {
    const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
    const auto ns = static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count());
    std::string message{direction};
    for (unsigned i = 0; i < 8; ++i) message += static_cast<char>(ns >> 8 * i & 0xFF);
    return message.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}    // namespace

/// One client.
class RawSocket final : public http::WebSocketUser {
public:
    RawSocket(RawStreams& streams, std::string link, bool exclusive, bool may_send)
        : streams_{streams}, link_{std::move(link)}, exclusive_{exclusive}, may_send_{may_send} {}
    ~RawSocket() override {
        if (port_) streams_.leave(*this);
    }

    // Commands to the link wait for its end, so a client that is gone must not keep it.
    ano::Duration idle(ano::Duration usual) const override { return exclusive_ ? max_silence : usual; }
    void opened(http::WebSocket& socket) override {
        socket_ = &socket;
        if (const std::string why_not = streams_.join(*this); !why_not.empty()) socket.close(policy_violation, why_not);
    }
    void heard(std::string_view message, Kind kind) override {
        if (!port_) return;
        if (!may_send_) return send_message({{"error", "not sent: this token is read-only"}});
        if (kind == Kind::text) return send_message({{"error", "not sent: send bytes as binary messages"}});
        if (!port_->write_raw({reinterpret_cast<const std::uint8_t*>(message.data()), message.size()}))
            send_message({{"error", "not sent: the link is down or still busy with earlier data"}});
    }
    void sent_all() override { send_lost(); }

    void pass(char direction, std::span<const std::uint8_t> bytes) {
        bool is_sent = false;
        socket_->attempt([&] {
            send_lost();
            const bool fits = lost_received_ + lost_sent_ == 0 && socket_->waiting() + bytes.size() <= RawStreams::max_waiting;
            is_sent = fits && socket_->send(std::make_shared<const std::string>(message_of(direction, bytes)), Kind::binary);
        });
        if (!is_sent) (direction == '<' ? lost_received_ : lost_sent_) += bytes.size();
    }
    void begin(LinkId id, RawPort& port, const LinkSettings& settings) {
        id_ = id;
        port_ = &port;
        send_message({{"link", link_},
                      {"kind", settings.kind->name},
                      {"encoding", settings.text_encoding() == TextEncoding::gbk ? "gbk" : "utf8"},
                      {"exclusive", exclusive_},
                      {"may_send", may_send_}});
    }
    /// The link was removed, or recreated with other settings.
    void detach() {
        port_ = nullptr;
        socket_->close(going_away, "the link was removed or changed");
    }
    const std::string& link() const noexcept { return link_; }
    LinkId id() const noexcept { return id_; }
    bool is_exclusive() const noexcept { return exclusive_; }

private:
    static constexpr ano::Duration max_silence = std::chrono::seconds{3};

    void send_message(const Json& what) { socket_->send(std::make_shared<const std::string>(what.dump()), Kind::text); }
    void send_lost() {
        if (lost_received_ + lost_sent_ == 0 || !port_ || socket_->waiting() > 0) return;
        send_message({{"lost", {{"received", std::exchange(lost_received_, 0)}, {"sent", std::exchange(lost_sent_, 0)}}}});
    }

    RawStreams& streams_;
    std::string link_;
    bool exclusive_, may_send_;
    http::WebSocket* socket_ = nullptr;
    LinkId id_{};
    RawPort* port_ = nullptr;                            // nullptr: not joined
    std::uint64_t lost_received_ = 0, lost_sent_ = 0;    // bytes
};

/// A link with clients.
class RawStreams::TappedLink final : public RawTap {
public:
    explicit TappedLink(RawPort& port) : port_{port} { port_.set_tap(this); }
    ~TappedLink() { port_.set_tap(nullptr); }
    void received(std::span<const std::uint8_t> bytes) override {
        for (RawSocket* socket : sockets) socket->pass('<', bytes);
    }
    void sent(std::span<const std::uint8_t> bytes) override {
        for (RawSocket* socket : sockets) socket->pass('>', bytes);
    }

    std::vector<RawSocket*> sockets;

private:
    RawPort& port_;
};

RawStreams::RawStreams(Gateway& gateway) : gateway_{gateway} {}

RawStreams::~RawStreams() { gateway_.forwarder().remove_observer(*this); }

http::Response RawStreams::answer(const http::Request& request) {
    if (http::Response fault = http::web_socket_fault(request); fault.status != 200) return fault;
    const std::string name{request.parameter("link")};
    const auto& links = gateway_.links();
    const auto state = std::find_if(links.begin(), links.end(), [&](const LinkState& s) { return s.link->name() == name; });
    if (state == links.end()) return http::error(404, unknown_link(name, links));
    if (!state->link->as<RawPort>())
        return http::error(409, "the raw bytes of a " + std::string{state->link->settings().kind->name} +
                                    " link are not available, only those of serial, hid, pty, udp, tcp and sim links");
    const auto exclusive = parse_flag("exclusive", request.query_value("exclusive").value_or("no"));
    if (!exclusive) return http::error(400, exclusive.error());
    const bool may_send = request.access == http::Access::control;
    if (*exclusive && !may_send) return http::not_permitted(request.access, http::Access::control);
    if (*exclusive && is_exclusive(name)) return http::error(409, "another client has exclusive use of " + in_quotes(name));
    http::Response response;
    response.web_socket = std::make_unique<RawSocket>(*this, name, *exclusive, may_send);
    return response;
}

std::string RawStreams::join(RawSocket& socket) {
    for (const LinkState& state : gateway_.links()) {
        RawPort* const port = state.link->name() == socket.link() ? state.link->as<RawPort>() : nullptr;
        if (!port) continue;
        if (socket.is_exclusive() && is_exclusive(socket.link())) return "another client has exclusive use of the link";
        if (tapped_.empty())
            gateway_.forwarder().add_observer(*this, {false, false, false});    // for the notice that the link is removed
        auto& tapped = tapped_[state.link->id()];
        if (!tapped) tapped = std::make_unique<TappedLink>(*port);
        tapped->sockets.push_back(&socket);
        socket.begin(state.link->id(), *port, state.link->settings());
        if (socket.is_exclusive()) set_exclusive(state.link->id(), true);
        return {};
    }
    return "the link is gone";
}

void RawStreams::leave(RawSocket& socket) {
    const auto tapped = tapped_.find(socket.id());
    if (tapped == tapped_.end()) return;
    std::erase(tapped->second->sockets, &socket);
    if (socket.is_exclusive()) set_exclusive(socket.id(), false);
    if (!tapped->second->sockets.empty()) return;
    tapped_.erase(tapped);
    if (tapped_.empty()) gateway_.forwarder().remove_observer(*this);
}

void RawStreams::set_exclusive(LinkId link, bool exclusive) {
    gateway_.forwarder().set_exclusive(link, exclusive);
    log_info("{}: {}", gateway_.link(link).name(),
             exclusive ? "in exclusive use by a terminal; frames for it are dropped (denied_out)"
                       : "the terminal with exclusive use has ended; frames are forwarded again");
}

bool RawStreams::is_exclusive(const std::string& link) const {
    for (const auto& [id, tapped] : tapped_)
        for (const RawSocket* socket : tapped->sockets)
            if (socket->link() == link && socket->is_exclusive()) return true;
    return false;
}

void RawStreams::removed(LinkId link) {
    const auto node = tapped_.extract(link);
    if (node.empty()) return;
    for (RawSocket* socket : std::exchange(node.mapped()->sockets, {})) socket->detach();
}

}    // namespace anogate
