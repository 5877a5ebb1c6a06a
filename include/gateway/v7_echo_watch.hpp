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
#include <vector>

namespace anogate {

/// Frames that were sent a short time ago and not answered, each as often as it was sent. No allocation after construction.
class V7SentFrames {
public:
    /// A frame that returns later is not recognised.
    static constexpr ano::Duration window = std::chrono::seconds{1};

    void add(std::uint64_t key, ano::TimePoint now) noexcept {
        const std::uint8_t* const before = counts_.find(key, now);
        counts_.put(key, static_cast<std::uint8_t>(before ? std::min(*before + 1, 255) : 1), now);
    }
    /// All equal ones were answered.
    void forget(std::uint64_t key, ano::TimePoint now) noexcept {
        if (std::uint8_t* const count = counts_.find(key, now)) *count = 0;
    }
    /// Whether it was sent; true once for each time.
    bool take(std::uint64_t key, ano::TimePoint now) noexcept {
        std::uint8_t* const count = counts_.find(key, now);
        if (!count || *count == 0) return false;
        --*count;
        return true;
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
    ExpiringCache<std::uint8_t> counts_{window, 512};
};

/// What the V7 links of one gateway know of each other. A link with a host program that receives a probe of one of the devices'
/// links is connected with it: what arrives there was sent by this gateway.
struct V7Lines {
    std::vector<std::uint32_t> of_devices{};    // V7EchoWatch::line()
    std::size_t of_programs = 0;
    // The last probe of another gateway at a link with a host program, and how many there were. It is sent to the devices as well,
    // because they may be links of host programs of that gateway.
    std::uint32_t passed_on = 0, times_passed_on = 0;
};

/// For one link. A frame that asks or acts is an echo if it is equal to one that was sent: no device sends it. Telemetry of two
/// devices may be equal, so it passes unless the line is known to return frames. Probes show that: they are sent ahead of
/// telemetry (see also V7Lines), to an address that no device has. No allocation after construction.
class V7EchoWatch {
public:
    static constexpr ano::Duration probe_interval = std::chrono::seconds{5};
    /// How long the line is known to return frames after a probe has returned: two probes may be lost.
    static constexpr ano::Duration holds = 3 * probe_interval;

    /// `line`: a random number, which distinguishes the probes of this link from those of others; 0: it sends none.
    explicit V7EchoWatch(std::uint32_t line) : line_{line}, received_{V7SentFrames::window, 512} {
        // A device that takes a HEAD in a probe for that of a frame would lose the next frame.
        for (probe_ = probe_of(line_); line_ != 0 && has_head_within(); probe_ = probe_of(line_))
            line_ = std::max(line_ * 1664525 + 1013904223, 1u);
    }
    std::uint32_t line() const noexcept { return line_; }

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
        if (const auto line = line_of(frame)) return note_probe(*line, now);
        if (asks_or_acts(frame.id())) return is_back(frame, now) ? Returned::echo : Returned::no;
        if (frame.id() == acknowledgement) return Returned::no;    // no link sends one to a device
        const bool loops = is_within(loop_at_, now);
        if (!loops && !is_within(echo_at_, now)) return Returned::no;
        if (is_back(frame, now)) return Returned::echo;
        return loops && is_repeated(frame, now) ? Returned::loop : Returned::no;
    }

    static constexpr std::size_t probe_data = 8;    // bytes of DATA
    using Probe = std::array<std::uint8_t, ano::v7::overhead + probe_data>;

    bool is_probe_due(ano::TimePoint now) const noexcept { return !probed_at_ || now - *probed_at_ >= probe_interval; }
    /// The probe, which is sent now; std::nullopt: this link sends none.
    std::optional<ano::v7::FrameView> probe(ano::TimePoint now) noexcept {
        if (line_ == 0) return std::nullopt;
        probed_at_ = now;
        return ano::v7::FrameView{probe_};
    }
    static Probe probe_of(std::uint32_t line) noexcept {
        std::array<std::uint8_t, probe_data> data;
        std::copy(probe_word.begin(), probe_word.end(), data.begin());
        ano::store(data.data() + probe_word.size(), line);
        Probe probe;
        ano::v7::encode(probe, no_device, probe_id, data);
        return probe;
    }
    /// The line that sent a probe; std::nullopt: the frame is none.
    static std::optional<std::uint32_t> line_of(ano::v7::FrameView frame) noexcept {
        const auto data = frame.data();
        if (frame.id() != probe_id || data.size() != probe_data) return std::nullopt;
        if (!std::equal(probe_word.begin(), probe_word.end(), data.begin())) return std::nullopt;
        return ano::load<std::uint32_t>(data.data() + probe_word.size());
    }

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

    static bool is_within(const std::optional<ano::TimePoint>& at, ano::TimePoint now) noexcept {
        return at && now - *at < holds;
    }

    bool has_head_within() const noexcept { return std::find(probe_.begin() + 1, probe_.end(), probe_[0]) != probe_.end(); }

    Returned note_probe(std::uint32_t line, ano::TimePoint now) noexcept {
        const bool is_own = line == line_;
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
    Probe probe_{};
};

}    // namespace anogate
