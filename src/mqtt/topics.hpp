// The topics of a gateway. At most 6 levels and 256 bytes, which every broker allows. No I/O.
#pragma once
#include <mqtt/settings.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace anogate {

inline constexpr std::string_view topic_root = "anogate/v1";
inline constexpr std::size_t max_level = 64;             // bytes of one level
inline constexpr std::size_t max_payload = 64 * 1024;    // bytes; a larger payload is never published

/// Whether `text` can be one level of a topic: UTF-8 of 1 to max_level bytes without '+', '#', '/', a leading '$' and control
/// characters.
bool is_level(std::string_view text) noexcept;
/// `text` as a level: what is not allowed becomes '_'.
std::string level_of(std::string_view text);

/// "fc-05": the level for the device `address` on `link`.
std::string device_level(std::string_view link, std::uint8_t address);

class Topics {
public:
    /// `gateway` must be a level.
    explicit Topics(std::string_view gateway) : base_{std::string{topic_root} + '/' + std::string{gateway} + '/'} {}

    std::string status() const { return base_ + "status"; }
    std::string up(std::string_view device, std::string_view message) const;
    std::string raw_up() const { return base_ + "raw/up"; }
    std::string raw_down() const { return base_ + "raw/down"; }
    std::string backlog(Keep keep) const;
    std::string requests() const { return base_ + "request/+"; }
    std::string response(std::string_view client) const { return base_ + "response/" + std::string{client}; }
    /// The client that sent a request; empty: `topic` is not a request to this gateway.
    std::string_view client_of(std::string_view topic) const noexcept;

private:
    std::string base_;
};

/// The gateway that published on `topic`; empty: none.
std::string_view gateway_of(std::string_view topic) noexcept;
/// Whether a batch of records was published on `topic`.
bool is_backlog(std::string_view topic) noexcept;

}    // namespace anogate
