#include <anoctl/text/top_screen.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace top_screen_tests {

using namespace anoctl;
using nlohmann::json;

namespace {

json channel(const std::string& peer, unsigned in, unsigned out, unsigned stale = 0) {
    return {{"peer", peer}, {"heard_s", 0.5}, {"frames_in", in}, {"frames_out", out}, {"stale", stale}, {"waiting", 3}};
}

json status(json links) {
    return {{"gateway", {{"name", "here"}, {"version", "1.2.3"}, {"uptime_s", 125.0}}},
            {"links", std::move(links)},
            {"routes",
             {{{"address", "0xDC"}, {"who", "flight controller"}, {"links", {"fc", "radio"}}, {"age_s", 0.2}},
              {{"address", "0x07"}, {"who", "port"}, {"links", {"fc"}}}}}};
}

json fc(unsigned in, unsigned out, unsigned stale = 0) {
    return {{"name", "fc"}, {"state", "up"}, {"channels", {channel("/dev/ttyUSB0", in, out, stale)}}};
}

json down() {
    return {{"name", "radio"},           {"state", "waiting"}, {"error", "/dev/radio: no such device"},
            {"channels", json::array()}, {"frames_in", 0},     {"link_down", 10}};
}

const HeardFrames nobody{};

bool contains(const std::vector<std::string>& lines, const std::string& words) {
    return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) { return line.find(words) != line.npos; });
}

TEST(TopScreen, rates_are_computed_between_two_updates) {
    HeardFrames heard{};
    heard[0xDC] = 50;
    const TopView view = top_view(status(json::array({fc(100, 10, 1), down()})), status(json::array({fc(150, 30, 5), down()})), 2,
                                  heard);
    ASSERT_EQ(view.channels.size(), 2u);
    EXPECT_EQ(view.channels[0].link, "fc");
    EXPECT_EQ(view.channels[0].peer, "/dev/ttyUSB0");
    EXPECT_EQ(view.channels[0].in, 25);
    EXPECT_EQ(view.channels[0].out, 10);
    EXPECT_EQ(view.channels[0].dropped, 2);
    EXPECT_EQ(view.channels[0].causes, "stale 2.0");
    EXPECT_EQ(view.channels[0].waiting, 3u);
    EXPECT_EQ(view.channels[0].age, 0.5);
    EXPECT_EQ(view.channels[1].causes, "/dev/radio: no such device");
    ASSERT_EQ(view.addresses.size(), 2u);
    EXPECT_EQ(view.addresses[0].rate, 25);
    EXPECT_EQ(view.addresses[0].links, "fc, radio");
    EXPECT_EQ(view.title, "here 1.2.3, up 2 min; frames/s: 25.0 in, 10.0 out, 2.0 dropped") << view.title;
}

TEST(TopScreen, a_replay_without_a_receiver_loses_nothing) {
    const auto replay = [](unsigned no_route) {
        json link = fc(0, 0);
        link["replayed"] = json::array();
        link["channels"][0]["no_route"] = no_route;
        return status(json::array({link}));
    };
    EXPECT_EQ(top_view(replay(0), replay(100), 1, nobody).channels.at(0).dropped, 0);
}

TEST(TopScreen, shows_no_rates_on_the_first_update_and_after_a_gateway_restart) {
    EXPECT_EQ(top_view(json{}, status(json::array({fc(150, 30)})), 0, nobody).channels.at(0).in, 0);
    EXPECT_EQ(top_view(status(json::array({fc(150, 30)})), status(json::array({fc(5, 3)})), 1, nobody).channels.at(0).in, 0);
    EXPECT_EQ(top_view(status(json::array()), status(json::array({fc(5, 3)})), 1, nobody).channels.at(0).in, 0)
        << "a channel that is new";
    for (const json& odd : {json(), json("x"), json{{"links", 5}, {"routes", {1, "a"}}}, json{{"links", {1, json::object()}}}})
        EXPECT_EQ(top_screen(top_view(odd, odd, 1, nobody), TopSort::in, 80, 24).size(), 24u);
}

TEST(TopScreen, sorts_the_busiest_first) {
    TopView view;
    view.channels = {{"a", "", 1, 5, 0, "", 0, 2.0}, {"b", "", 9, 0, 1, "", 0, {}}, {"c", "", 3, 0, 4, "", 0, 1.0}};
    const auto order = [&](TopSort by) {
        sort(view, by);
        std::string names;
        for (const TopChannel& row : view.channels) names += row.link;
        return names;
    };
    EXPECT_EQ(order(TopSort::in), "bca");
    EXPECT_EQ(order(TopSort::out), "abc");
    EXPECT_EQ(order(TopSort::dropped), "cba");
    EXPECT_EQ(order(TopSort::age), "cab") << "who was never heard stands last";
    EXPECT_EQ(order(TopSort::name), "abc");
    TopSort by = TopSort::name;
    for (int i = 0; i < 5; ++i) by = next(by);
    EXPECT_EQ(by, TopSort::name) << "all were there";
}

TEST(TopScreen, fits_the_terminal_and_counts_the_rows_without_room) {
    TopView view;
    view.title = "here";
    for (int i = 0; i < 40; ++i) {
        view.channels.push_back({"link" + std::to_string(i), std::string(60, 'x')});
        view.addresses.push_back({"0xDC", "flight controller", "fc"});
    }
    for (const std::size_t height : {0u, 1u, 4u, 5u, 6u, 24u, 50u})
        for (const std::size_t width : {0u, 10u, 80u, 200u}) {
            const auto screen = top_screen(view, TopSort::name, width, height);
            ASSERT_EQ(screen.size(), height);
            for (const std::string& line : screen) EXPECT_LE(line.size(), width);
        }
    const auto screen = top_screen(view, TopSort::out, 80, 24);
    EXPECT_EQ(screen.back(), "q quit   s sort, by out");
    EXPECT_TRUE(contains(screen, "... and 28 more")) << "of the channels";
    EXPECT_TRUE(contains(screen, "... and 35 more")) << "of the addresses";
}

TEST(TopScreen, replaces_control_characters_in_names) {
    TopView view;
    view.channels.push_back({"\x1b[2J\xC2\x9B", "a\nb"});
    const auto screen = top_screen(view, TopSort::name, 80, 24);
    for (const std::string& line : screen) {
        EXPECT_EQ(line.find('\x1b'), std::string::npos);
        EXPECT_EQ(line.find('\n'), std::string::npos);
        EXPECT_EQ(line.find("\xC2\x9B"), std::string::npos);
    }
    EXPECT_TRUE(contains(screen, "?[2J?"));
    view.channels = {{"ünterflächenmäßig", "x"}};
    EXPECT_TRUE(contains(top_screen(view, TopSort::name, 80, 24), "ünterflächenmäßig x ")) << "columns are of characters";
}

TEST(TopScreen, names_use_the_available_width) {
    TopView view;
    const std::string link = "a-link-with-a-long-name", peer = "[2001:db8:1234:5678:9abc:def0:1234:5678]:12333";
    view.channels = {{link, "192.168.100.100:12345", 1, 2, 3, "stale 3.0"}, {"b", peer}};
    const auto narrow = top_screen(view, TopSort::name, 80, 24);
    EXPECT_TRUE(contains(narrow, "a-link-wit 192.168.100.100:12345   1.0   2.0    3.0     0      -  stale 3.0")) << narrow[2];
    EXPECT_TRUE(contains(narrow, "LINK       PEER                   IN/s OUT/s LOST/s QUEUE    AGE  LOST BY CAUSE")) << narrow[1];
    const auto wide = top_screen(view, TopSort::name, 160, 24);
    EXPECT_TRUE(contains(wide, link + " 192.168.100.100:12345 ")) << wide[2];
    EXPECT_TRUE(contains(wide, peer + "     0")) << wide[3];
    view.channels = {{"fc", "/dev/ttyUSB0", 1, 2, 3, "stale 2.0, queue_full 1.0"}};
    EXPECT_TRUE(contains(top_screen(view, TopSort::name, 80, 24), "stale 2.0, queue_full 1.0")) << "short names leave room";
}

TEST(TopScreen, numbers_are_separated_by_spaces) {
    TopView view;
    view.channels = {{"fc", "x", 99999, 99999, 99999, "", 123456, 3540.0}};
    EXPECT_TRUE(contains(top_screen(view, TopSort::name, 80, 24), " 99999 99999  99999 123456 59 min"));
}

}    // namespace
}    // namespace top_screen_tests
