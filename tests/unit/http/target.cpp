#include <http/target.hpp>

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace anogate::http::target_tests {
namespace {

using namespace std::string_literals;

TEST(Target, is_a_path_and_a_query) {
    for (const auto& [target, path, query] : {std::tuple{"/status", "/status", ""},
                                              {"/status?a=1&b", "/status", "a=1&b"},
                                              {"/?", "/", ""},
                                              {"/a?b?c", "/a", "b?c"},
                                              {"/a#part", "/a", ""},
                                              {"http://anogate/links/fc?x", "/links/fc", "x"},
                                              {"https://[::1]:80/a", "/a", ""},
                                              {"http://anogate", "/", ""},
                                              {"http://anogate?x", "", "x"},
                                              {"*", "*", ""},
                                              {"", "", ""}}) {
        EXPECT_EQ(split(target).path, path) << target;
        EXPECT_EQ(split(target).query, query) << target;
    }
}

TEST(PercentDecoded, converts_a_percent_sign_and_two_digits_to_one_byte_and_keeps_other_bytes) {
    EXPECT_EQ(percent_decoded(""), "");
    EXPECT_EQ(percent_decoded("fc"), "fc");
    EXPECT_EQ(percent_decoded("a%20b%2Fc%2fd"), "a b/c/d");
    EXPECT_EQ(percent_decoded("%E5%8C%BF"), "匿");
    EXPECT_EQ(percent_decoded("%FF"), "\xFF"s);
    EXPECT_EQ(percent_decoded("a+b"), "a+b");
    EXPECT_EQ(percent_decoded("a+b%2B", true), "a b+");
    EXPECT_EQ(percent_decoded("%2525"), "%25") << "once";
}

TEST(PercentDecoded, rejects_an_invalid_byte) {
    for (const char* bad : {"%", "a%", "%2", "%2g", "%g2", "% 2", "%-1", "%+1", "%0x", "%%20", "a%2", "%00"})
        EXPECT_EQ(percent_decoded(bad), std::nullopt) << bad;
}

TEST(Query, contains_names_and_values_in_order) {
    EXPECT_EQ(parse_query(""), std::vector<Field>{});
    EXPECT_EQ(parse_query("&&"), std::vector<Field>{});
    EXPECT_EQ(parse_query("dry_run"), (std::vector<Field>{{"dry_run", ""}}));
    EXPECT_EQ(parse_query("a=1&b=2&a=3"), (std::vector<Field>{{"a", "1"}, {"b", "2"}, {"a", "3"}}));
    EXPECT_EQ(parse_query("a=b=c&=x&"), (std::vector<Field>{{"a", "b=c"}, {"", "x"}}));
    EXPECT_EQ(parse_query("name=my+link%26co"), (std::vector<Field>{{"name", "my link&co"}}));
    for (const char* bad : {"%", "a=%2", "a=1&%zz=2", "a=%00"}) EXPECT_EQ(parse_query(bad), std::nullopt) << bad;
}

TEST(Query, keeps_the_other_values_when_one_is_removed) {
    EXPECT_EQ(without_query_value("/a?token=x", "token"), "/a");
    EXPECT_EQ(without_query_value("/a?b=1&token=x&c", "token"), "/a?b=1&c");
    EXPECT_EQ(without_query_value("/a?token&tok%65n=y&b", "token"), "/a?b");
    EXPECT_EQ(without_query_value("/a?tokens=1&%zz=token", "token"), "/a?tokens=1&%zz=token");
    EXPECT_EQ(without_query_value("/token=x", "token"), "/token=x");
    EXPECT_EQ(without_query_value("", "token"), "");
}

TEST(OfferedSubprotocol, is_the_first_one_that_is_known) {
    constexpr std::string_view known[] = {"a.v1", "b.v1"};
    const auto offered = [&](std::vector<Field> headers) {
        Request request;
        request.headers = std::move(headers);
        return offered_subprotocol(request, known);
    };
    EXPECT_EQ(offered({{"Sec-WebSocket-Protocol", "b.v1, a.v1"}}), "b.v1");
    EXPECT_EQ(offered({{"sec-websocket-protocol", "c.v1"}, {"Sec-WebSocket-Protocol", " a.v1\t"}}), "a.v1");
    EXPECT_EQ(offered({{"Sec-WebSocket-Protocol", "A.v1,,a.v10"}}), "");
    EXPECT_EQ(offered({{"Upgrade", "a.v1"}}), "");
}

}    // namespace
}    // namespace anogate::http::target_tests
