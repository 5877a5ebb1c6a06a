// A kind of link is one row, in the source file of that kind. src/link/kinds.cpp lists the rows.
#pragma once
#include <config/keys.hpp>
#include <gateway/hints.hpp>
#include <gateway/host_spec.hpp>
#include <gateway/ids.hpp>
#include <gateway/settings.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class Link;
class LinkFaults;
struct LinkContext;
struct LinkKind;

using LinkKinds = std::span<const LinkKind* const>;

/// The units that the wire of a link transports.
enum class Carries : std::uint8_t {
    bytes,        // a stream without timestamps
    datagrams,    // each contains one or more frames
    pieces,       // each contains a part of a frame: CAN frames
};

/// Which senders can reach us on a link.
enum class Reach : std::uint8_t {
    here,              // programs of this computer and devices connected to it
    network,           // some peers in a network
    whole_networks,    // all hosts in all networks of this computer
};

struct LineRate {
    std::uint32_t bytes_per_second = 0;    // 0: not known
    bool is_kept = true;                   // the link never sends faster
};

/// The local port that a link binds.
struct BoundPort {
    EndpointSpec local{};
    std::string interface {};    // empty: any
    std::string_view key{};      // the key that sets it: "bind"
    bool is_tcp = false;         // otherwise UDP
};

/// The port that a link connects or sends to.
struct PeerPort {
    HostSpec peer{};
    std::string_view key{};
    bool is_tcp = false;    // otherwise UDP
};

/// A path in the file system, from the ADDRESS of a link.
struct LinkPath {
    std::string path;
    bool is_made = false;                     // the link creates it; otherwise it opens an existing port
    std::string_view noun = "serial port";    // what it must be
};

/// The error for a resource that two links of one kind can't share: `what`, the other link, `rest`, as in "'device' '/dev/x' is
/// already used by " … and `rest`.
struct SharedByTwo {
    std::string_view key;
    std::string what;
    std::string rest{};
};

/// How a GPIO line switches the RS-485 transceiver of a link to sending.
struct Rs485 {
    /// Why these settings do not allow it: "uses the RTS line"; empty: they allow it.
    std::string (*fault)(const LinkSettings&);
    /// Called before start(). `send(true)` switches the transceiver to sending, `send(false)` to receiving.
    void (*use)(Link&, bool active_low, std::function<void(bool)> send);
};

/// A function pointer is null if it does not apply to the kind.
struct LinkKind {
    std::string_view name{};       // "serial"
    std::string_view address{};    // the key whose value is the ADDRESS of a LINK text: "device"
    std::string_view example{};    // of an ADDRESS
    std::string_view help{};
    Carries carries = Carries::bytes;
    bool over_network = false;          // a stream in which a network may cause pauses inside frames
    bool encrypts = false;              // by TLS
    bool listens = false;               // has one channel per peer and waits for peers; it can't send first
    bool may_be_paced = false;          // it has the keys `rate` and `latency`
    bool devices_only = false;          // all other ends are devices: no gateway probes are sent there
    bool replays = false;               // plays a recording: accepts no frames, and its frames do not show that a device is
                                        // present
    std::string_view number_means{};    // the key set by a number without a key in a LINK text
    LinkHints hints{};

    Keys<LinkSettings> keys{};               // in addition to the common ones
    KindSettings (*settings)() = nullptr;    // the defaults
    std::unique_ptr<Link> (*make)(LinkId, const LinkSettings&, const LinkContext&) = nullptr;

    std::string (*usual_name)(const LinkSettings&) = nullptr;    // for a link without a name
    LineRate (*line_rate)(const LinkSettings&) = nullptr;
    bool (*has_uart)(const LinkSettings&) = nullptr;    // devices receive with a UART there: bytes outside of frames may be sent
    std::optional<BoundPort> (*bound_port)(const LinkSettings&) = nullptr;
    std::optional<PeerPort> (*connects_to)(const LinkSettings&) = nullptr;
    LinkPath (*path)(const LinkSettings&) = nullptr;
    Reach (*reach)(const LinkSettings&) = nullptr;
    const Rs485* rs485 = nullptr;

    /// Adds the errors of one link, independent of other links.
    void (*validate)(const LinkSettings&, LinkFaults&) = nullptr;
    /// The resource that two links of the kind both use and can't share; std::nullopt: none.
    std::optional<SharedByTwo> (*shared)(const LinkSettings&, const LinkSettings&) = nullptr;
    /// The LINK that was probably meant by a text without a kind: "'serial:/dev/ttyUSB0'"; empty: none of this kind.
    std::string (*meant_by)(std::string_view text) = nullptr;
    /// A hint about a key that users expect but this kind does not have; empty: no hint.
    std::string (*about_key)(std::string_view name) = nullptr;
};

/// The kind of a link with an unknown kind.
extern const LinkKind no_link_kind;

/// Collects errors and warnings of one link.
class LinkFaults {
public:
    /// False: the link had errors when it was read, so its settings are incomplete.
    virtual bool is_whole() const = 0;
    virtual void error(std::string_view key, std::string what) = 0;
    virtual void warning(std::string_view key, const std::string& what) = 0;

protected:
    ~LinkFaults() = default;
};

/// Whether links of this kind have the key `protocol`.
bool may_use_v7(const LinkKind& kind) noexcept;
/// Whether this link has `protocol=v7`.
bool uses_v7(const LinkSettings& link);

/// nullptr: no kind has that name.
const LinkKind* find_link_kind(LinkKinds kinds, std::string_view name) noexcept;

/// The keys of links of `kind`: its own, then the common keys that apply to it. `kinds` is used for errors about keys of other
/// kinds.
KeyList<LinkSettings> keys_of(const LinkKind& kind, LinkKinds kinds);
/// The key `name` of any kind or of all links; nullptr: there is none.
const Key<LinkSettings>* find_key_of_any(LinkKinds kinds, std::string_view name);

/// A link of `kind` with all defaults; its `queue` is 0: not set yet.
LinkSettings new_link(const LinkKind& kind);

/// The interval of hellos; zero: never. A listening socket has no peer to send to.
Duration hello_interval(const LinkSettings& link) noexcept;
/// The rate of the line in bytes/s, if the settings determine it; 0: not known.
LineRate line_rate_of(const LinkSettings& link);
/// Outbox::Options::flush_bytes of its channels. Fewer bytes than most parsers wait for would be no flush: many wait for more than
/// their device accepts. A parser that waits for more is free after the second flush.
std::size_t flush_bytes_of(const LinkSettings& link) noexcept;
std::optional<BoundPort> bound_port_of(const LinkSettings& link);
std::optional<PeerPort> peer_port_of(const LinkSettings& link);
/// The silence after which an incomplete frame is given up.
Duration quiet_of(const LinkKind& kind) noexcept;

}    // namespace anogate
