// When to send first on a link whose other end sends nothing before it has received a frame.
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

/// For one link. Requests the device info, as a host does, while nothing is received. It sends nothing in the first second after
/// the link came up or after the last frame, when a boot loader may listen, and nothing while a firmware update may be in
/// progress.
class Hello {
public:
    static constexpr ano::Duration first_silence = std::chrono::seconds{1};
    static constexpr ano::Duration min_interval = std::chrono::seconds{1};
    static constexpr ano::Duration update_pause = std::chrono::seconds{60};
    /// After this number of hellos without an answer the parser of the device may be waiting inside a damaged frame.
    static constexpr unsigned until_deaf = 2;

    /// `interval` between two hellos, at least min_interval.
    explicit Hello(ano::Duration interval) : interval_{std::max(interval, min_interval)} {}

    void came_up(ano::TimePoint now) noexcept {
        up_at_ = now;
        sent_at_.reset();
    }
    void went_down() noexcept { up_at_.reset(); }
    /// A firmware frame (0xF0) was forwarded to or from the link.
    void saw_firmware(ano::TimePoint now) noexcept { firmware_at_ = now; }
    /// Whether to flush the parser of the device before the next hello: before the third of three without an answer.
    bool may_be_deaf(ano::TimePoint heard_at) const noexcept {
        return sent_at_ && heard_at < *sent_at_ && unanswered_ % (until_deaf + 1) == until_deaf;
    }
    void sent(ano::TimePoint now, ano::TimePoint heard_at) noexcept {
        unanswered_ = sent_at_ && heard_at < *sent_at_ ? unanswered_ + 1 : 1;
        sent_at_ = now;
    }

    /// When the next hello is due if nothing is received until then; std::nullopt while the link is down. `heard_at` is the time
    /// of the last valid frame from the link, zero for none.
    std::optional<ano::TimePoint> due(ano::TimePoint heard_at) const noexcept {
        if (!up_at_) return std::nullopt;
        ano::TimePoint at = std::max(*up_at_, heard_at) + first_silence;
        if (sent_at_) at = std::max(at, *sent_at_ + interval_);
        if (firmware_at_) at = std::max(at, *firmware_at_ + update_pause);
        return at;
    }

private:
    ano::Duration interval_;
    std::optional<ano::TimePoint> up_at_;
    std::optional<ano::TimePoint> sent_at_;    // since it came up
    unsigned unanswered_ = 0;                  // hellos since the last valid frame
    std::optional<ano::TimePoint> firmware_at_;
};

/// 0xE0 0 from 0xFE to `destination`: the request for the device info.
constexpr auto device_info_question(std::uint8_t destination) noexcept {
    constexpr std::array<std::uint8_t, 3> device_info{};    // command 0, value 0
    std::array<std::uint8_t, ano::overhead + device_info.size()> frame{};
    ano::encode(frame, ano::address::host, destination, ano::id_of<"parameter_command">, device_info);
    return frame;
}

/// The same to 0xFF, for all devices.
inline constexpr auto hello_frame = device_info_question(ano::address::broadcast);

}    // namespace anogate
