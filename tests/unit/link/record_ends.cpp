#include <link/tcp/record_ends.hpp>

#include <gtest/gtest.h>

#include <vector>

using anogate::RecordEnds;
using Bytes = std::vector<std::uint8_t>;

namespace record_ends_tests {
namespace {

TEST(RecordEnds, are_found_from_every_position_in_a_record) {
    Bytes records{22, 3, 3, 1, 0};    // 256 bytes
    records.resize(5 + 256, 7);
    records.insert(records.end(), {20, 3, 3, 0, 1, 1});
    RecordEnds ends;
    for (std::size_t at = 0; at < 5 + 256; ++at) {
        EXPECT_EQ(ends.missing(std::span{records}.subspan(at)), 5 + 256 - static_cast<int>(at)) << at;
        ends.took(std::span{records}.subspan(at, 1));
    }
    EXPECT_EQ(ends.missing({}), 5);
    EXPECT_EQ(ends.missing(std::span{records}.subspan(261, 4)), 5) << "its length has not arrived";
    EXPECT_EQ(ends.missing(std::span{records}.subspan(261)), 6);
    ends.took(std::span{records}.subspan(261));
    EXPECT_EQ(ends.missing({}), 5);
}

TEST(RecordEnds, are_the_same_however_the_bytes_were_read) {
    RecordEnds ends;
    ends.took(Bytes{22, 3, 3, 0, 2, 1, 1, 22, 3});
    EXPECT_EQ(ends.missing({}), 3);
    EXPECT_EQ(ends.missing(Bytes{3, 0, 9}), 12);
}

TEST(RecordEnds, do_not_wait_for_more_bytes_than_a_record_may_have) {
    EXPECT_EQ(RecordEnds{}.missing(Bytes{22, 3, 3, 0xFF, 0xFF}), 5 + 16 * 1024 + 256);
}

}    // namespace
}    // namespace record_ends_tests
