#include <gtest/gtest.h>
#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/sanitized.hpp>

namespace frame_json_tests {
namespace {

using namespace ano;

Json json_of(const support::Bytes& bytes, const JsonOptions& options = {}) { return frame_to_json(FrameView{bytes}, options); }
support::Bytes bytes_of(const Json& json, const JsonOptions& options = {}) {
    auto encoded = frame_from_json(json, options);
    if (const auto* fault = std::get_if<JsonFault>(&encoded)) ADD_FAILURE() << fault->pointer << ": " << fault->what;
    auto* bytes = std::get_if<0>(&encoded);
    return bytes ? *bytes : support::Bytes{};
}
std::string fault_of(std::string_view text, const JsonOptions& options = {}) {
    const auto encoded = frame_from_json(Json::parse(text), options);
    const auto* fault = std::get_if<JsonFault>(&encoded);
    return fault ? fault->pointer + ": " + fault->what : "no fault";
}
support::Bytes data_of(std::string_view text, const JsonOptions& options = {}) {
    const auto bytes = bytes_of(Json::parse(text), options);
    return bytes.empty() ? bytes : support::Bytes{bytes.begin() + 6, bytes.end() - 2};
}

// Random values, often ones with a meaning, so that every layout occurs.
support::Bytes random_data(support::Random& random) {
    support::Bytes data(random.below(40u));
    for (auto& byte : data)
        byte = random.one_in(2) ? random.of<std::uint8_t>({0, 1, 2, 0x10, 100, 0x80, 0xFF, 0x7F, 'a'}) : random.byte();
    return data;
}

TEST(FrameJson, every_frame_is_unchanged_after_conversion_to_json_and_back) {
    support::Random random{7};
    for (unsigned round = 0; round < (support::sanitized ? 20u : 100u); ++round) {
        for (unsigned id = 0; id < 256; ++id) {
            auto data = random_data(random);
            if ((id == 0xB1 || id == 0xB2) && random.one_in(2)) {
                const auto inner = support::frame(random.byte(), random.byte(), random.byte(), random_data(random));
                data.insert(data.end(), inner.begin(), inner.end());
            }
            const auto bytes = support::frame(random.byte(), random.byte(), static_cast<std::uint8_t>(id), data);
            const std::string text = json_of(bytes).dump();
            ASSERT_EQ(hex(bytes_of(Json::parse(text))), hex(bytes)) << text;
            const std::string gbk = json_of(bytes, {nullptr, Encoding::gbk}).dump();
            ASSERT_EQ(hex(bytes_of(Json::parse(gbk))), hex(bytes)) << gbk;
        }
    }
}

TEST(FrameJson, lists_fields_in_the_order_of_the_table) {
    const auto bytes = support::frame(220, 254, 4, {0x7B, 0, 0, 0, 0, 0, 0, 0, 1});
    EXPECT_EQ(
        json_of(bytes).dump(),
        R"({"from":220,"to":254,"id":4,"name":"quaternion","fields":{"v0":0.0123,"v1":0.0,"v2":0.0,"v3":0.0,"fusion_sta":1}})");
    EXPECT_EQ(json_of(support::frame(220, 254, 0x60, {5, 0xAB, 0xCD})).dump(),
              R"({"from":220,"to":254,"id":96,"name":"waypoint_read","fields":{"num":5},"extra":"abcd"})");
}

TEST(FrameJson, data_takes_precedence_over_fields) {
    EXPECT_EQ(data_of(R"({"name": "euler", "fields": {"rol": "nonsense"}, "extra": 5, "data": "0102"})"), (support::Bytes{1, 2}));
}

TEST(FrameJson, omitted_fields_are_zero_and_omitted_addresses_are_host_and_broadcast) {
    EXPECT_EQ(hex(bytes_of(Json::parse(R"({"name": "wind", "fields": {"wind_y": -1}})"))),
              hex(support::frame(254, 255, 9, {0, 0, 0xFF, 0xFF})));
    EXPECT_EQ(bytes_of(Json::parse(R"({"id": "0x77", "from": "0xDC", "to": 1, "data": ""})")), support::frame(0xDC, 1, 0x77));
}

TEST(FrameJson, uses_the_first_layout_that_has_all_fields_starting_with_the_base) {
    EXPECT_EQ(data_of(R"({"name": "power", "fields": {"voltage": 1}})").size(), 4u);
    EXPECT_EQ(data_of(R"({"name": "power", "fields": {"voltage2": 1}})").size(), 10u);
    EXPECT_EQ(data_of(R"({"name": "position", "fields": {"pos_x": 1, "pos_y": 1}})").size(), 12u);
    EXPECT_EQ(data_of(R"({"name": "pwm", "fields": {"pwm4": 1}})").size(), 8u);
    EXPECT_EQ(data_of(R"({"name": "pwm", "fields": {"pwm6": 1}})").size(), 12u);
    EXPECT_EQ(data_of(R"({"name": "pwm", "fields": {"pwm7": 1}})").size(), 16u);
    EXPECT_EQ(data_of(R"({"name": "ranging", "fields": {"direction": 1}})").size(), 7u);
    EXPECT_EQ(data_of(R"({"name": "ranging", "fields": {"points": []}})"), support::Bytes{100});
    EXPECT_EQ(data_of(R"({"name": "ranging", "fields": {"type": 100}})"), support::Bytes{100});
    EXPECT_EQ(data_of(R"({"name": "optical_flow", "fields": {"dx_1": 1}})")[0], 1);
    EXPECT_EQ(data_of(R"({"name": "optical_flow", "fields": {"mode": 2}})").size(), 15u);
    EXPECT_EQ(data_of(R"({"name": "firmware", "fields": {"iap_cmd": 0, "code": 4098}})"), (support::Bytes{0, 2, 0x10, 0, 0}));
    EXPECT_EQ(data_of(R"({"name": "firmware", "fields": {"code": 272}})").size(), 3u);
    EXPECT_EQ(data_of(R"({"name": "firmware", "fields": {"code": 4098, "frame_num": 1}})"), (support::Bytes{0, 2, 0x10, 1, 0}));
    EXPECT_EQ(data_of(R"({"name": "firmware", "fields": {"frame_num": 1, "data": "ff"}})"), (support::Bytes{16, 1, 0, 0xFF}));
}

TEST(FrameJson, numbers_may_be_texts_in_c_notation) {
    EXPECT_EQ(data_of(R"({"name": "mode", "fields": {"mode": "0xDC", "cid": "1e1", "cmd0": 7.0}})"),
              (support::Bytes{0xDC, 0, 10, 7, 0}));
}

TEST(FrameJson, null_means_no_data_for_fields_that_have_such_a_value) {
    EXPECT_EQ(data_of(R"({"name": "general_velocity", "fields": {"speed_x": null}})"), (support::Bytes{0, 0x80, 0, 0, 0, 0}));
    EXPECT_EQ(data_of(R"({"name": "log_value", "fields": {"val": null}})"), (support::Bytes{0, 0, 0xC0, 0x7F}));
    EXPECT_EQ(fault_of(R"({"name": "velocity", "fields": {"speed_x": null}})"),
              "/fields/speed_x: velocity speed_x: it has no value that says \"no data\"");
}

TEST(FrameJson, faults_name_the_field_and_its_range) {
    EXPECT_EQ(fault_of(R"({"name": "euler", "fields": {"rol": 400}})"),
              "/fields/rol: euler rol: 400 is out of range (i16, -327.68 to 327.67 °)");
    EXPECT_EQ(fault_of(R"({"name": "mode", "fields": {"sflag": 256}})"),
              "/fields/sflag: mode sflag: 256 is out of range (u8, 0 to 255)");
    EXPECT_EQ(fault_of(R"({"name": "mode", "fields": {"sflag": 1.5}})"),
              "/fields/sflag: mode sflag: 1.5 is not a whole number (u8, 0 to 255)");
    EXPECT_EQ(fault_of(R"({"name": "mode", "fields": {"sflag": true}})"), "/fields/sflag: mode sflag: true is not a number");
    EXPECT_EQ(fault_of(R"({"name": "log_value", "fields": {"val": 1e39}})"),
              "/fields/val: log_value val: 1e+39 is out of range (f32)");
    EXPECT_EQ(fault_of(R"({"name": "parameter_info", "fields": {"name": "123456789012345678901"}})"),
              "/fields/name: parameter_info name: '123456789012345678901' is 21 bytes, it holds 20");
    EXPECT_EQ(fault_of(R"({"name": "ip_tunnel", "fields": {"dst_ip": "192.168.0"}})"),
              "/fields/dst_ip: ip_tunnel dst_ip: '192.168.0' is not an address like 192.168.0.1");
    EXPECT_EQ(fault_of(R"({"name": "command_info", "fields": {"val_type": [0, 999]}})"),
              "/fields/val_type/1: command_info val_type: 999 is out of range (u8, 0 to 255)");
    EXPECT_EQ(fault_of(R"({"name": "parameter_value", "fields": {"value": "abc"}})"),
              "/fields/value: parameter_value value: 'abc' is neither hex digits in pairs nor typed, as f32:1.5 is");
    EXPECT_EQ(fault_of(R"({"name": "ranging", "fields": {"points": [{}, {"angle": 700}]}})"),
              "/fields/points/1/angle: ranging angle: 700 is out of range (u16, 0 to 655.35 °)");
}

TEST(FrameJson, faults_suggest_the_intended_word) {
    EXPECT_EQ(fault_of(R"({"name": "eular", "fields": {}})"), "/name: there is no message 'eular' (did you mean 'euler'?)");
    EXPECT_EQ(fault_of(R"({"name": "euler", "fields": {"roll": 1}})"),
              "/fields/roll: euler has no field 'roll' (did you mean 'rol'?)");
    EXPECT_EQ(fault_of(R"({"name": "euler", "feilds": {}})"), "/feilds: unknown key 'feilds' (did you mean 'fields'?)");
    EXPECT_EQ(fault_of(R"({"name": "optical_flow", "fields": {"mode": 7}})"), "/fields: optical_flow mode: 7 is none of 0, 1, 2");
    EXPECT_EQ(fault_of(R"({"name": "optical_flow", "fields": {"dx_0": 1, "dx_1": 1}})"),
              "/fields: optical_flow has no layout with all of these fields");
    EXPECT_EQ(fault_of(R"({"name": "ranging", "fields": {"points": [{"angel": 1}]}})"),
              "/fields/points/0/angel: ranging points: no field 'angel' (did you mean 'angle'?)");
}

TEST(FrameJson, faults_of_the_frame_itself_are_reported) {
    EXPECT_EQ(fault_of("5"), ": 5 is not an object");
    EXPECT_EQ(fault_of("{}"), ": a frame needs a name or an id");
    EXPECT_EQ(fault_of(R"({"id": 256})"), "/id: id: 256 is not a number from 0 to 255");
    EXPECT_EQ(fault_of(R"({"id": 4, "name": "euler"})"), "/id: id: 4 is not the id of euler, which is 0x03");
    EXPECT_EQ(fault_of(R"({"id": 119})"), "/fields: id 0x77 is not listed: only its data can be given");
    EXPECT_EQ(fault_of(R"({"id": 241, "fields": {"a": 1}})"),
              "/fields: flexible1 has no layout in the configuration: only its data can be given");
    EXPECT_EQ(fault_of(R"({"id": 119, "data": "0"})"), "/data: data: '0' is not hex digits in pairs");
    EXPECT_EQ(fault_of(R"({"name": "euler", "fields": []})"), "/fields: [] is not an object of fields");
    const std::string large(2 * 65536, '0');
    EXPECT_EQ(fault_of(R"({"id": 119, "data": ")" + large + "\"}"),
              ": 65536 bytes of DATA are more than the 65535 a frame can carry");
    EXPECT_EQ(fault_of(R"({"name": "log", "fields": {"str": "a\u0000b"}})"), "/fields/str: log str: text can't hold a NUL");
}

TEST(FrameJson, a_fault_inside_a_tunnel_shows_its_path) {
    EXPECT_EQ(
        fault_of(R"({"name": "ip_tunnel", "fields": {"frames": [{"name": "wind"}, {"name": "mode", "fields": {"mode": -1}}]}})"),
        "/fields/frames/1/fields/mode: mode mode: -1 is out of range (u8, 0 to 255)");
    EXPECT_EQ(fault_of(R"({"name": "ip_tunnel", "fields": {"frames": [{"name": "ip_tunnel", "fields": {"frames": []}}]}})"),
              "/fields/frames/0/fields/frames: ip_tunnel frames: a tunnel frame inside a tunnel frame is given as its data");
}

TEST(FrameJson, gbk_text_is_read_and_written_if_selected) {
    const support::Bytes text{0, 0xBD, 0xE2, 0xCB, 0xF8};    // colour, then two characters
    const auto bytes = support::frame(220, 254, 0xA0, text);
    EXPECT_EQ(json_of(bytes, {nullptr, Encoding::gbk})["fields"]["str"], "解锁");
    EXPECT_EQ(data_of(R"({"name": "log", "fields": {"str": "解锁"}})", {nullptr, Encoding::gbk}), text);
    EXPECT_EQ(fault_of(R"({"name": "log", "fields": {"str": "🚁"}})", {nullptr, Encoding::gbk}),
              "/fields/str: log str: '🚁' can't be written in GBK");
    EXPECT_TRUE(json_of(bytes)["fields"]["str"].get<std::string>().find("\xEF\xBF\xBD") != std::string::npos);
    EXPECT_TRUE(json_of(bytes).contains("data"));
}

// Many headers, each of which claims all the rest: checked one by one, this would take minutes.
TEST(FrameJson, a_tunnel_full_of_header_bytes_takes_linear_time) {
    const auto bytes = support::frame(1, 2, 0xB1, support::Bytes(65535, 0xAB));
    const Json json = json_of(bytes);
    EXPECT_TRUE(json["fields"]["frames"].empty());
    EXPECT_EQ(bytes_of(json), bytes);
}

TEST(FrameJson, floats_are_printed_in_their_shortest_form) {
    const auto bytes = support::frame(1, 2, 0xA1, {0xCD, 0xCC, 0xCC, 0x3D});
    EXPECT_EQ(json_of(bytes)["fields"].dump(), R"({"val":0.1,"str":""})");
}

}    // namespace
}    // namespace frame_json_tests
