// 0xB1 and 0xB2: protocol frames inside protocol frames, sent over IP (protocol text, section 4; config/README.md, "Tunnel").
// Bytes in, bytes out; TunnelLink sends and receives them.
//
// Out:    tunnel.takes(frame)                    // received on one of `links`
//         tunnel.out(frame, …) → Datagram        // to send
// In:     tunnel.in(frame, sender, …)            // each tunnel frame of a datagram; calls back with the inner frames
//         tunnel.begin_wrap(rule, …), add(), end_wrap()
#pragma once
#include <ano/frame.hpp>
#include <ano/lazy_array.hpp>
#include <ano/messages.hpp>
#include <gateway/counters.hpp>
#include <gateway/host_spec.hpp>
#include <gateway/settings.hpp>
#include <gateway/tunnel/tunnel_policy.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace anogate {

inline constexpr std::uint8_t ip_tunnel = ano::id_of<"ip_tunnel">;                // complete addresses
inline constexpr std::uint8_t ip_tunnel_short = ano::id_of<"ip_tunnel_short">;    // only their last bytes
inline constexpr std::size_t max_datagram = 65507;                                // of UDP over IPv4

constexpr bool is_tunnel_frame(ano::FrameView frame) noexcept { return frame.id() == ip_tunnel || frame.id() == ip_tunnel_short; }

/// The addresses and the port at the beginning of DATA, before the inner frames.
struct TunnelHead {
    IpAddress source;
    IpAddress destination;
    std::uint16_t port = 0;
    friend bool operator==(const TunnelHead&, const TunnelHead&) = default;
};
/// The size of the head in a frame of this id, in bytes: 10 or 4.
constexpr std::size_t tunnel_head_size(std::uint8_t id) noexcept { return id == ip_tunnel ? 10 : 4; }

struct TunnelContent {
    TunnelHead head;
    std::span<const std::uint8_t> inner;    // in the frame's memory
};
/// Parses a tunnel frame; std::nullopt if DATA is shorter than the head. 0xB2 omits the first three bytes of both addresses: they
/// are those of `network`.
std::optional<TunnelContent> unwrap(ano::FrameView frame, const IpAddress& network) noexcept;

/// Reads the frames inside a tunnel frame. It ends at the first byte that does not begin a complete valid frame: a search beyond
/// it could find the frames inside a damaged inner tunnel frame.
class InnerFrames {
public:
    explicit InnerFrames(std::span<const std::uint8_t> inner) noexcept : rest_{inner}, empty_{inner.empty()} {}
    std::optional<ano::FrameView> next() noexcept;
    /// After next() returned std::nullopt: whether the content was only complete valid frames, at least one.
    bool good() const noexcept { return rest_.empty() && !empty_; }

private:
    std::span<const std::uint8_t> rest_;
    bool empty_;
};

/// Whether this is a tunnel frame that may contain a frame for which `is_meant` returns true: one is inside, or the content can't
/// be read (bytes that are not a complete valid frame, another tunnel frame). False for every other frame.
bool may_contain(ano::FrameView frame, bool (*is_meant)(ano::FrameView inner)) noexcept;

/// Builds one tunnel frame at a time in its own memory. Allocates once.
class TunnelWriter {
public:
    TunnelWriter() : buffer_{ano::max_frame_size} {}

    /// A frame of `id` from `source` to `destination`, with at most `max_data` bytes of DATA.
    void begin(std::uint8_t id, std::uint8_t source, std::uint8_t destination, std::size_t max_data) noexcept;
    /// False: `inner` does not fit.
    bool add(ano::FrameView inner) noexcept;
    bool empty() const noexcept { return inner().empty(); }
    std::span<const std::uint8_t> inner() const noexcept;
    /// The whole frame, valid until the next begin() or add().
    ano::FrameView finish(const TunnelHead& head) noexcept;

private:
    std::size_t inner_at() const noexcept { return ano::header_size + tunnel_head_size(buffer_[3]); }

    ano::LazyArray<std::uint8_t> buffer_;
    std::size_t end_ = 0;
    std::size_t max_end_ = 0;
};

/// Decides what is sent, opened, wrapped or refused. Neither throws nor allocates after construction.
class Tunnel {
public:
    /// Whether an inner frame may be forwarded: the filters, limits and switches of its incoming link.
    using Passes = std::function<bool(ano::FrameView)>;
    using OnFrame = std::function<void(ano::FrameView)>;
    /// The properties of the machine that the tunnel needs.
    struct Environment {
        /// Our address on the route to `there`, or for 0.0.0.0 the default one; std::nullopt: no route leads there.
        std::function<std::optional<IpAddress>(const IpAddress& there)> our_address;
        /// Whether the gateway itself listens on this port.
        std::function<bool(std::uint16_t port)> is_own_port;
    };

    /// `own_id`: the gateway's; 0: none.
    Tunnel(TunnelSettings settings, std::uint8_t own_id, Environment environment);

    /// The open port; port 0 in a tunnel frame means this port.
    void set_port(std::uint16_t port) noexcept { port_ = port; }
    /// The networks of our interfaces as they are now, loopback included.
    void set_networks(std::vector<Network> networks) { policy_.set_networks(std::move(networks)); }

    /// The addresses of the host names in the settings. A host name without an address matches no sender.
    void set_hosts(HostAddresses hosts);
    /// Whether the settings define our address; a host name may have no address now.
    bool has_ip() const noexcept { return settings_.ip || !settings_.ip_host.empty(); }
    std::optional<IpAddress> ip() const noexcept;

    /// Whether `frame`, received on one of `links`, is a tunnel frame for us. Then it is not forwarded, even if it is refused.
    bool takes(ano::FrameView frame) const noexcept;

    struct Datagram {
        Endpoint to;
        std::span<const std::uint8_t> bytes;    // valid until the next call of out()
    };
    /// The datagram for a tunnel frame of a device; std::nullopt: refused and counted, or no frame in it passed.
    std::optional<Datagram> out(ano::FrameView frame, const Passes& passes);
    /// The result of sending it.
    void sent() noexcept { ++counters_.out; }
    void refuse(std::uint64_t TunnelCounters::*cause) noexcept { ++(counters_.*cause); }

    /// Whether `sender` may send to the tunnel; counted if not.
    bool admits(const Endpoint& sender);
    /// Opens a tunnel frame that `sender` sent us and calls `on_frame` for each frame inside; one for another ip is refused. The
    /// source address in the frame is not used. True: there was at least one frame inside.
    bool in(ano::FrameView frame, const IpAddress& sender, const OnFrame& on_frame);
    /// Counts a datagram with at least one accepted frame.
    void came_in() noexcept { ++counters_.in; }

    /// The index in the settings of the first rule that matches `sender`, if any.
    std::optional<std::size_t> wrap_rule(const IpAddress& sender) const noexcept;
    /// Starts a tunnel frame for the frames of one datagram; false: refused, and counted once per datagram. `max_data` is that of
    /// the rule's link.
    bool begin_wrap(std::size_t rule, std::size_t max_data, const Endpoint& sender);
    /// The rule of begin_wrap(), until end_wrap(); std::nullopt: none has begun.
    std::optional<std::size_t> wrapping() const noexcept { return wrapping_; }
    /// begin_wrap() has not refused this datagram.
    bool can_wrap() const noexcept { return !refused_wrap_; }
    /// Adds a frame. If it does not fit, `send` is called with the tunnel frame so far first.
    void add_to_wrap(ano::FrameView frame, const OnFrame& send);
    /// The datagram ends: calls `send` with the last tunnel frame.
    void end_wrap(const OnFrame& send);

    const TunnelSettings& settings() const noexcept { return settings_; }
    const TunnelCounters& counters() const noexcept { return counters_; }
    void set_counters(const TunnelCounters& counters) noexcept { counters_ = counters; }

private:
    bool is_own_port(std::uint16_t port) const;
    bool is_ours(const IpAddress& address) const noexcept;
    std::span<const IpAddress> addresses_of(const std::string& host) const noexcept;
    bool is_from(const WrapSettings& rule, const IpAddress& sender) const noexcept;
    bool gather(std::span<const std::uint8_t> inner, const Passes& passes);
    bool refuse_wrap(std::uint64_t TunnelCounters::*cause) noexcept;
    void start_wrap() noexcept;
    void send_wrap(const OnFrame& send);

    TunnelSettings settings_;
    std::uint8_t own_id_;
    Environment environment_;
    std::uint16_t port_;
    TunnelPolicy policy_;
    HostAddresses hosts_;
    TunnelWriter out_;

    TunnelWriter wrap_;
    std::optional<std::size_t> wrapping_;    // index of the rule
    bool refused_wrap_ = false;
    std::size_t wrap_max_data_ = 0;
    TunnelHead wrap_head_;

    TunnelCounters counters_;
};

}    // namespace anogate
