// The keys of a link whose devices use the previous protocol version, V7 (config/README.md).
#pragma once
#include <gateway/filter.hpp>
#include <gateway/v7_translation.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

enum class LinkProtocol : std::uint8_t { v8, v7 };
/// What is at the other end of the link: a device, or a program that uses one.
enum class V7Role : std::uint8_t { device, host };

struct V7LinkSettings {
    LinkProtocol protocol = LinkProtocol::v8;
    V7Role role = V7Role::device;
    std::uint8_t device = 0;    // the V8 id of the device, with V7Role::host of the one that the host program sees; 0: not set
    std::vector<std::string> sources;
    std::optional<std::uint8_t> address;    // D_ADDR of frames to the device
    std::string acc;                        // lx, flow, cmss, keep or a number; empty: after `device`
    std::uint16_t temp = 100;
    std::optional<V7Range> range;
    V7Layout layout = V7Layout::v8;
    std::vector<ByteRange> down;    // empty: V7Settings::default_down()
    V7Ack ack = V7Ack::device;
    std::uint8_t repeat = 3;
    std::string params = "none";        // the table of parameters: none, lx, tkz, or the path of a file
    std::optional<std::uint8_t> max;    // std::nullopt: 44 to a device, 255 to a host program
    bool operator==(const V7LinkSettings&) const = default;

    bool is_on() const noexcept { return protocol == LinkProtocol::v7; }
    V7Settings translation() const;
};

/// Whether a frame with this V7 id is a command of a host program: remote and realtime control, a waypoint, a command or a write.
inline bool is_v7_command_of_host(const V7LinkSettings& v7, std::uint8_t id) noexcept {
    return v7.role == V7Role::host && (id == 0x40 || id == 0x41 || id == 0x61 || id == 0xE0 || id == 0xE2);
}

/// "0x51:0xDE", or "0xF1-0xFA:0xDB"; std::nullopt: neither.
std::optional<V7Source> parse_v7_source(std::string_view text);
/// The table of `params`; none for "none". Returns the error, or "". May block on the disk.
std::string read_v7_parameters(const std::string& params, std::vector<V7Parameter>& rows);
/// A number above 0, or lx, flow, cmss, keep.
std::optional<V7Acceleration> parse_v7_acceleration(std::string_view text);

}    // namespace anogate
