#include <http/listeners/accept.hpp>

#include <gtest/gtest.h>

namespace anogate::http::accept_tests {
namespace {

// The header that Prometheus 2.42 sends.
constexpr char prometheus[] =
    "application/openmetrics-text;version=1.0.0,application/openmetrics-text;version=0.0.1;q=0.75,"
    "text/plain;version=0.0.4;q=0.5,*/*;q=0.1";

TEST(Accept, lists_types_with_their_quality) {
    EXPECT_EQ(quality(prometheus, "application/openmetrics-text", "1.0.0"), 1000u);
    EXPECT_EQ(quality(prometheus, "application/openmetrics-text", "0.0.1"), 750u);
    EXPECT_EQ(quality(prometheus, "text/plain"), 500u);
    EXPECT_EQ(quality(prometheus, "text/html"), std::nullopt) << "what only a wildcard allows is not asked for";
    EXPECT_EQ(quality("text/html", "text/html"), 1000u);
    EXPECT_EQ(quality("Text/HTML ; Q=0.3 , a/b", "text/html"), 300u);
    EXPECT_EQ(quality("application/openmetrics-text", "application/openmetrics-text", "1.0.0"), 1000u) << "any version";
}

TEST(Accept, of_another_version_does_not_match) {
    EXPECT_EQ(quality("application/openmetrics-text; version=0.0.1", "application/openmetrics-text", "1.0.0"), std::nullopt);
}

TEST(Accept, that_is_invalid_accepts_nothing) {
    for (const char* accept :
         {"", ",", ";", ";;=,=;q", "text", "text/html;q=0", "text/html;q=x", "text/html;q=7", "text/html;q=-1"})
        EXPECT_EQ(quality(accept, "text/html").value_or(0), 0u) << accept;
}

}    // namespace
}    // namespace anogate::http::accept_tests
