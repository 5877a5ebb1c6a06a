#include <ros/ros_json.hpp>

#include <ros/value_list.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <support/bytes.hpp>

namespace ros_json_tests {
namespace {

using namespace anogate;
using Shape = RosField::Shape;
using nlohmann::json;

RosMessage message_of(std::vector<RosField> fields) {
    return {.package = "a_msgs", .name = "Any", .comment = {}, .fields = std::move(fields)};
}

std::string ros_json(const RosMessage& message, std::span<const ano::Value> values) {
    std::string text;
    write_ros_json(message, values, text);
    return text;
}

RosField field(RosType type, const char* name, Shape shape = Shape::one, std::size_t count = 1) {
    return {.type = type, .name = name, .shape = shape, .count = count};
}

TEST(RosJson, has_the_names_of_the_definition_in_its_order) {
    const RosMessage inner = message_of({field(RosType::int32, "sec"), field(RosType::text, "frame_id")});
    RosField header = field(RosType::message, "header");
    header.message = &inner;
    const RosMessage message = message_of({header, field(RosType::boolean, "present"), field(RosType::float64, "voltage")});
    ValueList values;
    values.push(ano::Value{std::int64_t{-3}});
    values.push(ano::Value{std::string_view{"fc"}});
    values.push(ano::Value{std::uint64_t{1}});
    values.push(12.5);
    EXPECT_EQ(ros_json(message, values.values()), R"({"header":{"sec":-3,"frame_id":"fc"},"present":true,"voltage":12.5})");
}

TEST(RosJson, omits_values_that_are_not_finite_numbers) {
    const RosMessage message = message_of(
        {field(RosType::float32, "a"), field(RosType::float64, "b"), field(RosType::uint8, "c")});
    ValueList values;
    values.push(std::nan(""));
    values.push(std::numeric_limits<double>::infinity());
    values.push(ano::Value{ano::Nothing{}});
    EXPECT_EQ(ros_json(message, values.values()), "{}");
    EXPECT_EQ(ros_json(message, {}), "{}");
}

TEST(RosJson, bytes_are_base64) {
    const RosMessage message = message_of({field(RosType::uint8, "data", Shape::sequence)});
    const auto told = [&](const support::Bytes& bytes) {
        ValueList values;
        values.push(ano::Value{ano::Bytes{bytes}});
        return json::parse(ros_json(message, values.values())).at("data").get<std::string>();
    };
    // RFC 4648, section 10
    EXPECT_EQ(told({}), "");
    EXPECT_EQ(told({'f'}), "Zg==");
    EXPECT_EQ(told({'f', 'o'}), "Zm8=");
    EXPECT_EQ(told({'f', 'o', 'o'}), "Zm9v");
    EXPECT_EQ(told({'f', 'o', 'o', 'b', 'a', 'r'}), "Zm9vYmFy");
    EXPECT_EQ(told({0xFB, 0xFF, 0xBF}), "+/+/");
}

TEST(RosJson, arrays_contain_the_given_numbers_and_sequences_as_many_as_counted) {
    const RosMessage message = message_of(
        {field(RosType::float64, "covariance", Shape::array, 2), field(RosType::uint32, "n", Shape::sequence)});
    support::Bytes raw(16);
    ano::store(raw.data(), 1.5);
    ano::store(raw.data() + 8, -1.0);
    ValueList values;
    values.push(ano::Value{ano::Bytes{raw}});
    values.push_count(2);
    for (const std::uint64_t n : {7u, 8u}) values.push(ano::Value{n});
    EXPECT_EQ(ros_json(message, values.values()), R"({"covariance":[1.5,-1.0],"n":[7,8]})");
    ValueList short_of;
    short_of.push(ano::Value{ano::Bytes{raw}.first(8)});
    short_of.push_count(1000);
    EXPECT_EQ(ros_json(message, short_of.values()), R"({"covariance":[1.5],"n":[]})");
}

TEST(RosJson, its_schema_contains_types_constants_and_comments) {
    const RosMessage inner = message_of({field(RosType::float32, "x")});
    RosField list = field(RosType::message, "points", Shape::sequence);
    list.message = &inner;
    RosField kind = field(RosType::uint8, "kind");
    kind.constants = {{"UNKNOWN", 0}, {"LASER", 1}};
    kind.comment = "of the sensor";
    const RosMessage message = message_of(
        {kind, list, field(RosType::uint8, "data", Shape::sequence), field(RosType::boolean, "ok")});
    EXPECT_EQ(json::parse(ros_json_schema(message)), json::parse(R"({"title": "a_msgs/msg/Any", "type": "object", "properties": {
        "kind": {"type": "integer", "description": "of the sensor; 0: UNKNOWN; 1: LASER"},
        "points": {"type": "array", "items": {"title": "a_msgs/msg/Any", "type": "object", "properties": {"x": {"type": "number"}}}},
        "data": {"type": "string", "contentEncoding": "base64"},
        "ok": {"type": "boolean"}}})"));
}

}    // namespace
}    // namespace ros_json_tests
