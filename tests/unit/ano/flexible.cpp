#include <gtest/gtest.h>
#include <ano/flexible.hpp>
#include <ano/reading.hpp>

#include <cmath>
#include <utility>
#include <vector>

#include <support/bytes.hpp>

namespace flexible_tests {
namespace {

using namespace ano;
using Fault = FlexibleLayouts::Fault;

const std::vector<FlexibleField> abc{{"a", Type::i16, 1, ""}, {"b", Type::i16, 0.01, "V"}, {"c", Type::i32, 1, ""}};

TEST(Flexible, decodes_like_any_other_message) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF1, std::nullopt, abc));
    const auto bytes = support::frame(30, 0xFE, 0xF1, {1, 0, 57, 0, 0xFE, 0xFF, 0xFF, 0xFF, 9});
    const Reading reading = read(FrameView{bytes}, &layouts);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading.message()->name, "flexible1");
    ASSERT_EQ(reading.fields().size(), 3u);
    EXPECT_EQ(reading.fields()[1].name, "b");
    EXPECT_EQ(reading.fields()[1].unit, "V");
    EXPECT_EQ(std::get<double>(reading.value(reading.fields()[1])), 0.57);
    EXPECT_EQ(std::get<std::int64_t>(reading.value(reading.fields()[2])), -2);
    EXPECT_EQ(reading.extra().size(), 1u);
}

TEST(Flexible, is_too_short_or_without_layout_like_any_other) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF1, std::nullopt, abc));
    const auto too_short = support::frame(30, 0xFE, 0xF1, support::Bytes(7));
    const auto unknown = support::frame(30, 0xFE, 0xF2, support::Bytes(8));
    EXPECT_EQ(read(FrameView{too_short}, &layouts).readable(), Readable::too_short);
    EXPECT_EQ(read(FrameView{unknown}, &layouts).readable(), Readable::unknown_layout);
}

TEST(Flexible, the_layout_of_a_source_goes_before_the_one_for_all) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF5, std::nullopt, abc));
    ASSERT_FALSE(layouts.add(0xF5, 30, std::vector<FlexibleField>{{"mine", Type::f32, 1, ""}}));
    EXPECT_EQ(layouts.find(0xF5, 30)->fields()[0].name, "mine");
    EXPECT_EQ(layouts.find(0xF5, 31)->fields()[0].name, "a");
    EXPECT_EQ(layouts.find(0xF6, 30), nullptr);
}

TEST(Flexible, keeps_its_names_when_it_is_moved) {
    FlexibleLayouts layouts;
    for (std::uint8_t id = 0xF1; id <= 0xFA; ++id) ASSERT_FALSE(layouts.add(id, std::nullopt, abc));
    const FlexibleLayouts moved = std::move(layouts);
    for (const FlexibleLayout& layout : moved.all()) EXPECT_EQ(layout.fields()[2].name, "c");
}

TEST(Flexible, refuses_what_is_no_layout) {
    const auto refused = [](std::uint8_t id, std::vector<FlexibleField> fields) {
        FlexibleLayouts layouts;
        return layouts.add(id, std::nullopt, fields).fault;
    };
    EXPECT_EQ(refused(0xF0, abc), Fault::id);
    EXPECT_EQ(refused(0xFB, abc), Fault::id);
    EXPECT_EQ(refused(0xF1, {}), Fault::no_fields);
    EXPECT_EQ(refused(0xF1, {{"a", Type::u8, 1, ""}, {"a", Type::u8, 1, ""}}), Fault::name);
    EXPECT_EQ(refused(0xF1, {{"", Type::u8, 1, ""}}), Fault::name);
    EXPECT_EQ(refused(0xF1, {{"a=b", Type::u8, 1, ""}}), Fault::name);
    EXPECT_EQ(refused(0xF1, {{"a", Type::text, 1, ""}}), Fault::type);
    EXPECT_EQ(refused(0xF1, {{"a", Type::u64, 1, ""}}), Fault::type);
    EXPECT_EQ(refused(0xF1, {{"a", Type::u8, 0, ""}}), Fault::scale);
    EXPECT_EQ(refused(0xF1, {{"a", Type::u8, std::nan(""), ""}}), Fault::scale);
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF1, 1, abc));
    EXPECT_EQ(layouts.add(0xF1, 1, abc).fault, Fault::duplicate);
    EXPECT_FALSE(layouts.add(0xF1, 2, abc));
    EXPECT_EQ(layouts.all().size(), 2u);
}

}    // namespace
}    // namespace flexible_tests
