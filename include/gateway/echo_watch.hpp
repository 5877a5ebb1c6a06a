// Detects a line that echoes: sent frames are received again on it, as on RS-485 or on one wire with an unmuted receiver.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// For one channel: the last sent frames that ask or act, by frame_key(). Each is recognised as an echo once. No allocation.
class EchoWatch {
public:
    static constexpr std::size_t memory = 32;    // frames
    static constexpr ano::Duration window = std::chrono::seconds{2}, reported_for = std::chrono::seconds{60};
    /// If the sender of a frame was received here before, the frame may be its own. It counts as an echo only after this number
    /// of sent frames in a row were received again.
    static constexpr unsigned enough = 4;
    static constexpr unsigned max_missing = 8;    // sent frames not received again meanwhile

    void sent(std::uint64_t key, ano::TimePoint now) noexcept {
        sent_[next_++ % memory] = {key, now, false};
        last_sent_ = now;
        if (++missing_ > max_missing) in_a_row_ = 0;
    }
    bool is_listening(ano::TimePoint now) const noexcept { return last_sent_ && now - *last_sent_ < window; }
    /// Whether the received frame is an echo. `sender_is_here`: its source was received on this channel before.
    bool is_echo(std::uint64_t key, bool sender_is_here, ano::TimePoint now) noexcept {
        const auto is_it = [&](const Sent& one) { return one.key == key && !one.is_back && one.at && now - *one.at < window; };
        const auto found = std::find_if(sent_.begin(), sent_.end(), is_it);
        if (found == sent_.end()) return false;
        found->is_back = true;
        missing_ = 0;
        in_a_row_ = std::min(in_a_row_ + 1, enough);
        if (sender_is_here && in_a_row_ < enough) return false;
        last_echo_ = now;
        return true;
    }
    /// For a hint.
    bool echoes(ano::TimePoint now) const noexcept { return last_echo_ && now - *last_echo_ < reported_for; }

private:
    struct Sent {
        std::uint64_t key = 0;
        std::optional<ano::TimePoint> at{};
        bool is_back = false;
    };
    std::array<Sent, memory> sent_{};
    std::size_t next_ = 0;
    unsigned missing_ = 0, in_a_row_ = 0;
    std::optional<ano::TimePoint> last_sent_, last_echo_;
};

}    // namespace anogate
