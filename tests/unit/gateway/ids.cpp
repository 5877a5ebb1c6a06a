#include <gateway/ids.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace ids_tests {

using namespace anogate;

namespace {

ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }

TEST(IdSet, contains_the_inserted_ids) {
    ChannelSet set;
    EXPECT_TRUE(set.empty());
    for (const unsigned n : {0u, 5u, 63u}) set.insert(channel(n));
    EXPECT_EQ(set.size(), 3u);
    EXPECT_TRUE(set.contains(channel(0)) && set.contains(channel(5)) && set.contains(channel(63)));
    EXPECT_FALSE(set.contains(channel(1)) || set.contains(channel(62)));
    set.erase(channel(5));
    set.erase(channel(6));
    EXPECT_EQ(set, ChannelSet{channel(0)} | ChannelSet{channel(63)});
    EXPECT_TRUE(set.has_several());
    set.erase(channel(0));
    EXPECT_FALSE(set.has_several());
    set.clear();
    EXPECT_TRUE(set.empty());
    EXPECT_FALSE(set.has_several());
    EXPECT_EQ((~set).size(), 64u);
}

TEST(IdSet, iterates_in_ascending_order) {
    ChannelSet set;
    for (unsigned n = 64; n-- > 0;)
        if (n % 3 == 0) set.insert(channel(n));
    std::vector<std::size_t> seen;
    for (const ChannelId id : set) seen.push_back(index(id));
    ASSERT_EQ(seen.size(), 22u);
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], 3 * i);
}

TEST(IdSet, supports_union_intersection_and_difference) {
    const ChannelSet a = ChannelSet{channel(1)} | channel(2);
    const ChannelSet b = ChannelSet{channel(2)} | channel(3);
    EXPECT_EQ(a & b, ChannelSet{channel(2)});
    EXPECT_EQ(a - b, ChannelSet{channel(1)});
    EXPECT_EQ((a | b).size(), 3u);
    ChannelSet c = a;
    c |= b;
    EXPECT_EQ(c, a | b);
    c -= a;
    EXPECT_EQ(c, ChannelSet{channel(3)});
}

}    // namespace
}    // namespace ids_tests
