// A frame in JSON has `data` beside its fields only if these do not restore it.
#include <ano/messages.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace restored_tests {
namespace {

using namespace ano;
using support::Bytes;
using support::Random;

/// DATA that fits a layout, and shorter or longer DATA.
Bytes random_data(const Message& row, Random& random) {
    std::size_t size = row.variant.length != 0 ? row.variant.length : row.fixed_size;
    if (row.is_open()) size += random.below(30u);
    if (random.one_in(6)) size += random.below(6u);
    Bytes data(size);
    for (auto& byte : data) byte = random.one_in(2) ? 0 : random.byte();
    for (const Field& f : row.fields()) {
        const auto at = data.begin() + f.offset;
        if (f.type == Type::text && !random.one_in(4)) {
            const auto text = random.of<std::string_view>({"kp", "温度", "\xCE\xC2\xB6\xC8", "é", "\xFF", ""});
            if (f.is_open()) data.resize(f.offset + text.size());
            else std::fill_n(at, f.size(), std::uint8_t{0});
            std::copy_n(text.begin(), std::min(text.size(), f.is_open() ? text.size() : f.size()), data.begin() + f.offset);
        }
        if (f.type == Type::f32 && random.one_in(8)) std::fill_n(at, f.size(), std::uint8_t{0xFF});
        if (f.type == Type::frames) {
            data.resize(f.offset);
            for (auto parts = random.below(4u); parts > 0; --parts) {
                const Bytes part = random.one_in(3) ? Bytes{1, 2} : support::frame(1, 2, 0x09, Bytes(4));
                data.insert(data.end(), part.begin(), part.end());
            }
        }
        if (!f.selects) continue;
        const std::uint32_t value = f.selects->first + random.below(f.selects->last - f.selects->first + 1);
        for (std::size_t i = 0; i < f.size(); ++i) data[f.offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    return data;
}

/// One of its numbers is null in JSON without being "no data".
bool has_no_number(const Reading& reading) {
    const auto is_none = [](const Value& value) {
        const auto* const number = std::get_if<double>(&value);
        return number != nullptr && !std::isfinite(*number);
    };
    return std::any_of(reading.fields().begin(), reading.fields().end(), [&](const Field& f) {
        if (f.type == Type::list) return false;    // of whole numbers
        const ano::Bytes bytes = reading.bytes_of(f);
        for (std::size_t at = 0; is_number(f.type) && at < bytes.size(); at += width(f.type))
            if (is_none(value_at(f, bytes.data() + at))) return true;
        return false;
    });
}

void expect_data_where_needed(const Bytes& frame, const JsonOptions& options, std::string_view what) {
    Json json = frame_to_json(FrameView{frame}, options);
    const Reading reading = read(FrameView{frame}, options.flexible);
    if (!reading) return;
    const bool has_data = json.erase("data") > 0;
    const auto again = frame_from_json(json, {.flexible = options.flexible});
    const auto* const bytes = std::get_if<Bytes>(&again);
    EXPECT_EQ(has_data, bytes == nullptr || *bytes != frame || has_no_number(reading)) << what << ' ' << json.dump();
}

TEST(Restored, layouts_have_data_exactly_if_their_fields_do_not_restore_the_frame) {
    for (const Message& row : messages)
        for (std::uint64_t seed = 0; seed < support::trials(60); ++seed) {
            Random random{seed};
            const auto encoding = random.of({Encoding::utf8, Encoding::gbk, Encoding::automatic});
            expect_data_where_needed(support::frame(5, 6, row.id, random_data(row, random)), {.encoding = encoding}, row.name);
        }
}

TEST(Restored, flexible_layouts_with_equal_fields_have_data_exactly_if_fields_do_not_restore_the_frame) {
    FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add({.id = 0xF1, .fields = {{"kind", Type::u8, 1, ""}, {"x", Type::f32, 1, ""}}, .when = 1}));
    ASSERT_FALSE(layouts.add(
        {.id = 0xF1, .fields = {{"kind", Type::u8, 1, ""}, {"x", Type::f32, 1, ""}, {"y", Type::i16, 0.37, ""}}, .when = 2}));
    ASSERT_FALSE(layouts.add({.id = 0xF1, .fields = {{"kind", Type::u8, 1, ""}}}));
    ASSERT_FALSE(
        layouts.add({.id = 0xF1, .source = 5, .fields = {{"kind", Type::u16, 1, ""}, {"x", Type::i8, 1, ""}}, .when = 1}));
    for (std::uint64_t seed = 0; seed < support::trials(2000); ++seed) {
        Random random{seed};
        Bytes data(random.below(9u));
        for (auto& byte : data)
            byte = random.of({static_cast<std::uint8_t>(random.below(4u)), random.byte(), std::uint8_t{0xFF}});
        expect_data_where_needed(support::frame(random.of<std::uint8_t>({5, 6}), 7, 0xF1, data), {&layouts}, "flexible");
    }
}

}    // namespace
}    // namespace restored_tests
