// What a kind of link is: one row, which stands in the file of its links. The rows are listed in src/link/kinds.cpp.
#pragma once
#include <config/keys.hpp>
#include <gateway/hints.hpp>
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

/// What its wire carries.
enum class Carries : std::uint8_t {
    bytes,        // a stream, whose bytes do not say when they came
    datagrams,    // several frames may share one
    pieces,       // of frames, such as CAN frames
};

/// Who may speak to us by a link.
enum class Reach : std::uint8_t {
    here,              // programs of this computer, and devices at its wires
    network,           // some peers in a network
    whole_networks,    // everybody in every network of this computer
};

struct LineRate {
    std::uint32_t bytes_per_second = 0;    // 0: not known
    bool is_kept = true;                   // it is given no more than that
};

/// The local port that a link binds.
struct BoundPort {
    EndpointSpec local{};
    std::string interface {};    // empty: any
    std::string_view key{};      // that says it: "bind"
};

/// A path in the file system that a link names by its ADDRESS.
struct LinkPath {
    std::string path;
    bool is_made = false;    // by the link; otherwise a port that is opened
};

/// What two links of one kind can't share: "'device' '/dev/x' is used by ", the other link, " already".
struct SharedByTwo {
    std::string_view key;
    std::string what;
    std::string rest = " already";
};

/// Lines of GPIO chips that turn an RS-485 transceiver to sending.
struct Rs485 {
    /// Why that is not possible with these settings: "uses the RTS line"; empty: it is.
    std::string (*fault)(const LinkSettings&);
    /// Before start(): `send` turns the transceiver to sending and back.
    void (*use)(Link&, bool active_low, std::function<void(bool)> send);
};

/// Functions that are null: the kind has nothing of the sort.
struct LinkKind {
    std::string_view name{};       // "serial"
    std::string_view address{};    // the key whose value is the ADDRESS of a LINK text: "device"
    std::string_view example{};    // such an address
    std::string_view help{};
    Carries carries = Carries::bytes;
    bool listens = false;               // has a channel a peer, and waits for them; it can't speak first
    bool may_be_paced = false;          // `rate` and `latency` are keys of it
    bool devices_only = false;          // nothing but devices is there, and they are asked no questions of gateways
    bool replays = false;               // says what was said once: it takes no frames, and is no sign that anybody is there
    std::string_view number_means{};    // the key that a number alone in a LINK text is meant for
    LinkHints hints{};

    Keys<LinkSettings> keys{};               // those that it has beside the common ones
    KindSettings (*settings)() = nullptr;    // where nothing is said
    std::unique_ptr<Link> (*make)(LinkId, const LinkSettings&, const LinkContext&) = nullptr;

    std::string (*usual_name)(const LinkSettings&) = nullptr;    // of a link without a name
    LineRate (*line_rate)(const LinkSettings&) = nullptr;
    std::optional<BoundPort> (*bound_port)(const LinkSettings&) = nullptr;
    LinkPath (*path)(const LinkSettings&) = nullptr;
    Reach (*reach)(const LinkSettings&) = nullptr;
    const Rs485* rs485 = nullptr;

    /// Adds what is wrong with a link by itself.
    void (*validate)(const LinkSettings&, LinkFaults&) = nullptr;
    /// What two links of the kind can't both have, and have.
    std::optional<SharedByTwo> (*shared)(const LinkSettings&, const LinkSettings&) = nullptr;
    /// The LINK that is meant by a text without a kind: "'serial:/dev/ttyUSB0'"; empty: none of this kind.
    std::string (*meant_by)(std::string_view text) = nullptr;
    /// What to say of a key that people expect and it does not have; empty: nothing.
    std::string (*about_key)(std::string_view name) = nullptr;
};

/// Of a link whose kind is not known: there is none.
extern const LinkKind no_link_kind;

/// What is found wrong with one link.
class LinkFaults {
public:
    /// Its settings are what was said: false where that had faults of its own.
    virtual bool is_whole() const = 0;
    virtual void error(std::string_view key, std::string what) = 0;
    virtual void warning(std::string_view key, const std::string& what) = 0;

protected:
    ~LinkFaults() = default;
};

/// nullptr when there is none of that name.
const LinkKind* find_link_kind(LinkKinds kinds, std::string_view name) noexcept;

/// The keys of links of `kind`: its own, then those of every link that mean something there. `kinds`: for what is said of
/// keys of others.
KeyList<LinkSettings> keys_of(const LinkKind& kind, LinkKinds kinds);
/// The key of that name of any kind, or of every link; nullptr when there is none.
const Key<LinkSettings>* find_key_of_any(LinkKinds kinds, std::string_view name);

/// A link of `kind` as it is before anything is said; its `queue` is 0: not given yet.
LinkSettings new_link(const LinkKind& kind);

/// How often it speaks first; zero: never. A socket that listens has nobody to speak to.
Duration hello_interval(const LinkSettings& link) noexcept;
/// What the line carries in bytes/s, as far as the settings tell; 0: not known.
LineRate line_rate_of(const LinkSettings& link);
std::optional<BoundPort> bound_port_of(const LinkSettings& link);
/// After what silence a frame that is not whole gives way.
Duration quiet_of(const LinkKind& kind) noexcept;

}    // namespace anogate
