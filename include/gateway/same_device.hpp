// Distinguishes one device on two links from two devices with one id: one device sends the same frames on both links.
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

namespace anogate {

/// Compares samples of the frames of each source: at most two frames per second. Constant time, no allocation.
class SameDevice {
public:
    /// The maximum delay of the same frame on another link.
    static constexpr ano::Duration window = std::chrono::milliseconds{500};

    /// `source` sent the frame `key` (frame_key()), received on `link`. Returns the other link on which the same frame was
    /// received within the window; std::nullopt: it is not the current sample, or was received on no other link.
    std::optional<LinkId> heard(std::uint8_t source, LinkId link, std::uint64_t key, ano::TimePoint now) noexcept {
        Sample& sample = samples_[source];
        sample.links.insert(link);
        if (now < sample.at + window) {
            if (link == sample.link) return std::nullopt;
            sample.elsewhere = true;
            if (key != sample.key) return std::nullopt;
            if (!std::exchange(sample.met, true)) count(sample.met_before, sample.missed);
            return sample.link;
        }
        set_sample(sample, link, key, now);
        return std::nullopt;
    }
    /// The link is removed: its sources are sampled from the beginning.
    void remove_link(LinkId link) noexcept {
        for (Sample& sample : samples_)
            if (sample.links.contains(link)) sample = {};
    }
    /// Whether the same frame of `source` was received on two links.
    bool met(std::uint8_t source) const noexcept { return samples_[source].met_before > 0; }
    /// Whether the frames of `source` on two links are hardly ever the same.
    bool differ(std::uint8_t source) const noexcept {
        const Sample& sample = samples_[source];
        return sample.missed >= enough && sample.met_before * 4 < sample.missed;
    }

private:
    static constexpr unsigned enough = 4, max_counted = 64;

    struct Sample {
        std::uint64_t key = 0;
        ano::TimePoint at = ano::TimePoint::min();
        LinkSet links;    // all on which frames of the source were received
        LinkId link{};
        bool elsewhere = false;                 // another link received frames of the source meanwhile
        bool met = false;                       // another link received the sample itself
        unsigned met_before = 0, missed = 0;    // numbers of samples with `elsewhere`
    };

    // A frame that the slower of two links receives will not arrive on the other one any more. So samples are taken from both in
    // turn. A repeated frame, as from a sensor at rest, shows nothing and is not sampled.
    static void set_sample(Sample& sample, LinkId link, std::uint64_t key, ano::TimePoint now) noexcept {
        const bool others_turn = sample.elsewhere && link == sample.link && now < sample.at + 2 * window;
        if (others_turn || key == sample.key) return;
        if (sample.elsewhere && !sample.met) count(sample.missed, sample.met_before);
        sample = {key, now, sample.links, link, false, false, sample.met_before, sample.missed};
    }
    static void count(unsigned& counted, unsigned& other) noexcept {
        if (++counted < max_counted) return;
        counted /= 2;
        other /= 2;
    }

    std::array<Sample, 256> samples_{};
};

}    // namespace anogate
