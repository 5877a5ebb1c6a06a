#include <gtest/gtest.h>
#include <anoctl/plot_json.hpp>

#include <nlohmann/json.hpp>
#include <support/bytes.hpp>

#include <string>

namespace {

using nlohmann::json;

json plotted(const support::Bytes& frame, const std::string& link = "fc") {
    const std::string text = anoctl::plot_json(ano::FrameView{frame}, link, 1763898044.25, {});
    return text.empty() ? json{} : json::parse(text);
}

TEST(PlotJson, has_the_time_and_the_numbers_by_link_address_and_message) {
    const json said = plotted(support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1}));
    EXPECT_DOUBLE_EQ(said["timestamp"], 1763898044.25);
    EXPECT_DOUBLE_EQ(said["fc"]["0xDC"]["euler"]["rol"], 1.23);
    EXPECT_EQ(said.size(), 2u);
}

TEST(PlotJson, leaves_out_text_and_what_has_no_numbers) {
    const json text = plotted(support::frame(0xDC, 0xFE, 0xA0, {1, 'a', 'b'}));
    EXPECT_EQ(text.dump().find("ab"), std::string::npos) << text;
    EXPECT_TRUE(plotted(support::frame(0xDC, 0xFE, 0x03, {1})).is_null()) << "too short for its layout";
}

TEST(PlotJson, a_link_may_have_any_name) {
    EXPECT_EQ(plotted(support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1}), "timestamp")["timestamp"], 1763898044.25);
}

}    // namespace
