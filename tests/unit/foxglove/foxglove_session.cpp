#include <foxglove/foxglove_session.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <vector>

using namespace anogate;
using nlohmann::json;
using support::frame;

namespace foxglove_session_tests {
namespace {

const support::Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const support::Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

RecordedFrame recorded(const support::Bytes& bytes, std::string_view link = "fc", Direction direction = Direction::in) {
    RecordedFrame one{.link = link, .frame = ano::FrameView{bytes}};
    one.time_ns = 1700000000123456789;
    one.direction = direction;
    return one;
}

class FoxgloveSessionTest : public testing::Test {
protected:
    struct Heard {
        std::vector<json> texts;
        std::vector<std::string> data;
    };
    Heard all() {
        Heard heard;
        while (auto message = session.next()) {
            if (message->is_text) heard.texts.push_back(json::parse(message->data));
            else heard.data.push_back(std::move(message->data));
        }
        return heard;
    }
    std::vector<std::string> statuses() {
        std::vector<std::string> words;
        for (const json& text : all().texts)
            if (text.at("op") == "status") words.push_back(text.at("message"));
        return words;
    }
    /// The channels advertised from now on, by their topics.
    std::map<std::string, json> channels() {
        std::map<std::string, json> told;
        for (const json& text : all().texts)
            if (text.at("op") == "advertise")
                for (const json& channel : text.at("channels")) told[channel.at("topic")] = channel;
        return told;
    }
    void subscribe(unsigned id, unsigned channel) {
        session.receive(json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}.dump());
    }

    void learn(const RecordedFrame& frame) {
        if (const FirstFrame* const first = found.look_at(frame)) session.learn(*first);
    }

    FoundChannels found{DecodedEncoding::cdr, {}};
    FoxgloveSession session{{"anogate", "1"}, DecodedEncoding::cdr, {}};
};

TEST_F(FoxgloveSessionTest, a_new_client_receives_the_server_info_and_then_the_channels) {
    learn(recorded(euler));
    const auto texts = all().texts;
    ASSERT_EQ(texts.size(), 2u);
    EXPECT_EQ(texts[0].at("op"), "serverInfo");
    EXPECT_EQ(texts[1].at("op"), "advertise");
    const json& channels = texts[1].at("channels");
    ASSERT_GE(channels.size(), 2u);
    EXPECT_EQ(channels[0].at("topic"), "/anogate/frames");
    EXPECT_EQ(channels[1].at("topic"), "/fc/device_220/euler");
    EXPECT_EQ(channels[1].at("encoding"), "cdr");
    EXPECT_EQ(channels[1].at("schemaEncoding"), "ros2msg");
    EXPECT_NE(channels[1].at("schema"), "");
    EXPECT_NE(channels[0].at("id"), channels[1].at("id"));
    EXPECT_TRUE(all().texts.empty()) << "once";
}

TEST_F(FoxgloveSessionTest, a_channel_is_advertised_when_its_first_frame_is_seen) {
    EXPECT_EQ(channels().size(), 1u);
    learn(recorded(euler));
    learn(recorded(euler));
    EXPECT_TRUE(channels().contains("/fc/device_220/euler"));
    learn(recorded(wind, "ground"));
    const auto told = channels();
    EXPECT_TRUE(told.contains("/ground/device_221/wind"));
    EXPECT_FALSE(told.contains("/fc/device_220/euler"));
}

TEST_F(FoxgloveSessionTest, requests_no_frames_before_a_subscription) {
    learn(recorded(euler));
    EXPECT_FALSE(session.filter_has_changed());
    EXPECT_EQ(session.filter(), std::nullopt);
    all();
    session.show(recorded(euler));
    EXPECT_TRUE(all().data.empty());
}

TEST_F(FoxgloveSessionTest, only_subscribed_channels_are_requested_and_shown) {
    learn(recorded(euler));
    learn(recorded(wind));
    const unsigned channel = channels().at("/fc/device_220/euler").at("id");
    subscribe(7, channel);
    ASSERT_TRUE(session.filter_has_changed());
    const auto filter = session.pop_filter();
    EXPECT_FALSE(session.filter_has_changed());
    ASSERT_TRUE(filter);
    EXPECT_EQ(filter->ids.count(), 1u);
    EXPECT_TRUE(filter->ids[0x03]);
    EXPECT_EQ(filter->from.count(), 1u);
    EXPECT_TRUE(filter->from[0xDC]);
    EXPECT_EQ(filter->links, (std::vector<std::string>{"fc"}));
    EXPECT_EQ(filter->directions, (std::array<bool, 3>{true, false, false}));
    session.show(recorded(euler));
    session.show(recorded(wind));
    session.show(recorded(euler, "ground"));
    session.show(recorded(euler, "fc", Direction::out));
    const auto data = all().data;
    ASSERT_EQ(data.size(), 1u);
    EXPECT_EQ(data[0].substr(0, 13), foxglove::message_data(7, 1700000000123456789, ""));
    EXPECT_GT(data[0].size(), 13u + 4u);
}

TEST_F(FoxgloveSessionTest, frames_that_a_standard_message_also_needs_are_requested_with_it) {
    const support::Bytes inertial = frame(0xDC, 0xFF, 0x01, support::Bytes(13, 0));
    learn(recorded(euler));
    learn(recorded(inertial));
    learn(recorded(wind));
    const auto told = channels();
    ASSERT_TRUE(told.contains("/fc/device_220/imu"));
    subscribe(1, told.at("/fc/device_220/imu").at("id"));
    const auto filter = session.pop_filter();
    ASSERT_TRUE(filter);
    EXPECT_TRUE(filter->ids[0x01] && filter->ids[0x03]) << "its orientation is of euler";
    EXPECT_FALSE(filter->ids[0x09]);
    session.show(recorded(euler));
    EXPECT_TRUE(all().data.empty()) << "that is another channel";
    session.show(recorded(inertial));
    const auto data = all().data;
    ASSERT_EQ(data.size(), 1u);
    EXPECT_NE(data[0].find("fc/device_220"), std::string::npos);
}

TEST_F(FoxgloveSessionTest, links_with_similar_names_keep_the_topics_they_were_found_with) {
    learn(recorded(euler, "a-b"));
    learn(recorded(euler, "a_b"));
    std::map<std::string, json> told;
    for (const FirstFrame& first : found.first_frames())
        for (const FoundChannel& one : first.found()) told[one.channel->topic] = one.kind.link;
    const auto advertised = channels();
    for (auto one = told.rbegin(); one != told.rend(); ++one) {    // the one found last is shown first
        const auto& [topic, link] = *one;
        ASSERT_TRUE(advertised.contains(topic)) << topic;
        if (!topic.ends_with("/euler")) continue;
        subscribe(1, advertised.at(topic).at("id"));
        session.show(recorded(euler, link.get<std::string>()));
        EXPECT_EQ(all().data.size(), 1u) << topic;
        session.show(recorded(euler, link == "a-b" ? "a_b" : "a-b"));
        EXPECT_TRUE(all().data.empty()) << topic;
        session.receive(R"({"op":"unsubscribe","subscriptionIds":[1]})");
    }
}

TEST_F(FoxgloveSessionTest, channels_of_a_removed_link_are_unadvertised_and_advertised_again_with_it) {
    learn(recorded(euler));
    learn(recorded(wind, "ground"));
    const auto told = channels();
    const unsigned of_fc = told.at("/fc/device_220/euler").at("id"), of_ground = told.at("/ground/device_221/wind").at("id");
    subscribe(1, of_fc);
    subscribe(2, of_ground);
    session.pop_filter();
    found.forget("fc");
    session.forget("fc");
    auto texts = all().texts;
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_EQ(texts[0].at("op"), "unadvertise");
    json ids = json::array();
    for (const auto& [topic, channel] : told)
        if (topic.starts_with("/fc/")) ids.push_back(channel.at("id"));
    EXPECT_EQ(json(texts[0].at("channelIds")).size(), ids.size());
    for (const json& id : ids) EXPECT_TRUE(texts[0].at("channelIds").dump().find(id.dump()) != std::string::npos) << id;
    ASSERT_TRUE(session.filter_has_changed());
    EXPECT_EQ(session.pop_filter()->links, (std::vector<std::string>{"ground"}));
    session.show(recorded(euler));
    EXPECT_TRUE(all().data.empty()) << "it came before it was gone";
    session.show(recorded(wind, "ground"));
    EXPECT_EQ(all().data.size(), 1u);
    subscribe(3, of_fc);
    EXPECT_EQ(statuses(),
              (std::vector<std::string>{"channel " + std::to_string(of_fc) + " no longer exists because its link was removed"}));
    session.receive(R"({"op":"unsubscribe","subscriptionIds":[1]})");
    EXPECT_TRUE(statuses().empty()) << "he may end what he began";

    learn(recorded(euler));
    const auto again = channels();
    ASSERT_TRUE(again.contains("/fc/device_220/euler"));
    EXPECT_FALSE(again.contains("/ground/device_221/wind"));
    EXPECT_NE(again.at("/fc/device_220/euler").at("id"), of_fc);
    subscribe(4, again.at("/fc/device_220/euler").at("id"));
    session.show(recorded(euler));
    EXPECT_EQ(all().data.size(), 1u);
}

TEST_F(FoxgloveSessionTest, a_later_client_receives_no_channels_of_a_removed_link) {
    learn(recorded(euler));
    learn(recorded(wind, "ground"));
    found.forget("fc");
    FoxgloveSession later{{"anogate", "1"}, DecodedEncoding::cdr, {}};
    for (const FirstFrame& first : found.first_frames()) later.learn(first);
    std::string told;
    while (const auto message = later.next()) told += message->data;
    EXPECT_EQ(told.find("/fc/"), std::string::npos) << told;
    EXPECT_NE(told.find("/ground/device_221/wind"), std::string::npos) << told;
    EXPECT_EQ(told.find("unadvertise"), std::string::npos) << told;
}

TEST_F(FoxgloveSessionTest, a_flexible_message_with_another_layout_is_another_channel) {
    const auto with = [](const char* name) {
        return std::make_shared<const Decoding>(
            std::vector{ano::FlexibleSpec{.id = 0xF1, .fields = {{name, ano::Type::u8, 1, ""}}}});
    };
    const auto use = [&](const DecodingPtr& decoding) {
        found.use(decoding);
        session.use(decoding);
    };
    const support::Bytes flexible = support::frame(0xDC, 0xFE, 0xF1, {7});
    learn(recorded(euler));
    use(with("a"));
    learn(recorded(flexible));
    const auto first = channels();
    ASSERT_TRUE(first.contains("/fc/device_220/flexible1"));
    EXPECT_NE(first.at("/fc/device_220/flexible1").at("schema").get<std::string>().find("uint8 a"), std::string::npos);
    use(with("b"));
    bool is_unadvertised = false;
    for (const json& text : all().texts) is_unadvertised = is_unadvertised || text.at("op") == "unadvertise";
    EXPECT_TRUE(is_unadvertised);
    learn(recorded(euler));
    learn(recorded(flexible));
    const auto second = channels();
    ASSERT_TRUE(second.contains("/fc/device_220/flexible1"));
    EXPECT_NE(second.at("/fc/device_220/flexible1").at("schema").get<std::string>().find("uint8 b"), std::string::npos);
    EXPECT_FALSE(second.contains("/fc/device_220/euler")) << "others stay";
    subscribe(5, second.at("/fc/device_220/flexible1").at("id"));
    session.show(recorded(flexible));
    EXPECT_EQ(all().data.size(), 1u);
}

TEST_F(FoxgloveSessionTest, channels_that_were_not_advertised_yet_are_not_unadvertised) {
    learn(recorded(euler));
    session.forget("fc");
    for (const json& text : all().texts) {
        EXPECT_NE(text.at("op"), "unadvertise");
        EXPECT_EQ(text.dump().find("/fc/"), std::string::npos) << text;
    }
}

TEST_F(FoxgloveSessionTest, whole_frames_form_one_channel_whether_forwarded_or_dropped) {
    const unsigned channel = channels().at("/anogate/frames").at("id");
    subscribe(1, channel);
    FrameFilterSettings whole;
    whole.elsewhere = false;    // frames that another sender sends with the address of a device are not shown
    EXPECT_EQ(session.pop_filter(), whole);
    session.show(recorded(euler, "fc", Direction::out));
    const auto data = all().data;
    ASSERT_EQ(data.size(), 1u);
    EXPECT_NE(data[0].find(std::string{euler.begin(), euler.end()}), std::string::npos);
    EXPECT_EQ(data[0].substr(13, 4), (std::string{"\0\1\0\0", 4})) << "CDR, little endian";
    EXPECT_NE(data[0].find(std::string{"\3\0\0\0fc\0", 7}), std::string::npos);
}

TEST_F(FoxgloveSessionTest, requests_no_frames_after_unsubscribing) {
    learn(recorded(euler));
    const unsigned channel = channels().at("/fc/device_220/euler").at("id");
    subscribe(7, channel);
    session.pop_filter();
    session.receive(R"({"op":"unsubscribe","subscriptionIds":[7]})");
    EXPECT_TRUE(session.filter_has_changed());
    EXPECT_EQ(session.pop_filter(), std::nullopt);
    session.show(recorded(euler));
    EXPECT_TRUE(all().data.empty());
    subscribe(7, channel);
    session.show(recorded(euler));
    EXPECT_EQ(all().data.size(), 1u) << "the number is free again";
}

TEST_F(FoxgloveSessionTest, invalid_subscriptions_are_errors_and_change_nothing) {
    learn(recorded(euler));
    learn(recorded(wind));
    const auto told = channels();
    const unsigned one = told.at("/fc/device_220/euler").at("id"), other = told.at("/fc/device_221/wind").at("id");
    subscribe(7, one);
    subscribe(7, other);
    subscribe(8, one);
    subscribe(9, 4000000000);
    subscribe(9, 0);
    session.receive(R"({"op":"unsubscribe","subscriptionIds":[8]})");
    EXPECT_EQ(statuses(), (std::vector<std::string>{"the subscription id 7 is already in use",
                                                    "channel " + std::to_string(one) + " is already subscribed with id 7",
                                                    "unknown channel 4000000000: it was not advertised",
                                                    "unknown channel 0: it was not advertised", "unknown subscription 8"}));
    session.show(recorded(wind));
    EXPECT_TRUE(all().data.empty());
    session.show(recorded(euler));
    EXPECT_EQ(all().data.size(), 1u);
}

TEST_F(FoxgloveSessionTest, of_a_thousand_errors_some_are_reported_and_the_rest_counted) {
    all();
    json many = json::array();
    for (unsigned i = 0; i < 1000; ++i) many.push_back({{"id", i}, {"channelId", 77}});
    session.receive(json{{"op", "subscribe"}, {"subscriptions", many}}.dump());
    const auto words = statuses();
    ASSERT_EQ(words.size(), FoxgloveSession::max_statuses + 1);
    EXPECT_EQ(words.back(), std::to_string(1000 - FoxgloveSession::max_statuses) + " more errors are not reported individually");
}

TEST_F(FoxgloveSessionTest, dropped_frames_are_reported_per_message) {
    all();
    LostFrames lost;
    lost.by_id[0x03] = 120;
    lost.by_id[0x09] = 3;
    lost.count = 123;
    lost.since = std::chrono::milliseconds{500};
    session.lose(lost);
    const auto texts = all().texts;
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_EQ(texts[0].at("level"), 1);
    EXPECT_EQ(texts[0].at("message"),
              "123 frames of the last 500 ms were dropped: the client reads too slowly: euler 120, wind 3");
}

TEST_F(FoxgloveSessionTest, binary_and_invalid_messages_get_error_responses) {
    all();
    session.receive_binary();
    session.receive("nonsense");
    session.receive(R"({"op":"setParameters","parameters":[]})");
    const auto texts = all().texts;
    ASSERT_EQ(texts.size(), 3u);
    for (const json& text : texts) EXPECT_EQ(text.at("level"), 2) << text;
}

TEST_F(FoxgloveSessionTest, parameter_requests_are_forwarded_and_answered_with_their_id) {
    all();
    session.receive(R"({"op":"getParameters","parameterNames":["fc/220/A"],"id":"first"})");
    const auto question = session.next_question();
    ASSERT_TRUE(question);
    EXPECT_EQ(question->names, (std::vector<std::string>{"fc/220/A"}));
    EXPECT_EQ(session.next_question(), std::nullopt);
    session.answer(*question, {{"fc/220/A", "1.5"}});
    const auto texts = all().texts;
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_EQ(
        texts[0],
        json::parse(R"({"op":"parameterValues","parameters":[{"name":"fc/220/A","value":1.5,"type":"float64"}],"id":"first"})"));
}

TEST_F(FoxgloveSessionTest, requests_beyond_the_limit_of_waiting_ones_are_rejected) {
    all();
    for (std::size_t i = 0; i < FoxgloveSession::max_questions + 3; ++i) session.receive(R"({"op":"getParameters"})");
    std::vector<foxglove::GetParameters> questions;
    while (auto question = session.next_question()) questions.push_back(std::move(*question));
    EXPECT_EQ(questions.size(), FoxgloveSession::max_questions);
    EXPECT_EQ(statuses().size(), 3u);
    session.answer(questions.front(), {});
    session.receive(R"({"op":"getParameters"})");
    EXPECT_FALSE(session.next_question()) << "he has not taken the answer: many would fill the memory";
    EXPECT_EQ(all().texts.size(), 2u) << "and that it is refused";
    session.receive(R"({"op":"getParameters"})");
    EXPECT_TRUE(session.next_question()) << "an answer that is taken makes room";
}

TEST_F(FoxgloveSessionTest, names_too_long_for_a_parameter_are_not_stored) {
    all();
    const std::string longest(FoxgloveSession::max_watched_name, 'x');
    const auto watch = [&](const std::string& name) {
        session.receive(json{{"op", "subscribeParameterUpdates"}, {"parameterNames", json::array({name})}}.dump());
    };
    watch(longest);
    watch(longest + "x");
    session.changed({{longest, "1"}, {longest + "x", "2"}});
    const auto texts = all().texts;
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_EQ(texts[0].at("parameters").size(), 1u);
}

TEST_F(FoxgloveSessionTest, changes_of_watched_parameters_are_reported_with_their_latest_values) {
    all();
    session.changed({{"fc/220/A", "1"}});
    EXPECT_TRUE(all().texts.empty());
    session.receive(R"({"op":"subscribeParameterUpdates","parameterNames":["fc/220/A"]})");
    session.changed({{"fc/220/A", "1"}, {"fc/220/B", "2"}});
    session.changed({{"fc/220/A", "3"}});
    auto texts = all().texts;
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_EQ(texts[0].at("parameters"), json::parse(R"([{"name":"fc/220/A","value":3}])"));
    session.receive(R"({"op":"subscribeParameterUpdates","parameterNames":[]})");
    session.changed({{"fc/220/B", "2"}});
    EXPECT_EQ(all().texts.size(), 1u) << "none is all";
    session.receive(R"({"op":"unsubscribeParameterUpdates","parameterNames":[]})");
    session.changed({{"fc/220/A", "1"}, {"fc/220/B", "2"}});
    EXPECT_TRUE(all().texts.empty());
}

TEST_F(FoxgloveSessionTest, many_channels_are_advertised_in_messages_of_bounded_size) {
    for (const std::string_view link : {"a", "b", "c", "d"})
        for (unsigned source = 1; source < 200; ++source) {
            const support::Bytes bytes = frame(static_cast<std::uint8_t>(source), 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 1});
            learn(recorded(bytes, link));
        }
    std::size_t told = 0, messages = 0;
    while (const auto message = session.next()) {
        ASSERT_TRUE(message->is_text);
        EXPECT_LT(message->data.size(), 2 * FoxgloveSession::part_size);
        const json text = json::parse(message->data);
        if (text.at("op") == "advertise") told += text.at("channels").size(), ++messages;
    }
    EXPECT_GE(told, 4 * 199u + 1);
    EXPECT_GT(messages, 1u);
}

}    // namespace
}    // namespace foxglove_session_tests
