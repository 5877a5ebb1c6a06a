// What can be configured, as plain values with their defaults. How they are written is the key table's business
// (src/config/keys.cpp); what each one does stands where it is used.
#pragma once
#include <ano/address.hpp>
#include <ano/flexible.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>
#include <gateway/filter.hpp>
#include <gateway/ip.hpp>
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <any>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace anogate {

struct LinkKind;    // src/config/link_kind.hpp

using ano::Clock;
using ano::Duration;
using ano::TimePoint;

/// What the devices of a link are known for.
enum class Profile : std::uint8_t {
    none,
    vendor,    // the vendor's newest library: 198 bytes of DATA, no LEN 0, few questions at a time, spoken to first
};
using ano::ValueType7;
enum class TextEncoding : std::uint8_t { utf8, gbk };

/// Most DATA that a device of Profile::vendor takes.
inline constexpr std::uint16_t vendor_max_data = 198;

/// The settings that only links of one kind have: a struct that this kind alone knows.
class KindSettings {
public:
    KindSettings() = default;
    template <class Struct>
    requires(!std::is_same_v<Struct, KindSettings>) KindSettings(Struct value)
        : value_{std::move(value)}, equal_{[](const std::any& a, const std::any& b) {
              return std::any_cast<const Struct&>(a) == std::any_cast<const Struct&>(b);
          }} {}

    /// Throws std::bad_any_cast when they are of another kind.
    template <class Struct>
    Struct& as() {
        return std::any_cast<Struct&>(value_);
    }
    template <class Struct>
    const Struct& as() const {
        return std::any_cast<const Struct&>(value_);
    }
    friend bool operator==(const KindSettings& a, const KindSettings& b) {
        return a.equal_ == b.equal_ && (!a.equal_ || a.equal_(a.value_, b.value_));
    }

private:
    std::any value_;
    bool (*equal_)(const std::any&, const std::any&) = nullptr;
};

struct LinkSettings {
    const LinkKind* kind = nullptr;
    std::string name;
    std::uint8_t id = 0;                          // port id 1 to 20; 0: none
    Profile profile = Profile::none;              // gives the defaults of what is not said below
    std::uint16_t max_data = 4096;                // of what is accepted
    std::optional<std::uint16_t> max_data_out;    // of what is sent
    std::optional<Duration> hello;                // how often to speak first; zero: never
    std::optional<ValueType7> value_type_7;       // for tools that show what the link brings
    std::optional<TextEncoding> encoding;         // and of the text in it
    std::uint32_t queue = 32 * 1024;              // bytes; at least one frame of effective_max_data_out()
    bool flood = true;                            // takes frames for addresses nobody has heard of
    bool broadcast = true;                        // takes frames to 0xFF
    std::string group;                            // links of one group lead to the same place; empty: none
    std::uint8_t present_as = 0;                  // the address that every host has for the devices of this link; 0: its own
    std::uint32_t rate = 0;                       // bytes/s that it is given at most; 0: what the line carries, or no limit
    Duration latency = std::chrono::milliseconds{20};    // how far the system may be ahead of the line, where it is paced
    bool pack = true;                                    // datagrams: several frames in one when they wait anyway,
    std::uint16_t mtu = 1400;                            // and so many bytes
    AgeLimits age;
    RuleSettings rules;
    bool required = false;    // the program ends with 1 when this link is not up within 10 s
    bool enabled = true;      // no: its wire is not opened
    bool manage = false;      // who comes by it may change the gateway itself, where that is a device

    KindSettings of_kind;    // what links of its kind have beside that
    bool operator==(const LinkSettings&) const = default;

    template <class Struct>
    Struct& as() {
        return of_kind.as<Struct>();
    }
    template <class Struct>
    const Struct& as() const {
        return of_kind.as<Struct>();
    }

    /// What holds where nothing was said.
    std::uint16_t effective_max_data_out() const noexcept {
        return max_data_out.value_or(profile == Profile::vendor ? std::min(max_data, vendor_max_data) : max_data);
    }
    ValueType7 meaning_of_type_7() const noexcept {
        return value_type_7.value_or(profile == Profile::vendor ? ValueType7::u64 : ValueType7::f32);
    }
    TextEncoding text_encoding() const noexcept {
        return encoding.value_or(profile == Profile::vendor ? TextEncoding::gbk : TextEncoding::utf8);
    }
    static constexpr Duration usual_hello = std::chrono::seconds{2};
};

enum class Unknown : std::uint8_t { flood, drop, link };

struct RouteSettings {
    std::uint8_t first = 0, last = 0;    // addresses, both included
    std::string link;
    bool operator==(const RouteSettings&) const = default;
};

struct GatewaySettings {
    std::uint8_t id = 0;    // our own hardware id; 0: none
    std::string name = "anogate";
    Unknown unknown = Unknown::flood;
    std::string unknown_link;    // where Unknown::link sends them
    Duration forget_after = std::chrono::seconds{30};
    bool operator==(const GatewaySettings&) const = default;
};

/// A device behind `link` appears under another address.
struct AliasSettings {
    std::string link;
    std::uint8_t device = 0;
    std::uint8_t as = 0;
    bool operator==(const AliasSettings&) const = default;
};

/// What a device is given when plain frames come in from `from`: a tunnel frame.
struct WrapSettings {
    Network from;
    std::string link;
    std::uint8_t id = 0xB1;        // 0xB1, or 0xB2, the short one
    std::uint8_t source = 0xE6;    // S_ADDR of the tunnel frame
    std::uint8_t to = 0xFF;        // and its D_ADDR
    bool operator==(const WrapSettings&) const = default;
};

/// What leaves for a tunnel frame of a device.
enum class Deliver : std::uint8_t {
    frames,    // the frames inside it
    tunnel,    // the tunnel frame, with our ip as its source
};

struct TunnelSettings {
    std::vector<std::string> links;    // whose tunnel frames are carried
    std::uint8_t address = 0xE6;       // tunnel frames to it, to the gateway's id and to 0xFF are for us
    IpAddress bind;                    // IPv4: the tunnel frame has no room for more
    std::uint16_t port = 12333;        // ours, and what port 0 in a tunnel frame means; 0: the kernel chooses
    std::optional<IpAddress> ip;       // our address as others know it; nothing: as the system has it
    Deliver deliver = Deliver::frames;
    std::vector<WrapSettings> wrap;    // the first that matches counts
    std::vector<Network> allow;        // empty: the networks of our interfaces
    bool relay = false;                // peers of IP links may reach this computer itself, where `allow` lists it
    RuleSettings rules;                // of the link `tunnel`
    bool operator==(const TunnelSettings&) const = default;
};

/// What a GPIO line is for.
enum class GpioUse : std::uint8_t {
    link_up,     // on while its link is up
    activity,    // blinks with the traffic of its link
    power,       // on; off for `pulse` when asked
    reset,       // off; on for `pulse` when asked, or when its link is silent
    inhibit,     // an input: while on, no control frame from its links goes anywhere
    rs485,       // on while its link sends
};
enum class GpioBias : std::uint8_t { as_is, disabled, pull_up, pull_down };

struct GpioSettings {
    std::string chip;    // "gpiochip0", a path or a label; empty: the first chip that has a line of that name
    std::string line;    // its number on the chip in decimal, or its name
    GpioUse use{};
    std::string link;
    std::vector<std::string> links;    // of an inhibit switch, beside `link`
    bool active_low = false;
    GpioBias bias = GpioBias::as_is;
    std::optional<Duration> pulse;         // nothing: 1 s for power, 100 ms for reset
    std::optional<Duration> silent_for;    // reset when the link was silent so long
    bool operator==(const GpioSettings&) const = default;
};

/// PEM files; both, or neither.
struct TlsFiles {
    std::string certificate, key;
    bool operator==(const TlsFiles&) const = default;
};

/// In which coordinates a map is drawn: as satellites say, or as maps of China must (GB 20263).
enum class Datum : std::uint8_t { wgs84, gcj02 };

struct MapSettings {
    std::string file;    // .pmtiles; empty: there is no map
    Datum datum = Datum::wgs84;
    bool operator==(const MapSettings&) const = default;
};

struct ControlSettings {
    std::string socket;                  // empty: the default for this user; "none": no control socket
    std::optional<EndpointSpec> http;    // the same interface over TCP; nothing: not
    std::string token_file;              // empty: the default for this user
    std::vector<std::string> hosts;      // names of ours beside the host's own
    std::vector<std::string> origins;    // pages of others that may ask
    TlsFiles tls;
    MapSettings map;                           // under the tracks of the page
    std::uint8_t host = ano::address::host;    // as whom devices are asked
    bool manage = true;                        // of the link `control`, as of any other link
    RuleSettings rules;                        // of the link `control`
    bool operator==(const ControlSettings&) const = default;
};

struct LogSettings {
    std::string level = "info";
    std::string file;                           // empty: standard error
    std::uint64_t rotate = 10 * 1000 * 1000;    // bytes; 0: never
    bool operator==(const LogSettings&) const = default;
};

/// The gateway records what passes it.
struct RecordSettings {
    bool start = true;     // from the start on; no: when it is asked to
    std::string folder;    // empty: "recordings" in the state folder
    std::string format = "pcapng";
    std::string message_encoding = "cdr";    // of decoded messages in MCAP
    std::vector<std::string> direction{"in"};
    std::vector<ByteRange> ids, from, to;    // empty: all
    std::vector<std::string> links;          // empty: all
    std::vector<LimitRule> limit;
    std::uint64_t rotate_size = 1'000'000'000;    // bytes of a file; 0: never
    std::optional<Duration> rotate_time;
    std::uint64_t keep_size = 0;    // bytes of all recordings; 0: no limit
    std::optional<Duration> keep_age;
    std::uint64_t keep_free = 0;          // for so many free bytes of the disk older recordings go; 0: none does
    std::uint64_t free = 500'000'000;     // while fewer are free, nothing is written
    std::optional<Duration> keep_last;    // in memory
    bool operator==(const RecordSettings&) const = default;
};

struct Settings {
    GatewaySettings gateway;
    std::vector<LinkSettings> links;
    std::vector<RouteSettings> routes;
    std::vector<AliasSettings> aliases;
    std::optional<TunnelSettings> tunnel;
    std::vector<GpioSettings> gpio;
    std::vector<ano::FlexibleSpec> flexible;    // for tools: what carries frames does not ask
    ControlSettings control;
    std::optional<RecordSettings> record;
    LogSettings log;
    bool operator==(const Settings&) const = default;
};

}    // namespace anogate
