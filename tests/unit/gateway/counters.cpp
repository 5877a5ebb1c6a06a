#include <gateway/counters.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <iterator>
#include <set>
#include <string_view>

namespace counters_tests {

using namespace anogate;

TEST(Counters, every_member_except_offered_has_a_row) {
    EXPECT_EQ(std::size(receive_counters) * sizeof(std::uint64_t), sizeof(ReceiveCounters));
    EXPECT_EQ((std::size(send_counters) + 1) * sizeof(std::uint64_t), sizeof(SendCounters));
}

TEST(Counters, names_and_members_are_distinct) {
    std::set<std::string_view> names;
    ReceiveCounters r;
    for (const auto& row : receive_counters) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_EQ(r.*row.value, 0u) << row.name;
        r.*row.value = 1;
        EXPECT_FALSE(row.help.empty());
    }
    SendCounters s;
    for (const auto& row : send_counters) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_EQ(s.*row.value, 0u) << row.name;
        s.*row.value = 1;
        EXPECT_FALSE(row.help.empty());
    }
}

TEST(Counters, add_sums_each_counter) {
    SendCounters a;
    SendCounters b;
    std::uint64_t n = 1;
    for (const auto& row : send_counters) {
        a.*row.value = n;
        b.*row.value = 1000 * n++;
    }
    a.offered = 7;
    b.offered = 8;
    add(a, b);
    n = 1;
    for (const auto& row : send_counters) EXPECT_EQ(a.*row.value, 1001 * n++) << row.name;
    EXPECT_EQ(a.offered, 15u);
}

TEST(Counters, parser_counters_are_added) {
    ano::ParserCounters parser;
    parser.frames_in = 1;
    parser.bytes_in = 2;
    parser.bad_check = 3;
    parser.bad_length = 4;
    parser.skipped_bytes = 5;
    parser.expired = 6;
    ReceiveCounters c;
    for (int n = 0; n < 2; ++n) add(c, parser);
    EXPECT_EQ((std::array{c.frames_in, c.bytes_in, c.bad_check, c.bad_length, c.skipped_bytes, c.expired}),
              (std::array<std::uint64_t, 6>{2, 4, 6, 8, 10, 12}));
}

// Each counter that accounts for an offered frame, by its row: all except those that count something else about sent frames.
TEST(Counters, frames_that_are_not_accounted_for_are_waiting) {
    SendCounters c;
    c.offered = 100;
    std::uint64_t expected = 100;
    for (const auto& row : send_counters) {
        c.*row.value += 3;
        if (row.name != "bytes_out" && row.name != "empty_out" && row.name != "flush_bytes") expected -= 3;
        EXPECT_EQ(unaccounted(c), expected) << row.name;
    }
}

}    // namespace counters_tests
