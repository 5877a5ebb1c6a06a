#include <sys/waiting_places.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <vector>

namespace anogate {
namespace {

using Stage = WaitingConnection::Stage;
using All = std::span<const WaitingConnection>;

constexpr std::size_t few = 4;    // up to this number of connections, all parties rank the same

/// The number of connections of each party, at least `few`. It is counted for each new connection of a flood: a table of parties
/// takes a fifth of the time of sorting.
class ConnectionCounts {
public:
    explicit ConnectionCounts(All all) : all_{all}, table_(std::bit_ceil(2 * all.size() + 1)), at_(all.size()) {
        for (std::size_t i = 0; i < all.size(); ++i) {
            const std::size_t last = table_.size() - 1;
            std::size_t at = (all[i].client_id * 0x9E3779B97F4A7C15) >> 32 & last;
            while (table_[at].has > 0 && table_[at].client_id != all[i].client_id) at = (at + 1) & last;
            at_[i] = at;
            table_[at].client_id = all[i].client_id;
            ++table_[at].has;
        }
    }
    /// Of the party of connection `i`.
    std::size_t of(std::size_t i) const { return std::max(few, table_[at_[i]].has); }
    /// Only for a few connections at a time: behind the same address there may be somebody else.
    bool is_preferred(std::size_t i) const { return all_[i].has_priority && of(i) <= few; }

private:
    struct ClientId {
        std::uint64_t client_id = 0;
        std::size_t has = 0;
    };
    All all_;
    std::vector<ClientId> table_;
    std::vector<std::size_t> at_;    // of each connection: the index of its party
};

}    // namespace

std::optional<std::size_t> next_evicted(All all, bool for_priority) {
    const ConnectionCounts counts{all};
    bool all_have_priority = true;
    for (std::size_t i = 0; i < all.size(); ++i) all_have_priority = all_have_priority && counts.is_preferred(i);
    if (all_have_priority && !for_priority) return std::nullopt;
    std::size_t most = 0;
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].stage == Stage::at_work || (counts.is_preferred(i) && !all_have_priority)) continue;
        const std::size_t has = counts.of(i);
        if (has > most) candidates.clear();
        if (has < most) continue;
        most = has;
        candidates.push_back(i);
    }
    const auto group = [&](std::size_t i) { return 2 * static_cast<std::size_t>(all[i].stage) + (all[i].has_answered ? 1 : 0); };
    std::array<std::size_t, 6> of_group{};
    for (const std::size_t i : candidates) ++of_group[group(i)];
    const std::size_t largest = *std::max_element(of_group.begin(), of_group.end());
    std::optional<std::size_t> oldest;
    for (const std::size_t i : candidates)
        if (of_group[group(i)] == largest && (!oldest || all[i].since < all[*oldest].since)) oldest = i;
    return oldest;
}

std::optional<std::size_t> next_turn(All all, std::size_t places) {
    const ConnectionCounts counts{all};
    const int order = all.size() >= places - places / 4 ? -1 : 1;
    std::optional<std::size_t> next;
    const auto rank = [&](std::size_t i) {
        return std::tuple{!counts.is_preferred(i), !all[i].has_answered, counts.of(i), order * all[i].since.time_since_epoch()};
    };
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].stage == Stage::its_turn && (!next || rank(i) < rank(*next))) next = i;
    return next;
}

}    // namespace anogate
