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

TEST(Flexible, reports_messages_that_are_too_short_or_without_layout) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF1, std::nullopt, abc));
    const auto too_short = support::frame(30, 0xFE, 0xF1, support::Bytes(7));
    const auto unknown = support::frame(30, 0xFE, 0xF2, support::Bytes(8));
    EXPECT_EQ(read(FrameView{too_short}, &layouts).readable(), Readable::too_short);
    EXPECT_EQ(read(FrameView{unknown}, &layouts).readable(), Readable::unknown_layout);
}

TEST(Flexible, prefers_the_layout_of_a_source_to_the_one_for_all) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add(0xF5, std::nullopt, abc));
    ASSERT_FALSE(layouts.add(0xF5, 30, std::vector<FlexibleField>{{"mine", Type::f32, 1, ""}}));
    EXPECT_EQ(layouts.find(0xF5, 30, {})->fields()[0].name, "mine");
    EXPECT_EQ(layouts.find(0xF5, 31, {})->fields()[0].name, "a");
    EXPECT_EQ(layouts.find(0xF6, 30, {}), nullptr);
}

TEST(Flexible, numbers_may_be_big_endian) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add({.id = 0xF1,
                              .fields = {{"a", Type::i16, 0.01, ""}, {"b", Type::u32, 1, ""}, {"c", Type::f32, 1, ""}},
                              .endian = ByteOrder::big}));
    const support::Bytes data{0xFF, 0xC7, 1, 2, 3, 4, 0x3F, 0xC0, 0, 0};
    const Reading reading = read(0xF1, data, &layouts);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading.number(reading.fields()[0]), -0.57);
    EXPECT_EQ(reading.number(reading.fields()[1]), 0x01020304);
    EXPECT_EQ(reading.number(reading.fields()[2]), 1.5);
}

TEST(Flexible, a_field_may_be_an_array) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add({.id = 0xF1, .fields = {{"n", Type::u8, 1, ""}, {"cells", Type::u16, 0.001, "V", 3}}}));
    EXPECT_EQ(layouts.all().front().size(), 7);
    const support::Bytes data{7, 0x10, 0x0E, 0x11, 0x0E, 0x12, 0x0E, 9};
    const Reading reading = read(0xF1, data, &layouts);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading.bytes_of(reading.fields()[1]).size(), 6u);
    EXPECT_EQ(std::get<double>(value_at(reading.fields()[1], reading.bytes_of(reading.fields()[1]).data() + 4)), 3.602);
    EXPECT_EQ(reading.extra().size(), 1u);
}

TEST(Flexible, the_first_field_may_select_the_layout) {
    FlexibleLayouts layouts;
    const auto layout = [](const char* name, std::optional<std::uint32_t> when, std::optional<std::uint8_t> source = {},
                           Type first = Type::u8, ByteOrder endian = ByteOrder::little) {
        return FlexibleSpec{.id = 0xF2,
                            .source = source,
                            .fields = {{"kind", first, 1, ""}, {name, Type::u8, 1, ""}},
                            .endian = endian,
                            .when = when};
    };
    ASSERT_FALSE(layouts.add(layout("any", {})));
    ASSERT_FALSE(layouts.add(layout("three", 3)));
    ASSERT_FALSE(layouts.add(layout("own three", 3, 30)));
    ASSERT_FALSE(layouts.add(layout("big", 0x0102, 31, Type::u16, ByteOrder::big)));
    EXPECT_EQ(layouts.add(layout("again", 3)).fault, Fault::duplicate);
    const auto name = [&](std::uint8_t source, support::Bytes data) {
        return layouts.find(0xF2, source, data)->fields()[1].name;
    };
    EXPECT_EQ(name(1, {3, 0}), "three");
    EXPECT_EQ(name(1, {4, 0}), "any");
    EXPECT_EQ(name(30, {3, 0}), "own three");
    EXPECT_EQ(name(30, {4, 0}), "any");
    EXPECT_EQ(name(31, {1, 2, 0}), "big");
    EXPECT_EQ(name(31, {2, 1, 0}), "any");
    EXPECT_EQ(name(31, {3, 1, 0}), "three");

    FlexibleLayouts only;
    ASSERT_FALSE(only.add(layout("three", 3)));
    EXPECT_EQ(read(0xF2, support::Bytes{4, 0}, &only).readable(), Readable::unknown_layout);
    EXPECT_EQ(read(0xF2, support::Bytes{3}, &only).readable(), Readable::too_short);
    EXPECT_EQ(read(0xF2, support::Bytes{}, &only).readable(), Readable::unknown_layout);
}

TEST(Flexible, rejects_a_selecting_value_that_the_first_field_cannot_have) {
    const auto fault = [](Type type, double scale, std::uint16_t count, std::uint32_t when) {
        FlexibleLayouts layouts;
        return layouts.add({.id = 0xF1, .fields = {{"kind", type, scale, "", count}}, .when = when}).fault;
    };
    EXPECT_EQ(fault(Type::u8, 1, 1, 255), Fault::none);
    EXPECT_EQ(fault(Type::u8, 1, 1, 256), Fault::when);
    EXPECT_EQ(fault(Type::u16, 1, 1, 65535), Fault::none);
    EXPECT_EQ(fault(Type::u16, 1, 1, 65536), Fault::when);
    EXPECT_EQ(fault(Type::u32, 1, 1, 0xFFFFFFFF), Fault::none);
    EXPECT_EQ(fault(Type::i8, 1, 1, 3), Fault::when);
    EXPECT_EQ(fault(Type::f32, 1, 1, 3), Fault::when);
    EXPECT_EQ(fault(Type::u8, 0.1, 1, 3), Fault::when);
    EXPECT_EQ(fault(Type::u8, 1, 2, 3), Fault::when);
    EXPECT_EQ(fault(Type::u8, 1, 0, 3), Fault::count);
}

TEST(Flexible, keeps_its_names_when_it_is_moved) {
    FlexibleLayouts layouts;
    for (std::uint8_t id = 0xF1; id <= 0xFA; ++id) ASSERT_FALSE(layouts.add(id, std::nullopt, abc));
    const FlexibleLayouts moved = std::move(layouts);
    for (const FlexibleLayout& layout : moved.all()) EXPECT_EQ(layout.fields()[2].name, "c");
}

TEST(Flexible, rejects_invalid_layouts) {
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
