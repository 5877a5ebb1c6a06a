#include <sys/waiting_places.hpp>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace anogate {
namespace {

using Stage = WaitingConnection::Stage;
using All = std::span<const WaitingConnection>;

constexpr std::size_t few = 4;    // up to this number of connections, all parties rank the same

/// The number of connections of each party, at least `few`.
class ConnectionCounts {
public:
    explicit ConnectionCounts(All all) {
        client_ids_.reserve(all.size());
        for (const WaitingConnection& one : all) client_ids_.push_back(one.client_id);
        std::sort(client_ids_.begin(), client_ids_.end());
    }
    std::size_t of(std::uint64_t client_id) const {
        const auto [begin, end] = std::equal_range(client_ids_.begin(), client_ids_.end(), client_id);
        return std::max(few, static_cast<std::size_t>(end - begin));
    }
    /// Only for a few connections at a time: behind the same address there may be somebody else.
    bool is_preferred(const WaitingConnection& one) const { return one.has_priority && of(one.client_id) <= few; }

private:
    std::vector<std::uint64_t> client_ids_;
};

}    // namespace

std::optional<std::size_t> next_evicted(All all, bool for_priority) {
    const ConnectionCounts counts{all};
    const bool all_have_priority = std::all_of(all.begin(), all.end(), [&](const auto& one) { return counts.is_preferred(one); });
    if (all_have_priority && !for_priority) return std::nullopt;
    std::size_t most = 0;
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].stage == Stage::at_work || (counts.is_preferred(all[i]) && !all_have_priority)) continue;
        const std::size_t has = counts.of(all[i].client_id);
        if (has > most) candidates.clear();
        if (has < most) continue;
        most = has;
        candidates.push_back(i);
    }
    std::array<std::size_t, 3> of_stage{};
    for (const std::size_t i : candidates) ++of_stage[static_cast<std::size_t>(all[i].stage)];
    const auto rank = [&](std::size_t i) {
        return std::tuple{of_stage[static_cast<std::size_t>(all[i].stage)], -all[i].since.time_since_epoch()};
    };
    const auto found = std::max_element(candidates.begin(), candidates.end(),
                                        [&](std::size_t one, std::size_t other) { return rank(one) < rank(other); });
    return found == candidates.end() ? std::nullopt : std::optional{*found};
}

std::optional<std::size_t> next_turn(All all, std::size_t places) {
    const ConnectionCounts counts{all};
    const int order = all.size() >= places - places / 4 ? -1 : 1;
    std::optional<std::size_t> next;
    const auto rank = [&](const WaitingConnection& one) {
        return std::tuple{!counts.is_preferred(one), !one.has_answered, counts.of(one.client_id),
                          order * one.since.time_since_epoch()};
    };
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].stage == Stage::its_turn && (!next || rank(all[i]) < rank(all[*next]))) next = i;
    return next;
}

}    // namespace anogate
