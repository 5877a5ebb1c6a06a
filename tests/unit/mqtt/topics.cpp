#include <mqtt/topics.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace topics_tests {
namespace {

using namespace anogate;
using namespace std::string_literals;

TEST(MqttTopics, a_level_has_no_character_that_means_something_in_a_topic) {
    for (const std::string& good : {"drone-1"s, "无人机"s, "a b"s, "x.y"s, std::string(64, 'x')})
        EXPECT_TRUE(is_level(good)) << good;
    for (const std::string& bad : {""s, "a/b"s, "a+"s, "#"s, "a\0b"s, "a\n"s, "$SYS"s, "\xff"s, std::string(65, 'x')})
        EXPECT_FALSE(is_level(bad)) << bad;
}

TEST(MqttTopics, any_text_becomes_a_level) {
    EXPECT_EQ(level_of("a/b+c#d\0e"s), "a_b_c_d_e");
    EXPECT_EQ(level_of("$SYS"), "_SYS");
    EXPECT_EQ(level_of(""), "_");
    for (const std::string& text : {std::string(200, 'x'), std::string(21, 'x') + "无人机无人机无人机无人机无人机", "\xff\xfe"s})
        EXPECT_TRUE(is_level(level_of(text))) << text;
}

TEST(MqttTopics, no_topic_has_more_than_six_levels_or_256_bytes) {
    const Topics topics{std::string(64, 'g')};
    const std::string device = device_level(std::string(100, 'l'), 0x0B);
    EXPECT_TRUE(is_level(device));
    for (const std::string& topic : {topics.status(), topics.up(device, std::string(64, 'm')), topics.raw_up(), topics.raw_down(),
                                     topics.backlog(Keep::normal), topics.response(std::string(64, 'c'))}) {
        EXPECT_LE(std::count(topic.begin(), topic.end(), '/'), 5) << topic;
        EXPECT_LE(topic.size(), 256u) << topic;
        EXPECT_EQ(gateway_of(topic), std::string(64, 'g'));
    }
    EXPECT_EQ(Topics{"g"}.up("fc-05", "euler"), "anogate/v1/g/up/fc-05/euler");
    EXPECT_EQ(device_level("fc", 5), "fc-05");
}

TEST(MqttTopics, the_client_of_a_request_is_the_last_level) {
    const Topics topics{"g"};
    EXPECT_EQ(topics.client_of("anogate/v1/g/request/shore"), "shore");
    for (const char* other : {"anogate/v1/h/request/shore", "anogate/v1/g/response/shore", "anogate/v1/g/request/a/b",
                              "anogate/v1/g/request/", "anogate/v1/g/request", ""})
        EXPECT_EQ(topics.client_of(other), "") << other;
    EXPECT_TRUE(is_backlog("anogate/v1/g/backlog/low"));
    EXPECT_FALSE(is_backlog("anogate/v1/backlog/low"));
}

}    // namespace
}    // namespace topics_tests
