#include <status/metrics_text.hpp>

#include <gtest/gtest.h>

#include <limits>

namespace anogate::metrics_text_tests {
namespace {

TEST(MetricsText, lists_one_family_after_the_other) {
    const auto written = [](MetricsForm form) {
        MetricsText text{form};
        text.family("anogate_link_frames_in", MetricType::counter, "good frames");
        text.sample({{"link", "fc"}}, std::uint64_t{18446744073709551615u});
        text.sample({{"link", "fc"}, {"peer", ""}}, std::uint64_t{0});
        text.family("anogate_uptime_seconds", MetricType::gauge, "since the start");
        text.sample({}, 1.5);
        text.family("anogate_build", MetricType::info, "what runs");
        text.sample({{"version", "1"}}, std::uint64_t{1});
        return text.finish();
    };
    EXPECT_EQ(written(MetricsForm::prometheus),
              "# HELP anogate_link_frames_in_total good frames\n"
              "# TYPE anogate_link_frames_in_total counter\n"
              "anogate_link_frames_in_total{link=\"fc\"} 18446744073709551615\n"
              "anogate_link_frames_in_total{link=\"fc\",peer=\"\"} 0\n"
              "# HELP anogate_uptime_seconds since the start\n"
              "# TYPE anogate_uptime_seconds gauge\n"
              "anogate_uptime_seconds 1.5\n"
              "# HELP anogate_build_info what runs\n"
              "# TYPE anogate_build_info gauge\n"
              "anogate_build_info{version=\"1\"} 1\n");
    EXPECT_EQ(written(MetricsForm::openmetrics),
              "# HELP anogate_link_frames_in good frames\n"
              "# TYPE anogate_link_frames_in counter\n"
              "anogate_link_frames_in_total{link=\"fc\"} 18446744073709551615\n"
              "anogate_link_frames_in_total{link=\"fc\",peer=\"\"} 0\n"
              "# HELP anogate_uptime_seconds since the start\n"
              "# TYPE anogate_uptime_seconds gauge\n"
              "# UNIT anogate_uptime_seconds seconds\n"
              "anogate_uptime_seconds 1.5\n"
              "# HELP anogate_build what runs\n"
              "# TYPE anogate_build info\n"
              "anogate_build_info{version=\"1\"} 1\n"
              "# EOF\n");
}

std::string labelled(std::string_view value) {
    MetricsText text{MetricsForm::prometheus};
    text.family("a", MetricType::gauge, "b");
    text.sample({{"l", value}}, std::uint64_t{1});
    const std::string all = text.finish();
    return all.substr(all.find("a{"));
}

TEST(MetricsText, escapes_special_characters_in_labels) {
    EXPECT_EQ(labelled("a\\b\"c\nd"), "a{l=\"a\\\\b\\\"c\\nd\"} 1\n");
    EXPECT_EQ(labelled("飞控"), "a{l=\"飞控\"} 1\n");
    EXPECT_EQ(labelled("x\xFFy"), "a{l=\"x\xEF\xBF\xBDy\"} 1\n");
}

TEST(MetricsText, writes_infinities_and_nan_as_words) {
    MetricsText text{MetricsForm::prometheus};
    text.family("a", MetricType::gauge, "b");
    text.sample({}, std::numeric_limits<double>::infinity());
    text.sample({}, -std::numeric_limits<double>::infinity());
    text.sample({}, std::numeric_limits<double>::quiet_NaN());
    const std::string all = text.finish();
    EXPECT_EQ(all.substr(all.find("a +")), "a +Inf\na -Inf\na NaN\n");
}

TEST(MetricsForm, is_the_newer_one_for_clients_that_request_it) {
    const auto form = [](const char* accept) { return metrics_form(accept); };
    EXPECT_EQ(form("application/openmetrics-text;version=1.0.0,application/openmetrics-text;version=0.0.1;q=0.75,"
                   "text/plain;version=0.0.4;q=0.5,*/*;q=0.1"),
              MetricsForm::openmetrics);
    EXPECT_EQ(form("application/openmetrics-text"), MetricsForm::openmetrics);
    EXPECT_EQ(form("application/openmetrics-text;version=0.0.1"), MetricsForm::prometheus);
    EXPECT_EQ(form("application/openmetrics-text;q=0.5,text/plain"), MetricsForm::prometheus);
    EXPECT_EQ(form("application/openmetrics-text;q=0"), MetricsForm::prometheus);
    for (const char* accept : {"", "*/*", "text/html", "text/plain;version=0.0.4"})
        EXPECT_EQ(form(accept), MetricsForm::prometheus) << accept;
}

}    // namespace
}    // namespace anogate::metrics_text_tests
