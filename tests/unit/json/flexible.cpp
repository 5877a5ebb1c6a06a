#include <gtest/gtest.h>
#include <ano_json/flexible_json.hpp>

#include <nlohmann/json.hpp>

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

TEST(FlexibleJson, faults_name_their_place) {
    EXPECT_EQ(faults_of("5"), Lines{"/flexible: this is to be an array of layouts"});
    EXPECT_EQ(faults_of("[5]"), Lines{"/flexible/0: this is to be an object"});
    EXPECT_EQ(faults_of(R"([{}])"), (Lines{"/flexible/0: key 'id' is missing", "/flexible/0: key 'fields' is missing"}));
    EXPECT_EQ(faults_of(R"([{"id": 3, "fields": []}])"), Lines{"/flexible/0/id: a flexible message has an id from 0xF1 to 0xFA"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": []}])"), Lines{"/flexible/0: a layout has at least one field"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "feilds": [], "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/feilds: unknown key 'feilds' (did you mean 'fields'?)"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8"}, {"name": "b", "type": "i61"}]}])"),
              Lines{"/flexible/0/fields/1/type: unknown type 'i61' (did you mean 'i16'?); a field is one of u8 i8 u16 "
                    "i16 u32 i32 f32"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "text"}]}])"),
              Lines{"/flexible/0/fields/0: a field is one of u8 i8 u16 i16 u32 i32 f32"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "fields": [{"name": "a", "type": "u8", "scale": "1"}]}])"),
              Lines{"/flexible/0/fields/0/scale: this is to be a number"});
    EXPECT_EQ(faults_of(R"([{"id": 241, "source": 255, "fields": [{"name": "a", "type": "u8"}]}])"),
              Lines{"/flexible/0/source: an address is 1 to 254"});
    EXPECT_EQ(
        faults_of(
            R"([{"id": 241, "fields": [{"name": "a", "type": "u8"}]}, {"id": "0xF1", "fields": [{"name": "b", "type": "u8"}]}])"),
        Lines{"/flexible/1: this id has a layout for this source already"});
}

}    // namespace
}    // namespace flexible_tests
