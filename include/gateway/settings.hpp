// All settings, as plain values with their defaults. Their keys are in the key table (src/config/keys.cpp). What each setting
// does is documented where it is used.
#pragma once
#include <ano/address.hpp>
#include <ano/attitude.hpp>
#include <ano/flexible.hpp>
#include <ano/limits.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>
#include <gateway/filter.hpp>
#include <gateway/ip.hpp>
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <any>
#include <chrono>
#include <cstddef>
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

/// The known properties of the devices of a link.
enum class Profile : std::uint8_t {
    none,
    vendor,    // the vendor's newest library: 198 bytes of DATA, no LEN 0, few questions at a time, hello needed
    old,       // the oldest libraries: devices act on each frame, whatever its address, and overrun at LEN above 100
};
using ano::ValueType7;
enum class TextEncoding : std::uint8_t { utf8, gbk };

/// Maximum of DATA that a device of Profile::old accepts, in bytes.
inline constexpr std::uint16_t old_max_data = 60;

/// The settings of one kind of link: a struct whose type is defined by that kind.
class KindSettings {
public:
    KindSettings() = default;
    template <class Struct>
    requires(!std::is_same_v<Struct, KindSettings>) KindSettings(Struct value)
        : value_{std::move(value)}, equal_{[](const std::any& a, const std::any& b) {
              return std::any_cast<const Struct&>(a) == std::any_cast<const Struct&>(b);
          }} {}

    /// Throws std::bad_any_cast if the struct is of another type.
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
    Profile profile = Profile::none;              // defines the defaults of the unset settings below
    std::uint16_t max_data = 4096;                // bytes of DATA in received frames
    std::optional<std::uint16_t> max_data_out;    // the same in sent frames
    std::optional<Duration> hello;                // interval between hellos; zero: never
    std::optional<ValueType7> value_type_7;       // for tools that display the received values
    std::optional<TextEncoding> encoding;         // of the received texts, for the same tools
    ano::EulerSigns attitude{};                   // of its devices, for everything that displays an orientation
    std::uint32_t queue = 32 * 1024;              // bytes; at least one frame of effective_max_data_out()
    std::optional<bool> flood;                    // accepts frames for unknown addresses
    std::optional<bool> broadcast;                // accepts frames to 0xFF
    std::string group;                            // links of one group lead to the same place; empty: none
    std::uint8_t present_as = 0;    // the address under which the devices of this link see every host; 0: the host's own
    std::uint32_t rate = 0;         // maximum of bytes/s; 0: the rate of the line, or no limit
    Duration latency = std::chrono::milliseconds{20};    // how far the system may be ahead of the line, where it is paced
    bool pack = true;                                    // puts several waiting frames into one datagram
    std::uint16_t mtu = 1400;                            // maximum bytes of such a datagram
    AgeLimits age;
    Duration gap{};    // pause after each sent frame, from its end on the wire; zero: none
    std::optional<Duration>
        frame_gap;    // pauses of this length are normal inside a received frame; std::nullopt: as the kind has it
    RuleSettings rules;
    bool required = false;    // the program exits with 1 if this link is not up within 10 s
    bool enabled = true;      // false: its wire is not opened
    bool manage = false;      // its peers may change the settings of the gateway, if that is a device

    KindSettings of_kind;    // the settings of links of its kind
    bool operator==(const LinkSettings&) const = default;

    template <class Struct>
    Struct& as() {
        return of_kind.as<Struct>();
    }
    template <class Struct>
    const Struct& as() const {
        return of_kind.as<Struct>();
    }

    /// The effective values, with the defaults of the profile.
    std::uint16_t effective_max_data_out() const noexcept {
        if (max_data_out || profile == Profile::none) return max_data_out.value_or(max_data);
        return std::min(max_data, profile == Profile::old ? old_max_data : ano::vendor_max_data);
    }
    /// The maximum bytes of a text that the devices there store; std::nullopt: not known.
    std::optional<std::size_t> max_text() const noexcept {
        return profile == Profile::vendor ? std::optional{ano::vendor_max_text} : std::nullopt;
    }
    /// std::nullopt: neither the key nor the profile defines it.
    std::optional<ValueType7> stated_type_7() const noexcept {
        return !value_type_7 && profile == Profile::vendor ? std::optional{ValueType7::u64} : value_type_7;
    }
    bool accepts_floods() const noexcept { return flood.value_or(profile != Profile::old); }
    bool accepts_broadcasts() const noexcept { return broadcast.value_or(profile != Profile::old); }
    ValueType7 meaning_of_type_7() const noexcept { return stated_type_7().value_or(ValueType7::f32); }
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
    std::string unknown_link;    // the link of Unknown::link
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

/// Plain frames received from `from` are sent to devices inside a tunnel frame.
struct WrapSettings {
    Network from;
    std::string link;
    std::uint8_t id = 0xB1;        // 0xB1, or 0xB2, the short one
    std::uint8_t source = 0xE6;    // S_ADDR of the tunnel frame
    std::uint8_t to = 0xFF;        // D_ADDR of the tunnel frame
    std::string from_host{};       // a host name, instead of `from`; empty: none
    bool operator==(const WrapSettings&) const = default;
};

/// The content of the datagram for a tunnel frame of a device.
enum class Deliver : std::uint8_t {
    frames,    // the frames inside it
    tunnel,    // the tunnel frame, with our ip as its source
};

struct TunnelSettings {
    std::vector<std::string> links;    // the links whose tunnel frames the tunnel sends
    std::uint8_t address = 0xE6;       // tunnel frames to it, to the gateway's id and to 0xFF are for us
    IpAddress bind;                    // IPv4 only: the tunnel frame has no field for IPv6
    std::uint16_t port = 12333;        // our port, also for port 0 in a tunnel frame; 0: the kernel chooses
    std::optional<IpAddress> ip;       // our address as seen by others; std::nullopt: as the system has it
    std::string ip_host;               // a host name, instead of `ip`; empty: none
    Deliver deliver = Deliver::frames;
    std::vector<WrapSettings> wrap;    // the first matching rule applies
    std::vector<Network> allow;        // if this and `allow_hosts` are empty: the networks of our interfaces
    std::vector<std::string> allow_hosts;
    bool relay = false;    // peers of IP links may reach this computer itself, where `allow` lists it
    RuleSettings rules;    // of the link `tunnel`
    bool operator==(const TunnelSettings&) const = default;
};

/// What a GPIO line is for.
enum class GpioUse : std::uint8_t {
    link_up,     // on while its link is up
    activity,    // blinks with the traffic of its link
    power,       // on; off for `pulse` on request
    reset,       // off; on for `pulse` on request, or when its link is silent
    inhibit,     // an input: while on, control frames from its links are not forwarded
    rs485,       // on while its link sends
};
enum class GpioBias : std::uint8_t { as_is, disabled, pull_up, pull_down };

struct GpioSettings {
    std::string chip;    // "gpiochip0", a path or a label; empty: the first chip with a line of that name
    std::string line;    // its number on the chip in decimal, or its name
    GpioUse use{};
    std::string link;
    std::vector<std::string> links;    // of an inhibit switch, in addition to `link`
    bool active_low = false;
    GpioBias bias = GpioBias::as_is;
    std::optional<Duration> pulse;         // std::nullopt: 1 s for power, 100 ms for reset
    std::optional<Duration> silent_for;    // reset when the link was silent for this long
    bool operator==(const GpioSettings&) const = default;
};

/// PEM files; both, or neither.
struct TlsFiles {
    std::string certificate, key;
    bool operator==(const TlsFiles&) const = default;
};

/// The coordinate system of a map: that of satellites, or the one required for maps of China (GB 20263).
enum class Datum : std::uint8_t { wgs84, gcj02 };

struct MapSettings {
    std::string file;    // .pmtiles; empty: there is no map
    Datum datum = Datum::wgs84;
    bool operator==(const MapSettings&) const = default;
};

struct ControlSettings {
    std::string socket;                  // empty: the default for this user; "none": no control socket
    std::optional<EndpointSpec> http;    // the same interface over TCP; std::nullopt: none
    std::string token_file;              // empty: the default for this user
    std::vector<std::string> hosts;      // further names of this computer, beside its host name
    std::vector<std::string> origins;    // web pages of other origins that may send requests
    TlsFiles tls;
    MapSettings map;                           // shown under the tracks on the page
    std::uint8_t host = ano::address::host;    // the source address of requests to devices
    bool manage = true;                        // as LinkSettings::manage, for the link `control`
    RuleSettings rules;                        // of the link `control`
    bool operator==(const ControlSettings&) const = default;
};

struct LogSettings {
    std::string level = "info";
    std::string file;                           // empty: standard error
    std::uint64_t rotate = 10 * 1000 * 1000;    // bytes; 0: never
    bool operator==(const LogSettings&) const = default;
};

/// How the gateway records frames.
struct RecordSettings {
    bool start = true;     // records from the start; false: only on request
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
    std::uint64_t keep_free = 0;          // older recordings are deleted to keep this many bytes of the disk free; 0: never
    std::uint64_t free = 500'000'000;     // bytes; while fewer are free, nothing is written
    std::optional<Duration> keep_last;    // in memory
    bool operator==(const RecordSettings&) const = default;
};

struct Settings {
    GatewaySettings gateway;
    std::vector<LinkSettings> links;
    std::vector<RouteSettings> routes;
    std::vector<AliasSettings> aliases;
    std::vector<ClassSettings> classes;
    std::optional<TunnelSettings> tunnel;
    std::vector<GpioSettings> gpio;
    std::vector<ano::FlexibleSpec> flexible;    // for tools; forwarding does not use them
    ControlSettings control;
    std::optional<RecordSettings> record;
    LogSettings log;
    bool operator==(const Settings&) const = default;
};

}    // namespace anogate
