// One device on two links, or two devices with one id? The first says the same by both.
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

namespace anogate {

/// Looks at a sample of what each source says: two frames a second at the most. Constant time, no allocation.
class SameDevice {
public:
    /// How much later another link may bring the same frame.
    static constexpr ano::Duration window = std::chrono::milliseconds{500};

    /// `source` said the frame `key` (frame_key()) by `link`. The other link that brought it within the window, when it was the
    /// sample; nothing: it was not, or came by no other.
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
        take(sample, link, key, now);
        return std::nullopt;
    }
    /// The link is no more: whom it brought is looked at anew.
    void remove_link(LinkId link) noexcept {
        for (Sample& sample : samples_)
            if (sample.links.contains(link)) sample = {};
    }
    /// Two links bring frames of `source`, and hardly ever the same ones.
    bool differ(std::uint8_t source) const noexcept {
        const Sample& sample = samples_[source];
        return sample.missed >= enough && sample.met_before * 4 < sample.missed;
    }

private:
    static constexpr unsigned enough = 4, max_counted = 64;

    struct Sample {
        std::uint64_t key = 0;
        ano::TimePoint at = ano::TimePoint::min();
        LinkSet links;    // all that brought any
        LinkId link{};
        bool elsewhere = false;                 // another link brought frames meanwhile
        bool met = false;                       // and this one
        unsigned met_before = 0, missed = 0;    // how often, of those where another link spoke
    };

    // The link that is always later brings nothing that another will bring: samples are of one and the other in turn. What a
    // sensor at rest repeats tells nothing.
    static void take(Sample& sample, LinkId link, std::uint64_t key, ano::TimePoint now) noexcept {
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
