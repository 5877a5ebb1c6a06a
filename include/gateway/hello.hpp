// When to send first on a link whose other end sends nothing before it has received something.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/time.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace anogate {

/// For one link. Asks for the device info, as a host would, while nothing comes in: not in the first second after
/// the link came up or after the last frame, when a boot loader may listen, and not while a firmware update may be
/// under way.
class Hello {
public:
    static constexpr ano::Duration first_silence = std::chrono::seconds{1};
    static constexpr ano::Duration min_interval = std::chrono::seconds{1};
    static constexpr ano::Duration update_pause = std::chrono::seconds{60};
    /// After so many hellos without an answer the device may be deaf: its parser waits inside a damaged frame.
    static constexpr unsigned until_deaf = 2;

    /// `interval` between two hellos, at least min_interval.
    explicit Hello(ano::Duration interval) : interval_{std::max(interval, min_interval)} {}

    void came_up(ano::TimePoint now) noexcept {
        up_at_ = now;
        said_at_.reset();
    }
    void went_down() noexcept { up_at_.reset(); }
    /// A firmware frame (0xF0) passed, to the link or from it.
    void saw_firmware(ano::TimePoint now) noexcept { firmware_at_ = now; }
    /// Whether the parser of the device is to be flushed before the next hello: before the third of three without an answer.
    bool may_be_deaf(ano::TimePoint heard_at) const noexcept {
        return said_at_ && heard_at < *said_at_ && unanswered_ % (until_deaf + 1) == until_deaf;
    }
    void said(ano::TimePoint now, ano::TimePoint heard_at) noexcept {
        unanswered_ = said_at_ && heard_at < *said_at_ ? unanswered_ + 1 : 1;
        said_at_ = now;
    }

    /// When the next hello is due if nothing is heard until then; std::nullopt while the link is down. `heard_at` is the time of
    /// the last good frame that the link brought, zero for none.
    std::optional<ano::TimePoint> due(ano::TimePoint heard_at) const noexcept {
        if (!up_at_) return std::nullopt;
        ano::TimePoint at = std::max(*up_at_, heard_at) + first_silence;
        if (said_at_) at = std::max(at, *said_at_ + interval_);
        if (firmware_at_) at = std::max(at, *firmware_at_ + update_pause);
        return at;
    }

private:
    ano::Duration interval_;
    std::optional<ano::TimePoint> up_at_;
    std::optional<ano::TimePoint> said_at_;    // since it came up
    unsigned unanswered_ = 0;                  // hellos since the last good frame came
    std::optional<ano::TimePoint> firmware_at_;
};

/// 0xE0 0 as 0xFE to `destination`: are you there?
constexpr auto device_info_question(std::uint8_t destination) noexcept {
    constexpr std::array<std::uint8_t, 3> device_info{};    // command 0, value 0
    std::array<std::uint8_t, ano::overhead + device_info.size()> frame{};
    ano::encode(frame, ano::address::host, destination, ano::id_of<"parameter_command">, device_info);
    return frame;
}

/// To 0xFF: who is there?
inline constexpr auto hello_frame = device_info_question(ano::address::broadcast);

}    // namespace anogate
