#include <gtest/gtest.h>
#include <ano/typed.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <support/bytes.hpp>

namespace typed_tests {
namespace {

using namespace ano;
using support::frame;

constexpr std::array<std::uint8_t, 7> euler_data{0x7B, 0x00, 0x85, 0xFF, 0x00, 0x80, 2};
static_assert(View<"euler">{euler_data}.get<"rol">() == 1.23);
static_assert(View<"euler">{euler_data}.get<"pit">() == -1.23);
static_assert(View<"euler">{euler_data}.get<"yaw">() == -327.68);
static_assert(std::is_same_v<decltype(View<"euler">{euler_data}.get<"fusion_sta">()), std::uint8_t>);

TEST(As, reads_the_fields_of_its_message_in_their_units) {
    const auto bytes = frame(0xDC, 0xFE, 0x03, {0x7B, 0x00, 0x85, 0xFF, 0x00, 0x80, 2});
    const auto euler = as<"euler">(FrameView{bytes});
    ASSERT_TRUE(euler);
    EXPECT_EQ(euler->get<"rol">(), 1.23);
    EXPECT_EQ(euler->get<"pit">(), -1.23);
    EXPECT_EQ(euler->get<"yaw">(), -327.68);
    EXPECT_EQ(euler->get<"fusion_sta">(), 2);
}

TEST(As, fails_for_another_message_or_a_length_that_does_not_fit) {
    const auto other = frame(1, 2, 0x04, support::Bytes(9));
    const auto too_short = frame(1, 2, 0x03, support::Bytes(6));
    const auto longer = frame(1, 2, 0xC1, support::Bytes(5));
    const auto by_one = frame(1, 2, 0x04, support::Bytes(10));         // a mode byte may stand before the fields
    const auto of_no_layout = frame(1, 2, 0x03, support::Bytes(9));    // the base layout of 0x03 is exact
    EXPECT_FALSE(as<"euler">(FrameView{other}));
    EXPECT_FALSE(as<"euler">(FrameView{too_short}));
    EXPECT_TRUE(as<"command_query">(FrameView{longer}));
    EXPECT_FALSE(as<"quaternion">(FrameView{by_one}));
    EXPECT_FALSE(as<"euler">(FrameView{of_no_layout}));
}

TEST(As, accepts_a_variant_only_at_its_exact_length) {
    for (const std::size_t size : {4u, 6u, 9u, 11u}) {
        const auto bytes = frame(1, 2, 0x0D, support::Bytes(size));
        EXPECT_EQ(as<"power">(FrameView{bytes}).has_value(), size == 4) << size;
        EXPECT_FALSE((as<"power", "field">(FrameView{bytes}))) << size;
    }
    const auto field = frame(1, 2, 0x0D, {0xD2, 0x04, 0x96, 0x00, 0xF4, 0x01, 0x14, 0, 0, 0});
    EXPECT_FALSE(as<"power">(FrameView{field}));
    const auto power = as<"power", "field">(FrameView{field});
    ASSERT_TRUE(power);
    EXPECT_EQ(power->get<"voltage2">(), 5.0);
}

TEST(As, selects_a_layout_by_its_mode) {
    const auto scan = frame(1, 2, 0x34, {100, 1, 0, 2, 0});
    EXPECT_TRUE((as<"ranging", "scan">(FrameView{scan})));
    EXPECT_FALSE(as<"ranging">(FrameView{scan}));
    const auto written = frame(1, 2, 0xF0, {0, 0x02, 0x10, 7, 0});
    ASSERT_TRUE((as<"firmware", "written">(FrameView{written})));
    EXPECT_EQ((as<"firmware", "written">(FrameView{written})->get<"frame_num">()), 7);
    EXPECT_FALSE(as<"firmware">(FrameView{written}));
    const auto erase = frame(1, 2, 0xF0, {0, 0x10, 0x01});
    EXPECT_TRUE(as<"firmware">(FrameView{erase}));
    const auto erase_high_first = frame(1, 2, 0xF0, {0, 0x01, 0x10});
    EXPECT_EQ((as<"firmware", "reading">(FrameView{erase_high_first})->get<"code">()), 0x0110);
}

TEST(As, returns_no_value_where_there_is_no_data) {
    const auto bytes = frame(1, 2, 0x33, {0x00, 0x80, 5, 0, 0, 0});
    const auto velocity = as<"general_velocity">(FrameView{bytes});
    EXPECT_EQ(velocity->get<"speed_x">(), std::nullopt);
    EXPECT_EQ(velocity->get<"speed_y">(), 5);
}

TEST(As, returns_text_up_to_its_nul_and_bytes_unchanged) {
    support::Bytes data{1, 0, 8, 'G', 'A', 'I', 'N'};
    data.resize(23);
    data.push_back('x');
    const auto bytes = frame(1, 2, 0xE2, data);
    const auto info = as<"parameter_info">(FrameView{bytes});
    ASSERT_TRUE(info);
    EXPECT_EQ(info->get<"name">(), "GAIN");
    EXPECT_EQ(info->get<"info">(), "x");
    EXPECT_EQ(info->bytes<"name">().size(), 20u);
}

TEST(Draft, is_read_as_it_was_filled_in) {
    Draft<"gps"> draft;
    EXPECT_TRUE(draft.set<"lng">(121.3456789));
    EXPECT_TRUE(draft.set<"lat">(-31.2345678));
    EXPECT_TRUE(draft.set<"sacc">(1300));
    EXPECT_TRUE(draft.set<"s_num">(17u));
    std::array<std::uint8_t, 64> out{};
    const std::size_t size = draft.encode(out, 0xDC, 0xFE);
    ASSERT_EQ(size, overhead + 23);
    const auto read = frame_at({out.data(), size});
    ASSERT_TRUE(read);
    EXPECT_EQ(read->source(), 0xDC);
    EXPECT_EQ(read->destination(), 0xFE);
    const auto gps = as<"gps">(*read);
    EXPECT_EQ(gps->get<"lng">(), 121.3456789);
    EXPECT_EQ(gps->get<"lat">(), -31.2345678);
    EXPECT_EQ(gps->get<"sacc">(), 1300);
    EXPECT_EQ(gps->get<"s_num">(), 17);
    EXPECT_EQ(gps->get<"alt_gps">(), 0);
}

TEST(Draft, accepts_only_values_that_fit_the_wire_type) {
    Draft<"euler"> draft;
    EXPECT_TRUE(draft.set<"rol">(3.0));
    EXPECT_FALSE(draft.set<"rol">(327.68));
    EXPECT_FALSE(draft.set<"fusion_sta">(256));
    EXPECT_FALSE(draft.set<"fusion_sta">(-1));
    EXPECT_FALSE(draft.set<"fusion_sta">(1.5));
    std::array<std::uint8_t, 15> out{};
    ASSERT_EQ(draft.encode(out, 1, 2), out.size());
    EXPECT_EQ(as<"euler">(FrameView{out})->get<"rol">(), 3.0);
    EXPECT_EQ(as<"euler">(FrameView{out})->get<"fusion_sta">(), 0);
}

TEST(Draft, writes_nothing_into_a_buffer_that_is_too_small) {
    std::array<std::uint8_t, 14> out{};
    EXPECT_EQ(Draft<"euler">{}.encode(out, 1, 2), 0u);
    EXPECT_EQ(out, (std::array<std::uint8_t, 14>{}));
}

TEST(Draft, accepts_text_of_fixed_and_of_open_length) {
    Draft<"parameter_info"> draft;
    EXPECT_TRUE(draft.set<"name">("12345678901234567890"));
    EXPECT_FALSE(draft.set<"name">("123456789012345678901"));
    EXPECT_TRUE(draft.set<"name">("short"));
    EXPECT_TRUE(draft.set<"info">("what it is"));
    std::vector<std::uint8_t> out(overhead + draft.data_size());
    ASSERT_EQ(draft.encode(out, 1, 2), out.size());
    const auto info = as<"parameter_info">(FrameView{out});
    EXPECT_EQ(info->get<"name">(), "short");
    EXPECT_EQ(info->get<"info">(), "what it is");
}

TEST(Draft, rejects_text_that_is_too_long_for_a_frame) {
    const std::string most(65534, 'x');
    Draft<"log"> draft;
    EXPECT_TRUE(draft.set<"str">(most));
    EXPECT_FALSE(draft.set<"str">(most + "x"));
    EXPECT_EQ(draft.data_size(), 65535u);
}

TEST(Draft, of_a_variant_is_read_as_that_variant) {
    std::array<std::uint8_t, 64> out{};
    std::size_t size = Draft<"optical_flow", "mode2">{}.encode(out, 1, 2);
    EXPECT_TRUE((as<"optical_flow", "mode2">(FrameView{{out.data(), size}})));
    Draft<"firmware", "written"> written;
    EXPECT_TRUE(written.set<"code">(0x1002));
    EXPECT_FALSE(written.set<"code">(0x1010));
    size = written.encode(out, 1, 2);
    EXPECT_TRUE((as<"firmware", "written">(FrameView{{out.data(), size}})));
}

TEST(Draft, can_mark_a_field_as_having_no_data) {
    Draft<"general_position"> draft;
    EXPECT_TRUE(draft.set<"pos_x">(4));
    draft.clear<"pos_x">();
    std::array<std::uint8_t, 20> out{};
    ASSERT_EQ(draft.encode(out, 1, 2), out.size());
    EXPECT_EQ(as<"general_position">(FrameView{out})->get<"pos_x">(), std::nullopt);
    EXPECT_EQ(as<"general_position">(FrameView{out})->get<"pos_y">(), 0);
}

}    // namespace
}    // namespace typed_tests
