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
class Parties {
public:
    explicit Parties(All all) {
        parties_.reserve(all.size());
        for (const WaitingConnection& one : all) parties_.push_back(one.party);
        std::sort(parties_.begin(), parties_.end());
    }
    std::size_t of(std::uint64_t party) const {
        const auto [begin, end] = std::equal_range(parties_.begin(), parties_.end(), party);
        return std::max(few, static_cast<std::size_t>(end - begin));
    }
    /// Only for a few connections at a time: behind the same address there may be somebody else.
    bool go_first(const WaitingConnection& one) const { return one.goes_first && of(one.party) <= few; }

private:
    std::vector<std::uint64_t> parties_;
};

}    // namespace

std::optional<std::size_t> gives_way(All all, bool for_first) {
    const Parties parties{all};
    const bool all_go_first = std::all_of(all.begin(), all.end(), [&](const auto& one) { return parties.go_first(one); });
    if (all_go_first && !for_first) return std::nullopt;
    std::size_t most = 0;
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].stage == Stage::at_work || (parties.go_first(all[i]) && !all_go_first)) continue;
        const std::size_t has = parties.of(all[i].party);
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
    const Parties parties{all};
    const int order = all.size() >= places - places / 4 ? -1 : 1;
    std::optional<std::size_t> next;
    const auto rank = [&](const WaitingConnection& one) {
        return std::tuple{!parties.go_first(one), !one.has_answered, parties.of(one.party), order * one.since.time_since_epoch()};
    };
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].stage == Stage::its_turn && (!next || rank(all[i]) < rank(all[*next]))) next = i;
    return next;
}

}    // namespace anogate
