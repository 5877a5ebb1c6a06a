// Which frames a link receives and sends, and how often.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/counters.hpp>

#include <array>
#include <bitset>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace anogate {

/// Ids or addresses, both ends included.
struct ByteRange {
    std::uint8_t first = 0;
    std::uint8_t last = 0;
    bool operator==(const ByteRange&) const = default;
};

/// What can be configured under `receive` and `send`. An empty `allow` allows everything; `deny` takes precedence over `allow`.
struct FilterSettings {
    std::vector<ByteRange> allow, deny;    // of the frame's id
    std::vector<ByteRange> allow_sources, deny_sources;
    std::vector<ByteRange> allow_destinations, deny_destinations;
    bool operator==(const FilterSettings&) const = default;
};

/// At most `per_second` frames a second of an id.
struct LimitRule {
    std::uint8_t id = 0;
    double per_second = 0;    // above 0
    bool operator==(const LimitRule&) const = default;
};

/// The filters and limits of a link.
struct RuleSettings {
    FilterSettings receive, send;
    std::vector<LimitRule> limit;    // for sent frames; at most one per id
    bool operator==(const RuleSettings&) const = default;
};

/// Needs three look-ups per frame. A link without filters has no object of this class, rather than one that passes everything.
class Filter {
public:
    explicit Filter(const FilterSettings& settings)
        : ids_{compiled(settings.allow, settings.deny)},
          sources_{compiled(settings.allow_sources, settings.deny_sources)},
          destinations_{compiled(settings.allow_destinations, settings.deny_destinations)} {}

    bool passes(std::uint8_t source, std::uint8_t destination, std::uint8_t id) const noexcept {
        return ids_[id] && sources_[source] && destinations_[destination];
    }

private:
    using Set = std::bitset<256>;

    static Set compiled(const std::vector<ByteRange>& allow, const std::vector<ByteRange>& deny) {
        const Set allowed = set_of(allow);
        return (allow.empty() ? ~Set{} : allowed) & ~set_of(deny);
    }
    static Set set_of(const std::vector<ByteRange>& ranges) {
        Set set;
        for (const ByteRange& range : ranges)
            for (unsigned n = range.first; n <= range.last; ++n) set.set(n);
        return set;
    }

    Set ids_, sources_, destinations_;
};

/// Limits the frames of an id per second, evenly spaced. A frame less than 1/rate after the last one that passed does not pass;
/// an earlier pause does not allow a burst.
class Limit {
public:
    /// `per_second` frames of `id`, above 0.
    void set(std::uint8_t id, double per_second) {
        assert(per_second > 0);
        const std::chrono::duration<double> spacing{1 / per_second};
        constexpr std::chrono::hours max_spacing{24};
        spacing_[id] = spacing < max_spacing ? std::chrono::duration_cast<ano::Duration>(spacing) : max_spacing;
    }
    bool passes(std::uint8_t id, ano::TimePoint now) noexcept {
        if (now < next_[id]) return false;
        next_[id] = now + spacing_[id];
        return true;
    }

private:
    std::array<ano::Duration, 256> spacing_{};
    std::array<ano::TimePoint, 256> next_ = [] {
        std::array<ano::TimePoint, 256> all;
        all.fill(ano::TimePoint::min());
        return all;
    }();
};

/// Applies the rules of one link. A link without rules has no object of this class, rather than one that passes everything.
class Rules {
public:
    /// `sends_empty`: whether frames without DATA are sent.
    explicit Rules(const RuleSettings& settings, bool sends_empty = true) : sends_empty_{sends_empty} {
        if (settings.receive != FilterSettings{}) receive_.emplace(settings.receive);
        if (settings.send != FilterSettings{}) send_.emplace(settings.send);
        if (settings.limit.empty()) return;
        limit_ = std::make_unique<Limit>();
        for (const LimitRule& rule : settings.limit) limit_->set(rule.id, rule.per_second);
    }

    bool takes(ano::FrameView frame) const noexcept { return !receive_ || passes(*receive_, frame); }
    /// Whether the send filter passes the frame; limits are not checked.
    bool sends(ano::FrameView frame) const noexcept {
        return (sends_empty_ || !frame.data().empty()) && (!send_ || passes(*send_, frame));
    }
    /// nullptr: the frame may be sent; otherwise the counter for the reason. A frame that is sent on several channels of the link
    /// counts once for the limits: `number`, above 0, is the number of the frame in the gateway.
    SendCause refusal(ano::FrameView frame, std::uint64_t number, ano::TimePoint now) noexcept {
        if (number == judged_) return verdict_;
        judged_ = number;
        if ((!sends_empty_ && frame.data().empty()) || (send_ && !passes(*send_, frame)))
            return verdict_ = &SendCounters::denied_out;
        if (limit_ && !limit_->passes(frame.id(), now)) return verdict_ = &SendCounters::limited;
        return verdict_ = nullptr;
    }

private:
    static bool passes(const Filter& filter, ano::FrameView frame) noexcept {
        return filter.passes(frame.source(), frame.destination(), frame.id());
    }

    std::optional<Filter> receive_, send_;
    std::unique_ptr<Limit> limit_;
    bool sends_empty_;
    std::uint64_t judged_ = 0;
    SendCause verdict_ = nullptr;
};

}    // namespace anogate
