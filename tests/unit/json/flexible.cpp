#include <gtest/gtest.h>
#include <ano_json/flexible_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <string>
#include <variant>
#include <vector>

#include <support/bytes.hpp>

namespace flexible_tests {
namespace {

using namespace ano;

std::vector<std::string> faults_of(const char* text) {
    FlexibleLayouts layouts;
    std::vector<std::string> lines;
    for (const JsonFault& f : add_flexible(nlohmann::json::parse(text), "/flexible", layouts))
        lines.push_back(f.pointer + ": " + f.what);
    return lines;
}
using Lines = std::vector<std::string>;

// `count` layouts of one id, selected by the first field.
FlexibleLayouts layouts_by_kind(unsigned count) {
    FlexibleLayouts layouts;
    for (unsigned kind = 0; kind < count; ++kind)
        EXPECT_FALSE(
            layouts.add({.id = 0xF1,
                         .fields = {{"kind", Type::u8, 1, "", 1}, {"a", Type::i16, 0.01, "", 1}, {"b", Type::i16, 1, "", 1}},
                         .when = kind}));
    return layouts;
}

// Each client that watches JSON does this for each frame. The minimum of many rounds, since other processes use the machine too.
std::chrono::nanoseconds time_of_a_frame(const FlexibleLayouts& layouts) {
    const auto bytes = support::frame(5, 254, 0xF1, {0, 7, 0, 9, 0});
    const JsonOptions options{&layouts, Encoding::utf8};
    auto least = std::chrono::nanoseconds::max();
    for (int round = 0; round < 20; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        for (int i = 0; i < 20; ++i) EXPECT_EQ(frame_to_json(FrameView{bytes}, options).count("data"), 0u);
        least = std::min<std::chrono::nanoseconds>(least, (std::chrono::steady_clock::now() - begin) / 20);
    }
    return least;
}

TEST(FlexibleJson, a_frame_takes_no_longer_where_its_id_has_256_layouts) {
    const auto one = time_of_a_frame(layouts_by_kind(1)), all = time_of_a_frame(layouts_by_kind(256));
    RecordProperty("with_1_ns", std::to_string(one.count()));
    RecordProperty("with_256_ns", std::to_string(all.count()));
    EXPECT_LE(all, 20 * one) << "looked through one by one it would be some 200 times as long";
}

TEST(FlexibleJson, the_first_field_selects_one_of_256_layouts) {
    const FlexibleLayouts layouts = layouts_by_kind(256);
    const JsonOptions options{&layouts, Encoding::utf8};
    for (const std::uint8_t kind : std::initializer_list<std::uint8_t>{0, 1, 127, 255}) {
        const auto bytes = support::frame(5, 254, 0xF1, {kind, 7, 0, 9, 0});
        Json json = frame_to_json(FrameView{bytes}, options);
        EXPECT_EQ(json["fields"]["kind"], kind);
        EXPECT_EQ(std::get<0>(frame_from_json(json, options)), bytes);
        json["fields"]["kind"] = std::to_string(kind);    // as text
        const auto again = frame_from_json(json, options);
        ASSERT_EQ(again.index(), 0u) << std::get<1>(again).what;
        EXPECT_EQ(std::get<0>(again), bytes);
    }
    const auto unknown = frame_from_json(Json::parse(R"({"id": "0xF1", "to": 1, "fields": {"kind": 3, "c": 1}})"), options);
    ASSERT_EQ(unknown.index(), 1u);
}

TEST(FlexibleJson, layouts_decode_and_encode) {
    FlexibleLayouts layouts;
    const auto json = nlohmann::json::parse(R"([
        {"id": "0xF1", "fields": [{"name": "a", "type": "i16"}, {"name": "b", "type": "i16", "scale": 0.01, "unit": "V"},
                                  {"name": "c", "type": "f32"}]},
        {"id": 250, "source": "0x1E", "fields": [{"name": "温度", "type": "u8"}]},
        {"id": "flexible2", "fields": [{"name": "x", "type": "u32"}]}])");
    ASSERT_TRUE(add_flexible(json, "/flexible", layouts).empty());
    EXPECT_EQ(layouts.all().size(), 3u);

    const auto bytes = support::frame(5, 254, 0xF1, {1, 0, 0xC7, 0xFF, 0, 0, 0xC0, 0x3F});
    const JsonOptions options{&layouts, Encoding::utf8};
    const Json frame = frame_to_json(FrameView{bytes}, options);
    EXPECT_EQ(frame.dump(), R"({"from":5,"to":254,"id":241,"name":"flexible1","fields":{"a":1,"b":-0.57,"c":1.5}})");
    EXPECT_EQ(std::get<0>(frame_from_json(frame, options)), bytes);

    const auto mine = support::frame(30, 254, 0xFA, {7});
    const auto other = support::frame(31, 254, 0xFA, {7});
    EXPECT_EQ(frame_to_json(FrameView{mine}, options)["fields"]["温度"], 7);
    EXPECT_EQ(frame_to_json(FrameView{other}, options)["data"], "07");
    const auto wrong = frame_from_json(Json::parse(R"({"name": "flexible2", "fields": {"y": 1}})"), options);
    EXPECT_EQ(std::get<JsonFault>(wrong).what, "flexible2 has no field 'y'");
}

TEST(FlexibleJson, layouts_support_arrays_byte_order_and_selection_by_the_first_field) {
    FlexibleLayouts layouts;
    const char* const text = R"([
        {"endian": "big", "fields": [{"name": "kind", "type": "u8"}, {"name": "a", "count": 2, "scale": 0.1, "type": "i16"}],
         "id": "0xF1", "source": 30, "when": 3},
        {"fields": [{"name": "kind", "type": "u8"}, {"name": "b", "type": "u16"}], "id": "0xF1", "source": 30, "when": 4}])";
    const auto json = nlohmann::json::parse(text);
    ASSERT_TRUE(add_flexible(json, "/flexible", layouts).empty());
    std::vector<FlexibleSpec> specs;
    ASSERT_TRUE(read_flexible(json, "/flexible", specs).empty());
    EXPECT_EQ(nlohmann::json::parse(flexible_to_json(specs).dump()), json);

    const JsonOptions options{&layouts, Encoding::utf8};
    const auto three = support::frame(30, 254, 0xF1, {3, 0, 10, 0xFF, 0xF6});
    EXPECT_EQ(frame_to_json(FrameView{three}, options)["fields"].dump(), R"({"kind":3,"a":[1.0,-1.0]})");
    const auto four = support::frame(30, 254, 0xF1, {4, 1, 2});
    EXPECT_EQ(frame_to_json(FrameView{four}, options)["fields"].dump(), R"({"kind":4,"b":513})");
    for (const auto& frame : {three, four})
        EXPECT_EQ(std::get<0>(frame_from_json(frame_to_json(FrameView{frame}, options), options)), frame);
    const auto encoded = [&](const char* fields) {
        return frame_from_json(
            Json::parse(R"({"from": 30, "to": 254, "name": "flexible1", "fields": )" + std::string{fields} + "}"), options);
    };
    EXPECT_EQ(std::get<0>(encoded(R"({"a": [1, -1]})")), three) << "the value that selects it need not be given";
    EXPECT_EQ(std::get<0>(encoded(R"({"b": 513})")), four);
    EXPECT_EQ(std::get<JsonFault>(encoded(R"({"kind": 5})")).what,
              "flexible1 has no layout in the configuration with all of these fields and values");
}

TEST(FlexibleJson, faults_show_their_location) {
    EXPECT_EQ(faults_of(R"([{"id": 241, "endian": "middle", "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/endian: must be \"little\" or \"big\""});
    EXPECT_EQ(faults_of(R"([{"id": 241, "when": 300, "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/when: 'when' is a value of the first field, which is one u8, u16 or u32 without a scale"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "when": -1, "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/when: 'when' is a value of the first field, which is one u8, u16 or u32 without a scale"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8", "count": 0}]}])"),
              Lines{"/flexible/0/fields/0: a count is a number from 1 to 65535"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8", "count": "many"}]}])"),
              Lines{"/flexible/0/fields/0/count: a count is a number from 1 to 65535"});
    EXPECT_EQ(faults_of("5"), Lines{"/flexible: must be an array of layouts"});
    EXPECT_EQ(faults_of("[5]"), Lines{"/flexible/0: must be an object"});
    EXPECT_EQ(faults_of(R"([{}])"), (Lines{"/flexible/0: key 'id' is missing", "/flexible/0: key 'fields' is missing"}));
    EXPECT_EQ(faults_of(R"([{"id": 3, "fields": []}])"), Lines{"/flexible/0/id: a flexible message has an id from 0xF1 to 0xFA"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": []}])"), Lines{"/flexible/0: a layout needs at least one field"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "feilds": [], "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/feilds: unknown key 'feilds' (did you mean 'fields'?)"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8"}, {"name": "b", "type": "i61"}]}])"),
              Lines{"/flexible/0/fields/1/type: unknown type 'i61' (did you mean 'i16'?); a field is one of u8 i8 u16 "
                    "i16 u32 i32 f32"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "text"}]}])"),
              Lines{"/flexible/0/fields/0: a field is one of u8 i8 u16 i16 u32 i32 f32"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8", "scale": "1"}]}])"),
              Lines{"/flexible/0/fields/0/scale: must be a number"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "source": 256, "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/source: an address is 0 to 255"});
    for (const char* source : {"0", "255", "\"0xFF\""})    // some boards use these sources
        EXPECT_EQ(
            faults_of(
                (std::string{R"([{"id": 241, "source": )"} + source + R"(, "fields": [{"name": "a", "type": "u8"}]}])").c_str()),
            Lines{});
    EXPECT_EQ(
        faults_of(
            R"([{"id": 241, "fields": [{"name": "a", "type": "u8"}]}, {"id": "0xF1", "fields": [{"name": "b", "type": "u8"}]}])"),
        Lines{"/flexible/1: this id already has a layout for this source and value of 'when'"});
}

}    // namespace
}    // namespace flexible_tests
