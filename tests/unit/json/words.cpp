#include <gtest/gtest.h>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/words.hpp>

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <variant>

#include <support/bytes.hpp>

namespace words_tests {
namespace {

using namespace ano;

support::Bytes data_of(std::string_view text, const JsonOptions& options = {}) {
    const auto frame = frame_from_json(Json::parse(text), options);
    if (const auto* fault = std::get_if<JsonFault>(&frame)) {
        ADD_FAILURE() << fault->pointer << ": " << fault->what;
        return {};
    }
    const auto& bytes = std::get<0>(frame);
    return {bytes.begin() + 6, bytes.end() - 2};
}
std::string fault_of(std::string_view text, const JsonOptions& options = {}) {
    const auto frame = frame_from_json(Json::parse(text), options);
    const auto* fault = std::get_if<JsonFault>(&frame);
    return fault != nullptr ? fault->what : "no fault";
}

TEST(Words, of_the_whole_table_are_read_back_with_the_same_meaning) {
    for (const Message& row : messages)
        for (const Field& f : row.fields()) {
            if (f.count != 1) continue;
            for (const Meaning& m : f.meanings) {
                const Json json{{"id", row.id}, {"fields", {{f.name, m.text}}}};
                const auto frame = frame_from_json(json);
                const auto* bytes = std::get_if<0>(&frame);
                ASSERT_NE(bytes, nullptr) << json << " " << std::get<JsonFault>(frame).what;
                const Reading reading = read(FrameView{*bytes});
                const Field* found = reading.field(f.name);
                ASSERT_NE(found, nullptr) << json;
                EXPECT_EQ(found->meaning(static_cast<std::uint64_t>(reading.number(*found))), m.text) << json;
            }
        }
}

TEST(Words, select_the_layout_that_contains_them) {
    const support::Bytes save{0x10, 0xAB, 0};
    EXPECT_EQ(data_of(R"({"name": "parameter_command", "fields": {"cmd": "action", "val": "save"}})"), save);
    EXPECT_EQ(data_of(R"({"name": "parameter_command", "fields": {"cmd": 16, "val": "Save"}})"), save);
    EXPECT_EQ(data_of(R"({"name": "parameter_command", "fields": {"val": "restore_defaults"}})"),
              (support::Bytes{0x10, 0xAA, 0}));
    EXPECT_EQ(data_of(R"({"name": "parameter_command", "fields": {"cmd": "device-info"}})"), (support::Bytes{0, 0, 0}));
    EXPECT_EQ(data_of(R"({"name": "ranging", "fields": {"type": "scan", "points": []}})"), support::Bytes{100});
    EXPECT_EQ(data_of(R"({"name": "firmware", "fields": {"code": "frame written", "frame_num": 1}})"),
              (support::Bytes{0, 2, 0x10, 1, 0}));
}

TEST(Words, that_are_unknown_are_reported_with_the_known_ones) {
    EXPECT_EQ(fault_of(R"({"name": "log", "fields": {"color": "rde"}})"),
              "log color: 'rde' is not a number, nor default, red, green, blue (did you mean 'red'?)");
    EXPECT_EQ(fault_of(R"({"name": "parameter_command", "fields": {"cmd": "acton"}})"),
              "parameter_command cmd: 'acton' is not a number, nor device info, how many, value, description, action "
              "(did you mean 'action'?)");
    EXPECT_EQ(fault_of(R"({"name": "euler", "fields": {"rol": "abc"}})"), "euler rol: 'abc' is not a number");
    EXPECT_EQ(fault_of(R"({"name": "parameter_command", "fields": {"cmd": 2, "val": "save"}})"),
              "parameter_command cmd: 2 is none of 16");
    EXPECT_EQ(fault_of(R"({"name": "parameter_command", "fields": {"cmd": "value", "val": "save"}})"),
              "parameter_command has no layout with all of these values");
}

TEST(Words, for_value_type_7_depend_on_the_device) {
    constexpr JsonOptions text{};
    constexpr JsonOptions current{nullptr, Encoding::utf8, ValueType7::u64};
    const auto type = [](const char* word, const JsonOptions& options) {
        return data_of(R"({"name": "command_info", "fields": {"val_type": [")" + std::string{word} + R"("]}})", options)[5];
    };
    EXPECT_EQ(type("f32", text), 7);
    EXPECT_EQ(type("f32", current), 9);
    EXPECT_EQ(type("u64", current), 7);
    EXPECT_EQ(type("i64", text), 8);
    EXPECT_EQ(fault_of(R"({"name": "command_info", "fields": {"val_type": ["u64"]}})")
                  .rfind("command_info val_type: 'u64' is not a number, nor none, u8, ", 0),
              0u);
}

TEST(Words, for_addresses_are_accepted) {
    const auto frame = frame_from_json(Json::parse(R"({"name": "check", "from": "Flight_Controller", "to": "broadcast"})"));
    ASSERT_TRUE(std::holds_alternative<support::Bytes>(frame));
    EXPECT_EQ(std::get<0>(frame)[1], 0xDC);
    EXPECT_EQ(std::get<0>(frame)[2], 0xFF);
    EXPECT_EQ(fault_of(R"({"name": "check", "to": "hots"})"),
              "to: 'hots' is not an address from 0 to 255 (did you mean 'host'?)");
    EXPECT_EQ(fault_of(R"({"name": "check", "to": "user device"})"), "to: 'user device' is not an address from 0 to 255");
    EXPECT_EQ(fault_of(R"({"name": "check", "to": 300})"), "to: 300 is not a number from 0 to 255");
}

TEST(TypedValues, are_encoded_as_the_bytes_of_a_command) {
    EXPECT_EQ(data_of(R"({"name": "command", "fields": {"cid0": 1, "values": "u16:100,i32:-5"}})"),
              (support::Bytes{1, 0, 0, 100, 0, 0xFB, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(
        data_of(R"({"name": "command", "fields": {"values": "u8:1,i8:-1,i16:-2,u32:0x10,u64:1,i64:-1,f32:1.5,f64:2"}})").size(),
        3u + 1 + 1 + 2 + 4 + 8 + 8 + 4 + 8);
    EXPECT_EQ(data_of(R"({"name": "command", "fields": {"values": "0102"}})"), (support::Bytes{0, 0, 0, 1, 2}));
    EXPECT_EQ(data_of(R"({"name": "command", "fields": {"values": ""}})"), (support::Bytes{0, 0, 0}));
}

TEST(TypedValues, are_encoded_as_the_value_of_a_parameter) {
    EXPECT_EQ(data_of(R"({"name": "parameter_value", "fields": {"par_id": 3, "value": "f32:1.5"}})"),
              (support::Bytes{3, 0, 0, 0, 0xC0, 0x3F}));
    EXPECT_EQ(data_of(R"({"name": "parameter_value", "fields": {"value": "string:a:b,c"}})"),
              (support::Bytes{0, 0, 'a', ':', 'b', ',', 'c'}));
    EXPECT_EQ(data_of(R"({"name": "parameter_value", "fields": {"value": "string:解"}})", {nullptr, Encoding::gbk}),
              (support::Bytes{0, 0, 0xBD, 0xE2}));
}

std::string command_fault(const std::string& values) {
    return fault_of(R"({"name": "command", "fields": {"values": ")" + values + "\"}}");
}
std::string value_fault(const std::string& value, const std::string& more = "") {
    return fault_of(R"({"name": "parameter_value", "fields": {"value": ")" + value + "\"" + more + "}}");
}

TEST(TypedValues, that_are_invalid_are_reported) {
    EXPECT_EQ(command_fault("u17:1"),
              "command values: there is no type 'u17' (did you mean 'u16'?); the types are u8, i8, u16, i16, u32, i32, "
              "u64, i64, f32, f64");
    EXPECT_EQ(command_fault("u8:1,2"), "command values: '2' has no type, such as in u16:100");
    EXPECT_EQ(command_fault("u8:300"), "command values: '300' is out of range (u8, 0 to 255)");
    EXPECT_EQ(command_fault("u8:1.5"), "command values: '1.5' is not a whole number (u8, 0 to 255)");
    EXPECT_EQ(command_fault("u8:one"), "command values: 'one' is not a number");
    EXPECT_EQ(command_fault("u8:1,"), "command values: '' has no type, such as in u16:100");
    EXPECT_EQ(command_fault("u8:1,u8:1,u8:1,u8:1,u8:1,u8:1,u8:1,u8:1,u8:1"),
              "command values: a command has 8 values at most, not 9");
    EXPECT_NE(command_fault("string:a").find("there is no type 'string'"), std::string::npos);
    EXPECT_EQ(command_fault("xyz"), "command values: 'xyz' is neither hex digits in pairs nor typed, as f32:1.5 is");
    EXPECT_EQ(value_fault("u8:1,u8:2"), "parameter_value value: a parameter has one value, not 2");
    EXPECT_EQ(value_fault("1.5"), "parameter_value value: '1.5' is neither hex digits in pairs nor typed, as f32:1.5 is");
}

// Devices store the check bytes of the frame instead of the missing bytes.
TEST(ParameterValue, that_is_shorter_than_its_type_is_refused) {
    const std::string behind =
        "; a device would store check bytes of the frame with it: write it with its type, such as f32:1.5 or string:abc";
    EXPECT_EQ(value_fault(""), "parameter_value value: it is empty" + behind);
    EXPECT_EQ(value_fault("string:"), "parameter_value value: it is empty" + behind);
    EXPECT_EQ(fault_of(R"({"name": "parameter_value", "fields": {"par_id": 1}})"), "parameter_value value: it is empty" + behind);
    for (const std::size_t size : {3u, 5u, 6u, 7u}) {
        const std::string digits(2 * size, '0');
        EXPECT_EQ(value_fault(digits),
                  "parameter_value value: '" + digits + "' is " + std::to_string(size) + " bytes, as no number is" + behind);
    }
    for (const std::size_t size : {1u, 2u, 4u, 8u, 9u}) EXPECT_EQ(value_fault(std::string(2 * size, '0')), "no fault");
    EXPECT_EQ(value_fault("0000", R"(, "par_type": "f32")"), "parameter_value value: '0000' is 2 bytes, f32 has 4" + behind);
    EXPECT_EQ(value_fault("00", R"(, "par_type": 2)"), "parameter_value value: '00' is 1 byte, u16 has 2" + behind);
    EXPECT_EQ(value_fault("000000", R"(, "par_type": "string")"), "no fault");
    EXPECT_EQ(value_fault("0000c03f", R"(, "par_type": 8)"), "no fault");
    EXPECT_EQ(value_fault("u8:1", R"(, "par_type": "f32")"), "parameter_value value: 'u8:1' is not what par_type says: 'f32'");
    EXPECT_EQ(data_of(R"({"name": "parameter_value", "fields": {"value": "ff", "par_type": "u8"}})"),
              (support::Bytes{0, 0, 0xFF}));
    // Such a frame, when received, is still encoded back to its bytes.
    EXPECT_EQ(data_of(R"({"name": "parameter_value", "fields": {"par_id": 7, "value": ""}, "data": "0700"})").size(), 2u);
}

TEST(ParameterInfo, of_an_old_device_is_encoded_from_its_fields) {
    const auto data = data_of(R"({"name": "parameter_info", "fields": {"min": 0, "max": 5, "name": "A"}})");
    ASSERT_EQ(data.size(), 30u);
    EXPECT_EQ(read(0xE2, data).message()->variant.label, "old");
    EXPECT_EQ(fault_of(R"({"name": "parameter_info", "fields": {"min": 8202, "name": "A"}})"),
              "parameter_info would be read in another layout with these values: give its data");
}

}    // namespace
}    // namespace words_tests
