// Recognises frames that return on a V7 link. V7 has no source address, so the gateway would take them for frames of the device.
#pragma once
#include <ano/time.hpp>
#include <ano/v7.hpp>
#include <gateway/expiring_cache.hpp>
#include <gateway/frame_key.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// Frames that were sent a short time ago, each as often as it was sent: those that may still return, and of them those that were
/// not answered. No allocation after construction.
class V7SentFrames {
public:
    /// A frame that returns later is not recognised.
    static constexpr ano::Duration window = std::chrono::seconds{1};

    void add(std::uint64_t key, ano::TimePoint now) noexcept {
        const Counts* const before = counts_.find(key, now);
        counts_.put(key, before ? Counts{plus_one(before->returning), plus_one(before->unanswered)} : Counts{1, 1}, now);
    }
    /// All equal ones were answered.
    void forget(std::uint64_t key, ano::TimePoint now) noexcept {
        if (Counts* const counts = counts_.find(key, now)) counts->unanswered = 0;
    }
    struct Sent {
        bool is_unanswered = false;
        ano::Duration age{};    // of the last equal one
    };
    /// Whether a frame may be one that was sent, which then returns no more; each once.
    std::optional<Sent> returned(std::uint64_t key, ano::TimePoint now) noexcept {
        Counts* const counts = counts_.find(key, now);
        if (!counts || counts->returning == 0) return std::nullopt;
        --counts->returning;
        return Sent{counts->unanswered > 0 && counts->unanswered-- > 0, now - counts_.stored_at(key)};
    }
    /// The same without those that were answered.
    bool take(std::uint64_t key, ano::TimePoint now) noexcept {
        const auto sent = returned(key, now);
        return sent && sent->is_unanswered;
    }
    void clear() noexcept {
        counts_.keep_if([](std::uint64_t, const auto&) { return false; });
    }

    static std::uint64_t key_of(ano::v7::FrameView frame) noexcept {
        std::array<std::uint8_t, 8> padded{};
        if (frame.bytes().size() >= padded.size()) return key_of_bytes(frame.bytes());
        std::copy(frame.bytes().begin(), frame.bytes().end(), padded.begin());
        return key_of_bytes(padded);
    }

private:
    struct Counts {
        std::uint8_t returning = 0, unanswered = 0;
    };
    static std::uint8_t plus_one(std::uint8_t count) noexcept { return static_cast<std::uint8_t>(std::min(count + 1, 255)); }

    ExpiringCache<Counts> counts_{window, 512};
};

/// For one link. A frame that asks or acts is an echo if it is equal to one that was sent: no device sends it. Telemetry of two
/// devices may be equal, so it passes unless the line is known to return frames. Probes show that: they are sent ahead of
/// telemetry, to an address that no device has. No allocation after construction.
class V7EchoWatch {
public:
    static constexpr ano::Duration probe_interval = std::chrono::seconds{5};
    /// How long the line is known to return frames after a probe has returned: two probes may be lost.
    static constexpr ano::Duration holds = 3 * probe_interval;

    /// `line`: a random number, which distinguishes the probes of this link from those of others; 0: it sends none.
    explicit V7EchoWatch(std::uint32_t line) : line_{line}, received_{V7SentFrames::window, 512} {
        // A device that takes a HEAD in a probe for that of a frame would lose the next frame.
        for (encode_probe(); line_ != 0 && has_head_within(); encode_probe()) line_ = std::max(line_ * 1664525 + 1013904223, 1u);
    }

    enum class Returned : std::uint8_t {
        no,
        echo,    // sent on this link
        loop,    // sent on another link of a gateway
    };

    /// Whether devices only receive frames with this id, or send them as answers.
    static constexpr bool asks_or_acts(std::uint8_t id) noexcept {
        return id == 0x40 || id == 0x41 || id == 0x60 || id == 0x61 || (id >= 0xE0 && id <= 0xE2);
    }

    void sent(ano::v7::FrameView frame, ano::TimePoint now) noexcept { sent_.add(V7SentFrames::key_of(frame), now); }
    /// It was answered: an equal frame is the device's own.
    void answered(ano::v7::FrameView frame, ano::TimePoint now) noexcept { sent_.forget(V7SentFrames::key_of(frame), now); }

    /// Whether a received frame is an echo of a sent one; each is recognised once.
    bool is_back(ano::v7::FrameView frame, ano::TimePoint now) noexcept { return sent_.take(V7SentFrames::key_of(frame), now); }
    /// The same on a line with a device.
    Returned judge(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        if (is_probe(frame)) return note_probe(frame, now);
        if (asks_or_acts(frame.id())) return is_back(frame, now) ? Returned::echo : Returned::no;
        if (frame.id() == acknowledgement) return Returned::no;    // no link sends one to a device
        const bool loops = is_within(loop_at_, now);
        if (!loops && !is_within(echo_at_, now)) return Returned::no;
        if (is_back(frame, now)) return Returned::echo;
        return loops && is_repeated(frame, now) ? Returned::loop : Returned::no;
    }

    /// The probe to be sent now, ahead of telemetry; std::nullopt: none is due. Valid until the next call.
    std::optional<ano::v7::FrameView> next_probe(ano::TimePoint now) noexcept {
        if (line_ == 0 || (probed_at_ && now - *probed_at_ < probe_interval)) return std::nullopt;
        probed_at_ = now;
        return ano::v7::FrameView{probe_};
    }
    static constexpr std::size_t probe_data = 8;    // bytes of DATA

    /// The connection was lost.
    void reset() noexcept {
        sent_.clear();
        received_.keep_if([](std::uint64_t, const auto&) { return false; });
        probed_at_.reset();
        echo_at_.reset();
        loop_at_.reset();
    }

private:
    static constexpr std::uint8_t probe_id = 0xFB, no_device = 0x00, acknowledgement = 0x00;
    static constexpr std::array<std::uint8_t, probe_data - 4> probe_word{'R', 'i', 'n', 'g'};    // before the line
    struct Nothing {};

    static bool is_probe(ano::v7::FrameView frame) noexcept {
        const auto data = frame.data();
        return frame.id() == probe_id && data.size() == probe_data &&
               std::equal(probe_word.begin(), probe_word.end(), data.begin());
    }
    static bool is_within(const std::optional<ano::TimePoint>& at, ano::TimePoint now) noexcept {
        return at && now - *at < holds;
    }

    void encode_probe() noexcept {
        std::array<std::uint8_t, probe_data> data;
        std::copy(probe_word.begin(), probe_word.end(), data.begin());
        ano::store(data.data() + probe_word.size(), line_);
        ano::v7::encode(probe_, no_device, probe_id, data);
    }
    bool has_head_within() const noexcept { return std::find(probe_.begin() + 1, probe_.end(), probe_[0]) != probe_.end(); }

    Returned note_probe(ano::v7::FrameView probe, ano::TimePoint now) noexcept {
        const bool is_own = ano::load<std::uint32_t>(probe.data().data() + probe_word.size()) == line_;
        (is_own ? echo_at_ : loop_at_) = now;
        return is_own ? Returned::echo : Returned::loop;
    }
    // In a loop each round of a frame arrives with the same bytes.
    bool is_repeated(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        const std::uint64_t key = V7SentFrames::key_of(frame);
        if (received_.find(key, now)) return true;
        received_.put(key, {}, now);
        return false;
    }

    std::uint32_t line_;
    V7SentFrames sent_;
    ExpiringCache<Nothing> received_;
    std::optional<ano::TimePoint> probed_at_{}, echo_at_{}, loop_at_{};
    std::array<std::uint8_t, ano::v7::overhead + probe_data> probe_{};
};

}    // namespace anogate
