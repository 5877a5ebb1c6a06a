#include <gtest/gtest.h>
#include <anoctl/recording/plot_json.hpp>

#include <nlohmann/json.hpp>
#include <support/bytes.hpp>

#include <algorithm>
#include <cstddef>
#include <string>

namespace plot_json_tests {
namespace {

using nlohmann::json;

json plotted(const support::Bytes& frame, const std::string& link = "fc") {
    const auto texts = anoctl::plot_json(ano::FrameView{frame}, link, 1763898044.25, {});
    EXPECT_LE(texts.size(), 1u);
    return texts.empty() ? json{} : json::parse(texts[0]);
}

TEST(PlotJson, has_the_time_and_the_numbers_by_link_address_and_message) {
    const json said = plotted(support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1}));
    EXPECT_DOUBLE_EQ(said["timestamp"], 1763898044.25);
    EXPECT_DOUBLE_EQ(said["fc"]["0xDC"]["euler"]["rol"], 1.23);
    EXPECT_EQ(said.size(), 2u);
}

TEST(PlotJson, leaves_out_text_and_frames_without_numbers) {
    const json text = plotted(support::frame(0xDC, 0xFE, 0xA0, {1, 'a', 'b'}));
    EXPECT_EQ(text.dump().find("ab"), std::string::npos) << text;
    EXPECT_TRUE(plotted(support::frame(0xDC, 0xFE, 0x03, {1})).is_null()) << "too short for its layout";
}

TEST(PlotJson, a_link_may_have_any_name) {
    EXPECT_EQ(plotted(support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1}), "timestamp")["timestamp"], 1763898044.25);
}

TEST(PlotJson, splits_a_large_message_into_several_objects_with_the_same_time) {
    const support::Bytes inertial = support::frame(0xDC, 0xFE, 0x01, {1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 1});
    const json whole = plotted(inertial)["fc"]["0xDC"]["inertial"];
    ASSERT_EQ(whole.size(), 7u);
    for (const std::size_t most : {std::size_t{100}, std::size_t{130}, anoctl::usual_datagram}) {
        json together = json::object();
        std::size_t parts = 0, longest = 0;
        for (const std::string& text : anoctl::plot_json(ano::FrameView{inertial}, "fc", 1763898044.25, {}, most)) {
            const json one = json::parse(text);
            EXPECT_DOUBLE_EQ(one["timestamp"], 1763898044.25);
            const json& fields = one["fc"]["0xDC"]["inertial"];
            EXPECT_FALSE(fields.empty()) << text;
            for (const auto& [name, value] : fields.items()) {
                EXPECT_FALSE(together.contains(name)) << name;
                together[name] = value;
            }
            longest = std::max(longest, text.size());
            ++parts;
        }
        EXPECT_EQ(together, whole);
        EXPECT_LE(longest, most);
        EXPECT_EQ(parts > 1, most < anoctl::usual_datagram) << most;
        if (parts > 1) {
            EXPECT_GT(longest, most - 30) << "a part is as long as it may be";
        }
    }
}

TEST(PlotJson, a_field_that_is_too_long_by_itself_stays_whole) {
    const support::Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
    const auto texts = anoctl::plot_json(ano::FrameView{euler}, "fc", 1763898044.25, {}, 10);
    EXPECT_EQ(texts.size(), plotted(euler)["fc"]["0xDC"]["euler"].size());
}

}    // namespace
}    // namespace plot_json_tests
