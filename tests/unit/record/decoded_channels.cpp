#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <record/decoded_channels.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <support/bytes.hpp>
#include <support/vectors.hpp>

namespace decoded_channels_tests {
namespace {

using namespace anogate;
using support::Bytes;

const Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0x29, 0xEE, 0, 0, 1});

RecordedFrame passed(const Bytes& frame, std::string_view link = "fc", Direction direction = Direction::in) {
    return {.time_ns = 1'763'898'044'123'456'789, .link = link, .direction = direction, .frame = ano::FrameView{frame}};
}

std::string bytes(std::string_view digits) {
    const Bytes data = support::hex(digits);
    return {data.begin(), data.end()};
}

/// The topics of its decoded messages.
std::vector<std::string> topics_of(DecodedChannels& decoded, const RecordedFrame& frame) {
    std::vector<std::string> topics;
    for (const DecodedMessage& message : decoded.decode(frame)) topics.push_back(decoded.channels()[message.channel].topic);
    return topics;
}

/// The lines of a definition that are not comments.
std::string without_comments(const std::string& text) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string line = text.substr(at, end - at);
        line.erase(std::min(line.find('#'), line.size()));
        while (!line.empty() && line.back() == ' ') line.pop_back();
        if (!line.empty()) out += line + '\n';
        at = end + 1;
    }
    return out;
}

std::string definition_of_message(const Bytes& frame) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    const auto messages = decoded.decode(passed(frame));
    return messages.empty() ? "" : without_comments(decoded.schemas()[decoded.channels()[messages[0].channel].schema].text);
}

TEST(DecodedChannels, a_message_has_one_channel_per_device_and_one_common_schema) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    EXPECT_EQ(topics_of(decoded, passed(euler)).front(), "/fc/device_220/euler");
    EXPECT_EQ(topics_of(decoded, passed(euler, "radio")).front(), "/radio/device_220/euler");
    const std::size_t channels = decoded.channels().size();
    EXPECT_EQ(topics_of(decoded, passed(euler)).front(), "/fc/device_220/euler");
    EXPECT_EQ(decoded.channels().size(), channels);
    EXPECT_EQ(decoded.schemas()[0].name, "ano_msgs/msg/Euler");
    EXPECT_EQ(decoded.schemas()[0].encoding, "ros2msg");
}

TEST(DecodedChannels, values_are_in_their_units) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    EXPECT_EQ(definition_of_message(euler), "float64 rol\nfloat64 pit\nfloat64 yaw\nuint8 fusion_sta\nfloat64 mode\n");
    // 1.23, -45.67, 0, 1, no mode
    EXPECT_EQ(decoded.decode(passed(euler))[0].data,
              bytes("00 01 00 00  AE 47 E1 7A 14 AE F3 3F  F6 28 5C 8F C2 D5 46 C0  00 00 00 00 00 00 00 00  01 "
                    "00 00 00 00 00 00 00  00 00 00 00 00 00 F8 7F"));
}

TEST(DecodedChannels, fields_missing_in_a_layout_can_be_empty) {
    const Bytes compass = support::frame(0xDC, 0xFE, 0x02, {1, 0, 2, 0, 3, 0, 0xFD, 0, 1});
    EXPECT_EQ(definition_of_message(compass),
              "int16 mag_x\nint16 mag_y\nint16 mag_z\nfloat64 tmp\nuint8 mag_sta\nfloat64 alt_bar\nfloat64 bar_sta\n");
    DecodedChannels decoded{DecodedEncoding::cdr};
    // NaN for alt_bar and bar_sta.
    EXPECT_EQ(decoded.decode(passed(compass))[0].data,
              bytes("00 01 00 00  01 00 02 00 03 00 00 00  CD CC CC CC CC 4C 39 40  01 00 00 00 "
                    "00 00 00 00  00 00 00 00 00 00 F8 7F  00 00 00 00 00 00 F8 7F"));
}

TEST(DecodedChannels, a_field_with_two_units_becomes_two_fields) {
    EXPECT_EQ(
        definition_of_message(support::frame(1, 2, 0x34, {1, 0, 0, 0, 0})),
        "float64 type\nfloat64 dist\nano_msgs/RangingPoint[] points\nfloat64 direction\nfloat64 angle\nfloat64 dist_field\n" +
            std::string(80, '=') + "\nMSG: ano_msgs/RangingPoint\nfloat64 angle\nuint16 dist\n");
}

TEST(DecodedChannels, meanings_are_constants_before_their_field) {
    EXPECT_EQ(
        definition_of_message(support::frame(1, 2, 0x06, {0, 0, 0, 0, 0})),
        "uint8 mode\nuint8 SFLAG_LOCKED=0\nuint8 SFLAG_UNLOCKED=1\nuint8 SFLAG_AIRBORNE=2\nuint8 sflag\nuint8 cid\nuint8 cmd0\n"
        "uint8 cmd1\n");
}

TEST(DecodedChannels, text_that_is_not_utf8_is_converted_to_utf8) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    EXPECT_EQ(decoded.decode(passed(support::frame(1, 2, 0xA0, {1, 'a', 0xFF, 'b', 0, 'c'})))[0].data,
              bytes("00 01 00 00  01 00 00 00 06 00 00 00 61 EF BF BD 62 00"));
}

TEST(DecodedChannels, sent_and_dropped_frames_are_not_decoded_again) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    EXPECT_TRUE(decoded.decode(passed(euler, "fc", Direction::out)).empty());
    EXPECT_TRUE(decoded.decode(passed(euler, "fc", Direction::dropped)).empty());
    EXPECT_TRUE(decoded.channels().empty());
}

TEST(DecodedChannels, frames_that_the_table_does_not_describe_are_not_decoded) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x77, {1, 2}))).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x03, {1, 2}))).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0xF1, {1, 2}))).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x51, {9, 2, 3, 4, 5, 6, 7, 8}))).empty());
    for (const std::size_t size : {9u, 10u, 20u})
        EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x03, Bytes(size)))).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x03, {2, 0x7B, 0, 0x29, 0xEE, 0, 0, 1}))).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(1, 2, 0x02, Bytes(10)))).empty());
    EXPECT_TRUE(decoded.channels().empty());
    EXPECT_TRUE(decoded.schemas().empty());
}

TEST(DecodedChannels, link_names_become_valid_ros_names) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    const auto topic = [&](std::string_view link) { return topics_of(decoded, passed(euler, link)).front(); };
    EXPECT_EQ(topic("fc-1"), "/fc_1/device_220/euler");
    EXPECT_EQ(topic("fc_1"), "/fc_1_2/device_220/euler");
    EXPECT_EQ(topic("fc-1"), "/fc_1/device_220/euler");
    EXPECT_EQ(topic("9/../9\n"), "/link_9_9/device_220/euler");
    EXPECT_EQ(topic("温度"), "/link/device_220/euler");
    EXPECT_EQ(topic(""), "/link_2/device_220/euler");
    EXPECT_EQ(topic("__Fc__"), "/Fc/device_220/euler");
    EXPECT_EQ(topic(std::string(1000, 'x')), '/' + std::string(64, 'x') + "/device_220/euler");
}

TEST(DecodedChannels, are_limited_in_number) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    for (int i = 0; i < 5000; ++i) decoded.decode(passed(euler, "link " + std::to_string(i)));
    EXPECT_EQ(decoded.channels().size(), DecodedChannels::max_channels);
    EXPECT_FALSE(decoded.decode(passed(euler, "link 0")).empty());
    EXPECT_TRUE(decoded.decode(passed(euler, "link 4999")).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(0xDC, 0xFE, 0x06, {0, 0, 0, 0, 0}), "link 0")).empty());
    EXPECT_TRUE(decoded.decode(passed(support::frame(0x05, 0xFE, 0x06, {0, 0, 0, 0, 0}), "link 0")).empty());
    EXPECT_EQ(decoded.channels().size(), DecodedChannels::max_channels);
}

TEST(DecodedChannels, json_contains_the_fields_as_decode_shows_them) {
    DecodedChannels decoded{DecodedEncoding::json};
    EXPECT_EQ(decoded.decode(passed(euler))[0].data, R"({"rol":1.23,"pit":-45.67,"yaw":0.0,"fusion_sta":1})");
    EXPECT_EQ(decoded.schemas()[0].encoding, "jsonschema");
    EXPECT_EQ(decoded.schemas()[0].name, "ano_msgs/msg/Euler");
    EXPECT_EQ(decoded.channels()[0].topic, "/fc/device_220/euler");
    // pos_y is "no data"
    const Bytes position = support::frame(1, 2, 0x32, {1, 0, 0, 0, 0, 0, 0, 0x80, 0xFD, 0xFF, 0xFF, 0xFF});
    EXPECT_EQ(decoded.decode(passed(position))[0].data, R"({"pos_x":1,"pos_z":-3})");
}

bool has_what_its_schema_says(const ano::Json& object, const ano::Json& schema);

bool is_of_type(const ano::Json& value, const ano::Json& schema) {
    const auto type = schema["type"].get<std::string>();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "array")
        return value.is_array() &&
               std::all_of(value.begin(), value.end(), [&](const auto& v) { return is_of_type(v, schema["items"]); });
    return type == "object" && has_what_its_schema_says(value, schema);
}

// A schema without properties permits any.
bool has_what_its_schema_says(const ano::Json& object, const ano::Json& schema) {
    if (!object.is_object() || schema["type"] != "object" || !schema["properties"].is_object()) return false;
    const ano::Json& known = schema["properties"];
    return known.empty() || std::all_of(object.items().begin(), object.items().end(), [&](const auto& item) {
               return known.contains(item.key()) && is_of_type(item.value(), known[item.key()]);
           });
}

TEST(DecodedChannels, standard_messages_accompany_the_decoded_ones_in_both_encodings) {
    DecodedChannels cdr{DecodedEncoding::cdr}, json{DecodedEncoding::json};
    EXPECT_EQ(topics_of(json, passed(euler)), topics_of(cdr, passed(euler)));
    const Bytes compass = support::frame(0xDC, 0xFE, 0x02, {1, 0, 2, 0, 3, 0, 0xFD, 0, 1});
    EXPECT_EQ(topics_of(json, passed(compass)), topics_of(cdr, passed(compass)));
    EXPECT_EQ(
        topics_of(json, passed(compass)),
        (std::vector<std::string>{"/fc/device_220/compass", "/fc/device_220/magnetic_field", "/fc/device_220/temperature"}));
    const auto messages = json.decode(passed(compass));
    EXPECT_EQ(messages[2].data, R"({"header":{"stamp":{"sec":1763898044,"nanosec":123456789},"frame_id":"fc/device_220"},)"
                                R"("temperature":25.3,"variance":0.0})");
    const DecodedSchema& schema = json.schemas()[json.channels()[messages[1].channel].schema];
    EXPECT_EQ(schema.name, "sensor_msgs/msg/MagneticField");
    EXPECT_EQ(schema.encoding, "jsonschema");
}

TEST(DecodedChannels, every_json_matches_its_schema) {
    for (const support::Vector& vector : support::golden_vectors()) {
        DecodedChannels decoded{DecodedEncoding::json};
        const auto messages = decoded.decode(passed(vector.bytes));
        ASSERT_EQ(!messages.empty(), vector.json.contains("fields")) << vector.name;
        if (messages.empty()) continue;
        for (const DecodedMessage& message : messages) {    // the standard ones as well
            const ano::Json told = ano::Json::parse(message.data);
            const ano::Json schema = ano::Json::parse(decoded.schemas()[decoded.channels()[message.channel].schema].text);
            EXPECT_TRUE(has_what_its_schema_says(told, schema)) << vector.name << " " << told << " " << schema;
        }
        const ano::Json json = ano::Json::parse(messages[0].data);
        for (const auto& [key, value] : vector.json["fields"].items()) {
            if (value.is_null()) {
                EXPECT_FALSE(json.contains(key)) << vector.name << " " << key;
            } else if (vector.name == "log in GBK" && key == "str") {
                EXPECT_EQ(json[key], "\u89e3\u9501");    // texts in recordings are converted for people, in JSON as in CDR
            } else {
                EXPECT_EQ(json[key], value) << vector.name << " " << key;
            }
        }
    }
}

DecodingPtr decoding(std::vector<ano::FlexibleSpec> flexible, std::set<std::string, std::less<>> lx = {}) {
    return std::make_shared<const Decoding>(std::move(flexible), std::move(lx));
}

TEST(DecodedChannels, flexible_messages_have_a_channel_for_each_value_of_their_first_field) {
    const ano::FlexibleField kind{"kind", ano::Type::u8, 1, ""};
    DecodedChannels decoded{
        DecodedEncoding::cdr,
        decoding({{.id = 0xF1, .fields = {kind, {"a", ano::Type::u16, 1, "", 2}}, .endian = ano::ByteOrder::big, .when = 3},
                  {.id = 0xF1, .fields = {kind, {"b", ano::Type::u8, 1, ""}}, .when = 4}})};
    const Bytes three = support::frame(5, 0xFE, 0xF1, {3, 1, 2, 3, 4}), four = support::frame(5, 0xFE, 0xF1, {4, 9});
    EXPECT_EQ(topics_of(decoded, passed(three)), std::vector<std::string>{"/fc/device_5/flexible1_when_3"});
    EXPECT_EQ(topics_of(decoded, passed(four)), std::vector<std::string>{"/fc/device_5/flexible1_when_4"});
    EXPECT_EQ(decoded.schemas()[0].name, "ano_msgs/msg/Flexible1When3");
    EXPECT_EQ(without_comments(decoded.schemas()[0].text), "uint8 kind\nuint16[2] a\n");
    EXPECT_EQ(decoded.decode(passed(three))[0].data, bytes("00 01 00 00  03 00 02 01 04 03"));
    EXPECT_EQ(decoded.channels().size(), 2u);
    EXPECT_TRUE(decoded.decode(passed(support::frame(5, 0xFE, 0xF1, {5, 9}))).empty());
}

TEST(DecodedChannels, changed_layouts_create_new_channels) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    const Bytes frame = support::frame(5, 0xFE, 0xF1, {7, 1});
    EXPECT_TRUE(decoded.decode(passed(frame)).empty());
    EXPECT_EQ(topics_of(decoded, passed(euler)).front(), "/fc/device_220/euler");
    const std::size_t channels = decoded.channels().size();
    decoded.use(decoding({{.id = 0xF1, .fields = {{"a", ano::Type::u8, 1, ""}}}}));
    EXPECT_EQ(decoded.decode(passed(frame))[0].data, bytes("00 01 00 00  07"));
    decoded.use(decoding({{.id = 0xF1, .fields = {{"a", ano::Type::u8, 1, ""}}}}));
    EXPECT_EQ(decoded.decode(passed(frame))[0].channel, channels) << "the same layouts";
    decoded.use(decoding({{.id = 0xF1, .fields = {{"b", ano::Type::u16, 1, ""}}}}));
    EXPECT_EQ(decoded.decode(passed(frame))[0].channel, channels + 1);
    EXPECT_EQ(decoded.decode(passed(frame))[0].data, bytes("00 01 00 00  07 01"));
    EXPECT_EQ(decoded.channels()[channels + 1].topic, decoded.channels()[channels].topic);
    EXPECT_EQ(topics_of(decoded, passed(euler)).front(), "/fc/device_220/euler");
    EXPECT_EQ(decoded.channels().size(), channels + 2) << "other messages keep their channels";
}

// One orientation of a device, for any of its frames.
TEST(DecodedChannels, euler_angles_of_lx_units_and_their_quaternion_are_one_orientation) {
    const Bytes angles = support::frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0x28, 0x23, 1});                    // yaw 90°
    const Bytes quaternion = support::frame(0xDD, 0xFE, 0x04, {0x9F, 0x1B, 0, 0, 0, 0, 0x61, 0xE4, 1});    // yaw -90°
    const auto orientation = [](DecodedChannels& decoded, const Bytes& frame, std::string_view link) {
        for (const DecodedMessage& message : decoded.decode(passed(frame, link)))
            if (decoded.channels()[message.channel].topic.ends_with("/orientation"))
                return ano::Json::parse(message.data)["quaternion"]["z"].get<double>();
        return 0.0;
    };
    DecodedChannels decoded{DecodedEncoding::json, decoding({}, {"lx"})};
    EXPECT_NEAR(orientation(decoded, angles, "lx"), -std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(orientation(decoded, quaternion, "lx"), -std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(orientation(decoded, angles, "other"), std::sqrt(0.5), 1e-6);
    decoded.use(decoding({}, {"other"}));
    DecodedChannels before{DecodedEncoding::json};
    EXPECT_NEAR(orientation(before, angles, "fc"), std::sqrt(0.5), 1e-6);
    before.use(decoding({}, {"fc"}));
    EXPECT_NEAR(orientation(before, angles, "fc"), -std::sqrt(0.5), 1e-6) << "also of a device that was heard before";
}

TEST(DecodedChannels, flexible_messages_have_their_layout) {
    const std::vector<ano::FlexibleField> all{
        {"温度", ano::Type::i16, 0.1, "°C\nuint8 x"}, {"Volt.age", ano::Type::f32, 1, "V"}, {"volt age", ano::Type::u8, 1, ""}};
    const std::vector<ano::FlexibleField> own{{"x", ano::Type::u8, 1, ""}};
    DecodedChannels decoded{DecodedEncoding::cdr,
                            decoding({{.id = 0xF1, .fields = all}, {.id = 0xF1, .source = 220, .fields = own}})};
    const Bytes frame = support::frame(5, 0xFE, 0xF1, {0x0A, 0, 0, 0, 0x80, 0x3F, 7});
    EXPECT_EQ(decoded.decode(passed(frame))[0].data, bytes("00 01 00 00  00 00 00 00 00 00 F0 3F  00 00 80 3F  07"));
    EXPECT_EQ(decoded.schemas()[0].name, "ano_msgs/msg/Flexible1");
    EXPECT_EQ(without_comments(decoded.schemas()[0].text), "float64 value\nfloat32 volt_age\nuint8 volt_age_2\n");
    EXPECT_EQ(decoded.decode(passed(support::frame(220, 0xFE, 0xF1, {7})))[0].data, bytes("00 01 00 00 07"));
    EXPECT_EQ(decoded.schemas()[1].name, "ano_msgs/msg/Flexible1From220");
    EXPECT_EQ(decoded.channels()[1].topic, "/fc/device_220/flexible1");
    EXPECT_TRUE(decoded.decode(passed(support::frame(6, 0xFE, 0xF1, {7}))).empty());    // too short
}

}    // namespace
}    // namespace decoded_channels_tests
