#include <http/range.hpp>

#include <gtest/gtest.h>

#include <string>

namespace anogate::http::range_tests {
namespace {

std::string shown(std::string_view header, std::uint64_t size = 100) {
    const Range range = wanted_range(header, size);
    const char* const kind = range.kind == Range::Kind::whole ? "whole" : range.kind == Range::Kind::part ? "part" : "outside";
    return std::string{kind} + " " + std::to_string(range.first) + "+" + std::to_string(range.size);
}

TEST(Range, contains_the_requested_bytes) {
    EXPECT_EQ(shown("bytes=0-9"), "part 0+10");
    EXPECT_EQ(shown("bytes=90-"), "part 90+10");
    EXPECT_EQ(shown("bytes=-10"), "part 90+10");
    EXPECT_EQ(shown("bytes= 5-5 "), "part 5+1");
}

TEST(Range, ends_at_the_end_of_the_file) {
    EXPECT_EQ(shown("bytes=90-1000"), "part 90+10");
    EXPECT_EQ(shown("bytes=-1000"), "part 0+100");
    EXPECT_EQ(shown("bytes=0-99999999999999999999999"), "part 0+100");
    EXPECT_EQ(shown("bytes=0-18446744073709551615"), "part 0+100");
}

TEST(Range, beyond_the_end_of_the_file_is_reported_as_outside) {
    EXPECT_EQ(shown("bytes=100-"), "outside 0+0");
    EXPECT_EQ(shown("bytes=99999999999999999999999-"), "outside 0+0");
    EXPECT_EQ(shown("bytes=-0"), "outside 0+0");
    EXPECT_EQ(shown("bytes=0-", 0), "outside 0+0");
    EXPECT_EQ(shown("bytes=-5", 0), "outside 0+0");
}

TEST(Range, that_is_invalid_selects_the_whole_file) {
    for (const char* header : {"", "bytes", "bytes=", "bytes=-", "bytes=x-", "bytes=1-x", "bytes=9-1", "lines=1-2",
                               "bytes=0-1,3-4", "bytes=+1-2", "bytes=--5"})
        EXPECT_EQ(shown(header), "whole 0+100") << header;
}

}    // namespace
}    // namespace anogate::http::range_tests
