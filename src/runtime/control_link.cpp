#include <ano_json/text.hpp>
#include <config/link_kind.hpp>
#include <config/values.hpp>
#include <http/web_socket.hpp>
#include <link/feed.hpp>
#include <runtime/control_link.hpp>
#include <sys/asio.hpp>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate {
namespace {

using Kind = http::WebSocket::Kind;

constexpr std::size_t message_size = 16 * 1024;    // bytes per message to a program, unless one frame is larger
constexpr std::size_t frames_per_message = 64;
constexpr std::uint16_t going_away = 1001, policy_violation = 1008,
                        try_again_later = 1013;    // why a WebSocket is closed (RFC 6455)
constexpr std::size_t max_name = 64;

// This kind can't be configured.
constinit const LinkKind control_kind{.name = "control", .carries = Carries::datagrams};

}    // namespace

/// One program. It has its channel from opened() on.
class LinkSocket final : public http::WebSocketUser {
public:
    LinkSocket(ControlLink& link, std::string name, std::uint8_t port_id)
        : link_{link}, name_{std::move(name)}, port_id_{port_id} {}
    ~LinkSocket() override {
        if (!channel_) return;
        link_.sockets_[index(channel_->id)] = nullptr;
        host().close_channel(*channel_, {});
    }

    void opened(http::WebSocket& socket) override {
        socket_ = &socket;
        if (!link_.reads_) return socket.close(going_away, "the links of the gateway changed; connect again");
        if (port_id_ != 0 && !link_.is_free(port_id_))
            return socket.close(policy_violation, "the port id " + std::to_string(port_id_) + " is now in use");
        host().now();
        try {
            channel_ = host().open_channel(link_, name_);
        } catch (const std::bad_alloc&) {
            return socket.close(try_again_later, "not enough memory for another channel");
        }
        if (!channel_) return socket.close(try_again_later, "all 64 channels of the gateway are in use");
        link_.sockets_[index(channel_->id)] = this;
        if (port_id_ != 0) link_.forwarder_.bear(*channel_, port_id_);
        host().link_up(link_);
    }

    void heard(std::string_view message, Kind kind) override {
        if (!channel_ || !link_.reads_) return;
        if (kind == Kind::text) return send_error("text messages are not accepted; send frames as binary messages");
        channel_->arrived_at = arrival_.unstamped(host().turn());
        const std::uint64_t skipped_before = channel_->parser.counters().skipped_bytes;
        const auto pass = [this](ano::FrameView frame) { host().receive(*channel_, frame); };
        const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(message.data()), message.size()};
        feed_datagram(channel_->parser, bytes, channel_->arrived_at, pass);
        channel_->parser.finish();    // a message contains only complete frames
        while (const auto frame = channel_->parser.next()) pass(*frame);
        const std::uint64_t skipped = channel_->parser.counters().skipped_bytes - skipped_before;
        if (skipped > 0)
            send_error(std::to_string(skipped) + " bytes of a message were not part of a complete frame and were ignored");
        if (arrival_.is_behind()) look_for_more();
        host().flush();
    }

    /// The link is being destroyed and must not be used any more.
    void detach() {
        channel_ = nullptr;
        alive_.reset();
        socket_->close(going_away, "the links of the gateway changed; connect again");
    }

    std::uint8_t port_id() const { return port_id_; }

    /// Closes the channel of the program; the link stays.
    void leave(const std::string& why) {
        Channel* const channel = std::exchange(channel_, nullptr);
        alive_.reset();
        host().close_channel(*channel, why);
        socket_->close(policy_violation, why);
    }

    void sent_all() override {
        if (channel_) flush();
    }

    void flush() {
        socket_->attempt([this] { send_waiting(); });
    }

private:
    // Sends one message at a time; other frames wait in the outbox, where they may expire or be superseded.
    void send_waiting() {
        Outbox& outbox = channel_->outbox;
        if (socket_->waiting() > 0) return outbox.set_congested();
        const TimePoint now = host().now();
        const std::size_t first = outbox.next(now).size;
        if (first == 0) return;
        std::array<std::span<const std::uint8_t>, frames_per_message> pieces;
        const std::size_t count = outbox.gather(pieces, now, std::max(first, message_size));
        auto message = std::make_shared<std::string>();
        for (const auto piece : std::span{pieces}.first(count))
            message->append(reinterpret_cast<const char*>(piece.data()), piece.size());
        const std::size_t size = message->size();
        if (count == 0 || !socket_->send(std::move(message), Kind::binary)) return;
        outbox.sent(size);
        outbox.set_congested();
    }

    LinkHost& host() { return link_.context_.host; }

    void send_error(const std::string& what) {
        socket_->send(std::make_shared<const std::string>("{\"error\": \"" + what + "\"}"), Kind::text);
    }

    // Frames that waited during a standstill count as old as the standstill: all frames received until a complete turn of the
    // loop reads none.
    void look_for_more() {
        reads_then_ = socket_->reads();
        const auto clocks = host().turn().clocks();
        asio::post(link_.context_.io, [weak = std::weak_ptr{alive_}, this, clocks] {
            if (weak.expired()) return;
            asio::post(link_.context_.io, [weak, this, clocks] {
                if (!weak.expired() && socket_->reads() == reads_then_) arrival_.found_empty(clocks);
            });
        });
    }

    ControlLink& link_;
    std::string name_;
    std::uint8_t port_id_;
    http::WebSocket* socket_ = nullptr;
    Channel* channel_ = nullptr;
    Arrival arrival_;
    std::uint64_t reads_then_ = 0;
    std::shared_ptr<int> alive_ = std::make_shared<int>();
};

// A frame may be as large as the links permit.
LinkSettings ControlLink::link_settings(const Settings& settings) {
    LinkSettings link;
    link.kind = &control_kind;
    link.name = control_kind.name;
    for (const LinkSettings& other : settings.links) link.max_data = std::max(link.max_data, other.max_data);
    link.queue = std::max(link.queue, 2 * (static_cast<std::uint32_t>(ano::overhead) + link.max_data));
    link.rules = settings.control.rules;
    link.manage = settings.control.manage;
    return link;
}

ControlLink::ControlLink(LinkId id, LinkSettings settings, const LinkContext& context, Forwarder& forwarder)
    : Link{id, std::move(settings)}, context_{context}, forwarder_{forwarder} {}

ControlLink::~ControlLink() = default;

void ControlLink::stop() {
    stop_reading();
    for (LinkSocket*& socket : sockets_)
        if (LinkSocket* const leaving = std::exchange(socket, nullptr)) leaving->detach();
}

void ControlLink::release_ports(std::uint8_t own_id) {
    for (LinkSocket*& socket : sockets_) {
        const std::uint8_t port_id = socket ? socket->port_id() : 0;
        if (port_id == 0) continue;
        const bool is_own = port_id == own_id;
        if (!is_own && (forwarder_.router().port(port_id) - id()).empty()) continue;
        const std::string now = is_own ? "the gateway has the port id " : "another link has the port id ";
        std::exchange(socket, nullptr)->leave(now + std::to_string(port_id) + " now");
    }
}

void ControlLink::flush(Channel& channel) {
    if (LinkSocket* socket = sockets_[index(channel.id)]) socket->flush();
}

UnassignedTraffic ControlLink::unassigned_traffic() const {
    UnassignedTraffic traffic;
    if (sender_) traffic.received = sender_->received();
    return traffic;
}

http::Response ControlLink::join(const http::Request& request, std::uint8_t own_id) {
    const std::string name{request.query_value("name").value_or("program")};
    if (name.empty() || name.size() > max_name || !ano::is_utf8(name))
        return http::error(400, "name= must be text of 1 to 64 bytes");
    for (std::size_t i = 0; i < name.size(); ++i)
        if (ano::control_size(name, i) > 0) return http::error(400, "name= contains a control character");
    std::uint8_t port_id = 0;
    if (const auto text = request.query_value("id")) {
        const auto id = parse_address(*text);
        if (!id || *id == 0 || *id > ano::address::last_port_id) return http::error(400, "id= must be a port id, 1 to 20");
        if (*id == own_id) return http::error(409, "id= is the gateway's own id");
        if (!is_free(*id)) return http::error(409, "another link or channel already has the port id " + std::to_string(*id));
        port_id = *id;
    }
    if ((~forwarder_.channels()).empty()) return http::try_again("all 64 channels of the gateway are in use");
    http::Response response;
    response.web_socket = std::make_unique<LinkSocket>(*this, name, port_id);
    return response;
}

// The frame passes a parser, as all received bytes do, so that it is counted.
void ControlLink::send(ano::FrameView frame) {
    const TimePoint now = context_.host.now();
    if (!sender_) {
        const ano::FrameParser::Options parser{settings().max_data, 0, quiet_of(*settings().kind)};
        sender_ = std::make_unique<Channel>(ourselves, id(), "send", parser, Outbox::Options{ano::overhead, 0}, now);
    }
    sender_->arrived_at = now;
    feed_datagram(sender_->parser, frame.bytes(), now, [&](ano::FrameView whole) { forwarder_.send_on(*sender_, whole, now); });
}

ano::Flush ControlLink::flush_parsers(ano::FrameView next) { return forwarder_.flush_parsers(id(), next, context_.host.now()); }

}    // namespace anogate
