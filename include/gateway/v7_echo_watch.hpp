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
#include <span>

namespace anogate {

/// Probes of V7 links: 0xFB with this word and the line, on the wire and between the links of a gateway.
inline constexpr std::uint8_t v7_probe_id = 0xFB;
inline constexpr std::array<std::uint8_t, 4> v7_probe_word{'R', 'i', 'n', 'g'};
inline constexpr std::size_t v7_probe_data = v7_probe_word.size() + 4;    // bytes of DATA
constexpr bool is_v7_probe(std::uint8_t id, std::span<const std::uint8_t> data) noexcept {
    return id == v7_probe_id && data.size() == v7_probe_data &&
           std::equal(v7_probe_word.begin(), v7_probe_word.end(), data.begin());
}

/// For one link. A frame that asks or acts is an echo if it is equal to one that was sent: no device sends it. Telemetry of two
/// devices may be equal, so it passes unless the line is known to return frames. Probes show that: they are sent ahead of
/// other frames, to an address that no device has. No allocation after construction.
class V7EchoWatch {
public:
    /// A frame that returns later is not recognised.
    static constexpr ano::Duration window = std::chrono::seconds{1};
    static constexpr ano::Duration probe_interval = std::chrono::seconds{5};
    /// How long the line is known to return frames after a probe has returned: two probes may be lost.
    static constexpr ano::Duration holds = 3 * probe_interval;

    /// `line` distinguishes the probes of this link from those of others; the upper three bytes are the same for all links of the
    /// gateway. 0: it sends none.
    explicit V7EchoWatch(std::uint32_t line) : line_{line}, sent_{window, 512}, received_{window, 512} {
        // A device that takes a HEAD in a probe for that of a frame would lose the next frame.
        for (unsigned shift = 8; shift < 32; shift += 8)    // the same for each link of the gateway
            if ((line_ >> shift & 0xFF) == ano::v7::head) line_ ^= 1u << shift;
        const std::uint32_t first = line_;
        for (unsigned i = 1; i <= 0xFF && (encode_probe(), line_ != 0 && has_head_within()); ++i)
            line_ = (first & ~0xFFu) | ((first + i) & 0xFF);
    }

    enum class Returned : std::uint8_t {
        no,
        echo,     // sent on this link
        loop,     // sent on another link of a gateway
        probe,    // of another gateway, for the other links of this one
    };

    /// Whether each frame with this id acts again.
    static constexpr bool acts(std::uint8_t id) noexcept { return id == 0x61 || id == 0xE0 || id == 0xE2; }
    /// Whether devices only receive frames with this id, or send them as answers.
    static constexpr bool asks_or_acts(std::uint8_t id) noexcept {
        return id == 0x40 || id == 0x41 || id == 0x60 || id == 0x61 || (id >= 0xE0 && id <= 0xE2);
    }

    void sent(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        const std::uint64_t key = key_of(frame);
        const std::uint8_t* const before = sent_.find(key, now);
        sent_.put(key, static_cast<std::uint8_t>(before ? std::min(*before + 1, 255) : 1), now);
    }
    /// It was answered: an equal frame is the device's own.
    void answered(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        if (std::uint8_t* const count = sent_.find(key_of(frame), now)) *count = 0;
    }

    /// Whether a received frame is an echo of a sent one; each is recognised once.
    bool is_back(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        std::uint8_t* const count = sent_.find(key_of(frame), now);
        if (!count || *count == 0) return false;
        --*count;
        return true;
    }
    /// The same on a line with a host program, which may be a V7 link of another gateway. If it leads back to this gateway,
    /// everything is a `loop`.
    Returned judge_program(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        if (is_probe(frame)) {
            if (line_of(frame.data()) == line_) return Returned::echo;
            return returns_to_gateway(frame.data(), now) ? Returned::loop : Returned::probe;
        }
        if (is_back(frame, now)) return Returned::echo;
        return is_in_ring(now) ? Returned::loop : Returned::no;
    }
    /// The DATA of a probe that leaves a gateway or arrives at it: whether the gateway itself has sent it.
    bool returns_to_gateway(std::span<const std::uint8_t> probe, ano::TimePoint now) noexcept {
        if (line_ == 0 || (line_of(probe) ^ line_) >> 8 != 0) return false;
        ring_at_ = now;
        return true;
    }
    /// The line leads back to this gateway, possibly through others.
    bool is_in_ring(ano::TimePoint now) const noexcept { return is_within(ring_at_, now); }
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

    /// The probe to be sent now; std::nullopt: none is due. Valid until the next call.
    std::optional<ano::v7::FrameView> next_probe(ano::TimePoint now) noexcept {
        if (line_ == 0 || (probed_at_ && now - *probed_at_ < probe_interval)) return std::nullopt;
        return probe(now);
    }
    /// The same ahead of `frame`. One that acts, and was sent a short time ago, may have returned.
    std::optional<ano::v7::FrameView> next_probe_before(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        return line_ != 0 && acts(frame.id()) && sent_.find(key_of(frame), now) ? probe(now) : next_probe(now);
    }
    std::optional<ano::v7::FrameView> probe(ano::TimePoint now) noexcept {
        probed_at_ = now;
        return ano::v7::FrameView{probe_};
    }

    /// The connection was lost.
    void reset() noexcept {
        const auto none = [](std::uint64_t, const auto&) { return false; };
        sent_.keep_if(none);
        received_.keep_if(none);
        probed_at_.reset();
        echo_at_.reset();
        loop_at_.reset();
        ring_at_.reset();
    }

private:
    static constexpr std::uint8_t no_device = 0x00, acknowledgement = 0x00;
    struct Nothing {};

    static std::uint64_t key_of(ano::v7::FrameView frame) noexcept {
        std::array<std::uint8_t, 8> padded{};
        if (frame.bytes().size() >= padded.size()) return key_of_bytes(frame.bytes());
        std::copy(frame.bytes().begin(), frame.bytes().end(), padded.begin());
        return key_of_bytes(padded);
    }
    static bool is_probe(ano::v7::FrameView frame) noexcept { return is_v7_probe(frame.id(), frame.data()); }
    static std::uint32_t line_of(std::span<const std::uint8_t> probe) noexcept {
        return ano::load<std::uint32_t>(probe.data() + v7_probe_word.size());
    }
    static bool is_within(const std::optional<ano::TimePoint>& at, ano::TimePoint now) noexcept {
        return at && now - *at < holds;
    }

    void encode_probe() noexcept {
        std::array<std::uint8_t, v7_probe_data> data;
        std::copy(v7_probe_word.begin(), v7_probe_word.end(), data.begin());
        ano::store(data.data() + v7_probe_word.size(), line_);
        ano::v7::encode(probe_, no_device, v7_probe_id, data);
    }
    bool has_head_within() const noexcept { return std::find(probe_.begin() + 1, probe_.end(), probe_[0]) != probe_.end(); }

    Returned note_probe(ano::v7::FrameView probe, ano::TimePoint now) noexcept {
        const bool is_own = line_of(probe.data()) == line_;
        (is_own ? echo_at_ : loop_at_) = now;
        return is_own ? Returned::echo : Returned::loop;
    }
    // In a loop each round of a frame arrives with the same bytes.
    bool is_repeated(ano::v7::FrameView frame, ano::TimePoint now) noexcept {
        const std::uint64_t key = key_of(frame);
        if (received_.find(key, now)) return true;
        received_.put(key, {}, now);
        return false;
    }

    std::uint32_t line_;
    ExpiringCache<std::uint8_t> sent_;    // how often, less the echoes
    ExpiringCache<Nothing> received_;
    std::optional<ano::TimePoint> probed_at_{}, echo_at_{}, loop_at_{}, ring_at_{};
    std::array<std::uint8_t, ano::v7::overhead + v7_probe_data> probe_{};
};

}    // namespace anogate
