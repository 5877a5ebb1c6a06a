#include <gateway/filter.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace filter_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

template <class Change>
Filter filter(Change change) {
    FilterSettings settings;
    change(settings);
    return Filter{settings};
}

TEST(Filter, empty_passes_all) {
    const Filter all{{}};
    EXPECT_TRUE(all.passes(0, 0, 0));
    EXPECT_TRUE(all.passes(0xFF, 0xFF, 0xFF));
}

TEST(Filter, passes_only_allowed_frames) {
    const Filter ids = filter([](auto& s) { s.allow = {{0x01, 0x0F}, {0xFF, 0xFF}}; });
    EXPECT_TRUE(ids.passes(1, 2, 0x01) && ids.passes(1, 2, 0x0F) && ids.passes(1, 2, 0xFF));
    EXPECT_FALSE(ids.passes(1, 2, 0x00) || ids.passes(1, 2, 0x10) || ids.passes(1, 2, 0xFE));
    const Filter sources = filter([](auto& s) { s.allow_sources = {{0xFE, 0xFE}}; });
    EXPECT_TRUE(sources.passes(0xFE, 1, 1));
    EXPECT_FALSE(sources.passes(0xDC, 0xFE, 0xFE));
    const Filter destinations = filter([](auto& s) { s.allow_destinations = {{0xFE, 0xFE}}; });
    EXPECT_TRUE(destinations.passes(1, 0xFE, 1));
    EXPECT_FALSE(destinations.passes(0xFE, 0xFF, 0xFE));
}

TEST(Filter, denies_frames_even_if_they_are_allowed) {
    const Filter ids = filter([](auto& s) {
        s.allow = {{0x10, 0x1F}};
        s.deny = {{0x13, 0x14}};
    });
    EXPECT_TRUE(ids.passes(1, 1, 0x12) && ids.passes(1, 1, 0x15));
    EXPECT_FALSE(ids.passes(1, 1, 0x13) || ids.passes(1, 1, 0x14));
    const Filter sources = filter([](auto& s) { s.deny_sources = {{0x20, 0x20}}; });
    EXPECT_TRUE(sources.passes(0x21, 0x20, 0x20));
    EXPECT_FALSE(sources.passes(0x20, 1, 1));
    const Filter destinations = filter([](auto& s) { s.deny_destinations = {{0xFF, 0xFF}}; });
    EXPECT_TRUE(destinations.passes(0xFF, 0xFE, 0xFF));
    EXPECT_FALSE(destinations.passes(1, 0xFF, 1));
}

TEST(Rules, drop_outgoing_frames_without_data_on_a_link_that_does_not_accept_them) {
    const auto empty = support::frame(0xFE, 0xDC, 0xFB);
    const auto full = support::frame(0xFE, 0xDC, 0xFB, {0});
    Rules rules{{}, false};
    EXPECT_EQ(rules.refusal(ano::FrameView{empty}, 1, {}), &SendCounters::denied_out);
    EXPECT_EQ(rules.refusal(ano::FrameView{full}, 2, {}), nullptr);
    EXPECT_TRUE(rules.takes(ano::FrameView{empty})) << "what comes in is another matter";
    Rules others{{}};
    EXPECT_EQ(others.refusal(ano::FrameView{empty}, 1, {}), nullptr);
}

TEST(Limit, spaces_frames_and_allows_no_burst) {
    Limit limit;
    limit.set(0x01, 50);
    ano::TimePoint now{};
    EXPECT_TRUE(limit.passes(0x01, now));
    EXPECT_FALSE(limit.passes(0x01, now + 20ms - 1ns));
    EXPECT_TRUE(limit.passes(0x01, now + 20ms));
    now += 10s;
    EXPECT_TRUE(limit.passes(0x01, now));
    EXPECT_FALSE(limit.passes(0x01, now)) << "no burst";
}

TEST(Limit, holds_for_its_id_alone) {
    Limit limit;
    limit.set(0x01, 0.5);
    limit.set(0x02, 1e-9);
    const ano::TimePoint now{};
    EXPECT_TRUE(limit.passes(0x01, now) && limit.passes(0x02, now));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(limit.passes(0x03, now));
    EXPECT_FALSE(limit.passes(0x01, now + 1999ms) || limit.passes(0x02, now + 1h));
    EXPECT_TRUE(limit.passes(0x01, now + 2s));
}

TEST(Limit, passes_at_most_the_limit_per_second_at_any_rate) {
    for (const int offered : {10, 49, 50, 51, 99, 100, 333, 5000}) {
        Limit limit;
        limit.set(0x01, 50);
        int passed = 0;
        for (int i = 0; i < offered; ++i) passed += limit.passes(0x01, ano::TimePoint{} + i * ano::Duration{1s} / offered);
        EXPECT_LE(passed, 50);
        EXPECT_GE(passed, std::min(offered, 50) / 2) << offered;
    }
}

}    // namespace
}    // namespace filter_tests
