// The content of the ring of the latest frames, compared with a list that keeps everything.
#include <record/ring.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <vector>

namespace ring_tests {

namespace {

using anogate::Ring;
using namespace std::chrono_literals;

struct Pushed {
    unsigned number;
    std::size_t cost;
    ano::TimePoint at;
};

/// How many of the last of `all` fit into `most`.
std::size_t fitting(const std::vector<Pushed>& all, std::size_t most) {
    std::size_t count = 0, cost = 0;
    while (count < all.size() && (cost += all[all.size() - 1 - count].cost) <= most) ++count;
    return count;
}

TEST(RingProperty, stores_the_newest_items_that_fit_without_a_gap_and_none_that_is_too_old) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        support::Random random{seed};
        const auto span = std::chrono::milliseconds{1 + random.below(2000)};
        const std::size_t most = 1 + random.below(std::size_t{5000});
        Ring<unsigned> ring{span, most};
        std::vector<Pushed> all;
        ano::TimePoint now{};
        for (unsigned i = 0; i < 200; ++i) {
            now += std::chrono::milliseconds{random.below(100)};
            const std::size_t cost = random.below(std::size_t{random.one_in(20) ? 8000u : 300u});
            ring.push(i, cost, now);
            all.push_back({i, cost, now});
            ASSERT_LE(ring.cost(), most) << seed;
            ASSERT_LE(ring.items().size(), fitting(all, most)) << seed;
            ASSERT_LE(ring.reach(now), span) << seed;
            const auto sum = std::accumulate(ring.items().begin(), ring.items().end(), std::size_t{0},
                                             [](std::size_t all_cost, const auto& kept) { return all_cost + kept.cost; });
            ASSERT_EQ(ring.cost(), sum) << seed;
            for (std::size_t k = 0; k < ring.items().size(); ++k)
                ASSERT_EQ(ring.items()[k].item, i + 1 - ring.items().size() + k) << seed;
        }
    }
}

TEST(RingProperty, drops_only_as_many_items_as_necessary) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        support::Random random{seed};
        Ring<unsigned> ring{10s, 1000};
        std::vector<Pushed> all;
        for (unsigned i = 0; i < 100; ++i) {
            all.push_back({i, random.below(std::size_t{400}), ano::TimePoint{} + i * 10ms});
            ring.push(i, all.back().cost, all.back().at);
            // Dropped items do not return when space becomes free, so the size can grow by at most one per step.
            std::size_t least = 0;
            for (std::size_t k = 1; k <= all.size(); ++k) {
                const std::vector<Pushed> until{all.begin(), all.begin() + static_cast<std::ptrdiff_t>(k)};
                least = std::min(least + 1, fitting(until, 1000));
            }
            ASSERT_EQ(ring.items().size(), least) << seed << " " << i;
        }
    }
}

TEST(RingProperty, drops_old_items_as_time_passes_without_new_ones) {
    Ring<int> ring{100ms, 1000};
    const ano::TimePoint begin{};
    ring.push(1, 10, begin);
    ring.push(2, 10, begin + 60ms);
    ring.forget_until(begin + 100ms);
    EXPECT_EQ(ring.items().size(), 2u);
    ring.forget_until(begin + 101ms);
    EXPECT_EQ(ring.items().size(), 1u);
    ring.forget_until(begin + 161ms);
    EXPECT_EQ(ring.cost(), 0u);
    EXPECT_EQ(ring.reach(begin + 161ms), ano::Duration{});
}

}    // namespace
}    // namespace ring_tests
