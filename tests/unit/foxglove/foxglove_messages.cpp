#include <foxglove/foxglove_messages.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <variant>
#include <vector>

namespace anogate::foxglove::foxglove_messages_tests {
namespace {

using nlohmann::json;
using namespace std::string_literals;

std::string wrong(std::string_view text) {
    const ClientMessage said = read(text);
    const auto* const words = std::get_if<Wrong>(&said);
    return words ? words->words : "nothing is wrong";
}

TEST(FoxgloveMessages, messages_of_a_client_are_parsed) {
    const ClientMessage subscribed = read(
        R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":5}]})");
    const auto& two = std::get<Subscribe>(subscribed).subscriptions;
    ASSERT_EQ(two.size(), 2u);
    EXPECT_EQ(two[0].channel, 3u);
    EXPECT_EQ(two[1].id, 4294967295u);
    EXPECT_EQ(std::get<Unsubscribe>(read(R"({"op":"unsubscribe","subscriptionIds":[7,8]})")).ids,
              (std::vector<std::uint32_t>{7, 8}));
    const ClientMessage asked = read(R"({"op":"getParameters","parameterNames":["fc/220/A"],"id":"q"})");
    EXPECT_EQ(std::get<GetParameters>(asked).names, (std::vector<std::string>{"fc/220/A"}));
    EXPECT_EQ(std::get<GetParameters>(asked).id, "q");
    EXPECT_EQ(std::get<GetParameters>(read(R"({"op":"getParameters","parameterNames":[]})")).id, std::nullopt);
    EXPECT_FALSE(std::get<WatchParameters>(read(R"({"op":"subscribeParameterUpdates","parameterNames":["a"]})")).ends);
    EXPECT_TRUE(std::get<WatchParameters>(read(R"({"op":"unsubscribeParameterUpdates"})")).ends);
}

TEST(FoxgloveMessages, invalid_messages_are_rejected_with_an_explanation) {
    for (const std::string text : {"", "{", "\xff", "[1,2"})
        EXPECT_TRUE(wrong(text).starts_with("the message is not JSON: ")) << text;
    EXPECT_TRUE(wrong(std::string(65000, '[')).ends_with("nested deeper than 32 levels"));
    for (const std::string text : {"[]", "3", "{}", R"({"op":3})", "null"})
        EXPECT_EQ(wrong(text), "a message must be an object with 'op'") << text;
    EXPECT_EQ(wrong(R"({"op":"fly"})"), "unknown 'op' 'fly'");
    EXPECT_LT(wrong(R"({"op":")" + std::string(60000, 'x') + R"("})").size(), 400u);
    EXPECT_EQ(wrong(R"({"op":"subscribe"})"), "'subscribe' needs a list 'subscriptions'");
    const std::string bad = "a subscription needs 'id' and 'channelId', integers of at most 32 bits";
    for (const std::string one : {"3", "{}", R"({"id":1})", R"({"id":-1,"channelId":1})", R"({"id":1.5,"channelId":1})",
                                  R"({"id":4294967296,"channelId":1})", R"({"id":"1","channelId":1})"})
        EXPECT_EQ(wrong(R"({"op":"subscribe","subscriptions":[)" + one + "]}"), bad) << one;
    EXPECT_EQ(wrong(R"({"op":"unsubscribe","subscriptionIds":[null]})"), "'subscriptionIds' must be integers of at most 32 bits");
    EXPECT_EQ(wrong(R"({"op":"getParameters","parameterNames":[1]})"), "'parameterNames' must be a list of texts");
    EXPECT_EQ(wrong(R"({"op":"getParameters","id":7})"), "the 'id' of a request must be text of at most 256 bytes");
    EXPECT_EQ(wrong(R"({"op":"getParameters","id":")" + std::string(257, 'x') + R"("})"),
              "the 'id' of a request must be text of at most 256 bytes");
}

TEST(FoxgloveMessages, requests_to_write_are_rejected_as_unsupported) {
    for (const std::string op : {"setParameters", "advertise", "unadvertise"})
        EXPECT_EQ(wrong(R"({"op":")" + op + R"(","parameters":[{"name":"fc/220/A","value":1}]})"),
                  "'" + op + "' is not supported: this interface is read-only");
    const json info = json::parse(server_info({"anogate", "17"}));
    EXPECT_EQ(info.at("op"), "serverInfo");
    EXPECT_EQ(info.at("capabilities"), (json{"parameters", "parametersSubscribe"}));
    EXPECT_EQ(info.at("sessionId"), "17");
}

TEST(FoxgloveMessages, message_data_starts_with_the_subscription_and_the_time) {
    EXPECT_EQ(message_data(0x01020304, 0x1122334455667788, "ab"), "\x01\x04\x03\x02\x01\x88\x77\x66\x55\x44\x33\x22\x11"s + "ab");
    EXPECT_EQ(message_data(0, 0, "").size(), 13u);
}

TEST(FoxgloveMessages, floating_point_parameter_values_have_the_type_float64) {
    const Parameter all[] = {{"fc/220/A", "5.0"}, {"fc/220/B", "7"}, {"fc/220/C", R"("text")"}};
    const json told = json::parse(parameter_values(all, "q"));
    EXPECT_EQ(told.at("id"), "q");
    EXPECT_EQ(told.at("parameters"),
              json::parse(R"([{"name":"fc/220/A","value":5.0,"type":"float64"},{"name":"fc/220/B","value":7},
                                                     {"name":"fc/220/C","value":"text"}])"));
    EXPECT_FALSE(json::parse(parameter_values({}, std::nullopt)).contains("id"));
}

TEST(FoxgloveMessages, texts_are_valid_utf8_for_any_link_name) {
    const Channel channel{1, "/\xff/x", "cdr", "a/b", "text", "ros2msg"};
    const json told = json::parse(advertise({&channel, 1}));
    EXPECT_EQ(told.at("channels").at(0).at("topic"), "/\xEF\xBF\xBD/x");
    EXPECT_EQ(json::parse(status(Level::warning, "\xff")).at("level"), 1);
}

}    // namespace
}    // namespace anogate::foxglove::foxglove_messages_tests
