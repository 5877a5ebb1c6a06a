#include <gtest/gtest.h>
#include <ano/reading.hpp>
#include <ano/typed.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <support/bytes.hpp>
#include <support/random.hpp>

namespace reading_tests {
namespace {

using namespace ano;
using support::frame;

TEST(Reading, lists_the_fields_in_order) {
    const auto bytes = frame(0xDC, 0xFE, 0x03, {0x7B, 0x00, 0x85, 0xFF, 0x00, 0x80, 2});
    const Reading reading = read(FrameView{bytes});
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading.message()->name, "euler");
    ASSERT_EQ(reading.fields().size(), 4u);
    EXPECT_EQ(reading.fields()[0].name, "rol");
    EXPECT_EQ(std::get<double>(reading.value(reading.fields()[0])), 1.23);
    EXPECT_EQ(std::get<std::int64_t>(reading.value(*reading.field("fusion_sta"))), 2);
    EXPECT_EQ(reading.number(*reading.field("yaw")), -327.68);
    EXPECT_EQ(reading.field("roll"), nullptr);
    EXPECT_TRUE(reading.extra().empty());
}

TEST(Reading, reports_why_there_are_no_fields) {
    const support::Bytes some(6);
    EXPECT_EQ(read(0x77, some).readable(), Readable::unknown_id);
    EXPECT_EQ(read(0x77, some).message(), nullptr);
    EXPECT_EQ(read(0x03, some).readable(), Readable::too_short);
    EXPECT_EQ(read(0x03, some).message()->name, "euler");
    EXPECT_EQ(read(0x03, some).fixed_size(), 7u);
    const support::Bytes mode7{7, 0, 0, 0, 0, 0};
    EXPECT_EQ(read(0x34, mode7).readable(), Readable::unknown_layout);
    EXPECT_EQ(read(0x51, mode7).readable(), Readable::unknown_layout);
    EXPECT_EQ(read(0xF0, mode7).readable(), Readable::unknown_layout);
    EXPECT_EQ(read(0x34, support::Bytes{}).readable(), Readable::too_short);
    EXPECT_EQ(read(0xF1, some).readable(), Readable::unknown_layout);
}

TEST(Reading, keeps_the_bytes_after_the_layout_as_extra) {
    const support::Bytes data{1, 2, 3, 4, 5};    // the form in which old devices report the number of their commands
    const Reading reading = read(0xC1, data);
    ASSERT_TRUE(reading);
    EXPECT_TRUE(reading.message()->is_base());
    ASSERT_EQ(reading.extra().size(), 2u);
    EXPECT_EQ(reading.extra()[0], 4);
}

// Other bytes may precede the fields, as on some devices.
TEST(Reading, of_a_periodic_message_accepts_only_the_lengths_of_its_layouts) {
    for (const Message& row : messages)
        for (std::size_t more = 1; more < 12; ++more) {
            if (!row.is_base() || is_flexible(row.id)) continue;
            support::Bytes data(row.fixed_size + more);
            if (row.selective)
                data[0] = static_cast<std::uint8_t>(row.fields().front().selects ? row.fields().front().selects->first : 0);
            const bool is_stream = row.traffic.replaces != Replaces::nothing && !row.is_open();
            const bool has_variant = std::any_of(messages.begin(), messages.end(), [&](const Message& other) {
                return other.id == row.id && other.variant.length == data.size();
            });
            if (has_variant || row.variant.length != 0) continue;
            EXPECT_EQ(read(row.id, data).readable() == Readable::unknown_layout, is_stream) << row.name << ' ' << data.size();
        }
    const support::Bytes air = support::frame(0xDC, 0xFE, 0x06, {1, 0, 2, 0, 0, 0});
    EXPECT_FALSE(as<"mode">(FrameView{air}));
    const support::Bytes stored = support::frame(0xDC, 0xFE, 0x61, support::Bytes(23));
    EXPECT_TRUE(as<"waypoint">(FrameView{stored})) << "what is asked for may be longer";
}

// If the layouts of a message have their fields at different offsets, a third length could be any of them.
TEST(Reading, never_has_shifted_fields) {
    const auto readable = [](std::uint8_t id, std::size_t size, std::uint8_t first = 1) {
        support::Bytes data(size);
        if (size > 0) data[0] = first;
        return read(id, data).readable();
    };
    struct Lengths {
        std::uint8_t id;
        std::vector<std::size_t> known;
    };
    for (const auto& [id, known] : {Lengths{0x02, {9, 14}}, {0x03, {7, 8}}, {0x05, {9, 13}}, {0x34, {5, 7}}}) {
        const std::size_t base = layouts_of(id).front().fixed_size;
        for (std::size_t size = 0; size < 40; ++size) {
            const bool is_known = std::find(known.begin(), known.end(), size) != known.end();
            const Readable expected = is_known ? Readable::yes : size < base ? Readable::too_short : Readable::unknown_layout;
            EXPECT_EQ(readable(id, size), expected) << +id << " with " << size;
        }
    }
    EXPECT_EQ(readable(0x03, 8, 0), Readable::unknown_layout);
    EXPECT_EQ(readable(0x03, 8, 2), Readable::unknown_layout);
}

TEST(Reading, of_euler_angles_with_a_mode_returns_the_angles) {
    const support::Bytes data{1, 0x7B, 0x00, 0x29, 0xEE, 0x4F, 0x46, 2};
    const Reading reading = read(0x03, data);
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading.message()->variant.label, "field");
    EXPECT_EQ(reading.number(*reading.field("rol")), 1.23);
    EXPECT_EQ(reading.number(*reading.field("pit")), -45.67);
    EXPECT_EQ(reading.number(*reading.field("yaw")), 179.99);
    EXPECT_EQ(reading.number(*reading.field("fusion_sta")), 2);
}

TEST(Reading, of_a_list_has_its_complete_elements_and_the_remaining_bytes_as_extra) {
    const support::Bytes data{100, 0x39, 0x30, 1, 0, 0x10, 0x27, 2, 0, 9, 8, 7};
    const Reading reading = read(0x34, data);
    ASSERT_TRUE(reading);
    ASSERT_EQ(reading.element_count(), 2u);
    ASSERT_EQ(reading.element_fields().size(), 2u);
    EXPECT_EQ(std::get<double>(reading.element(0, reading.element_fields()[0])), 123.45);
    EXPECT_EQ(std::get<double>(reading.element(1, reading.element_fields()[0])), 100.0);
    EXPECT_EQ(std::get<std::int64_t>(reading.element(1, reading.element_fields()[1])), 2);
    EXPECT_EQ(reading.extra().size(), 3u);
}

TEST(Reading, prefers_the_mode_to_the_length) {
    const support::Bytes data{100, 1, 0, 2, 0, 9, 9};    // the length of the field variant
    EXPECT_EQ(read(0x34, data).message()->variant.label, "scan");
}

// The oldest devices put min and max (i32 each) in place of par_type.
TEST(Reading, recognizes_an_old_parameter_info_by_its_content) {
    const auto info = [](std::uint8_t par_type, support::Bytes min_rest, std::string_view name, std::size_t size) {
        support::Bytes data{1, 0, par_type};
        data.insert(data.end(), min_rest.begin(), min_rest.end());
        data.insert(data.end(), name.begin(), name.end());
        data.resize(size);
        return std::string{read(0xE2, data).message()->variant.label};
    };
    const support::Bytes small{0, 0, 0, 100, 0, 0, 0};
    const support::Bytes minus{0xFF, 0xFF, 0xFF, 100, 0, 0, 0};
    EXPECT_EQ(info(0, small, "ROL", 30), "old");
    EXPECT_EQ(info(8, small, "ROL", 34), "old");
    EXPECT_EQ(info(0x9C, minus, "\xBD\xE2", 30), "old");    // GBK
    EXPECT_EQ(info(8, {}, "ROL", 23), "");
    EXPECT_EQ(info(8, {}, "PARAMETER_NAME", 40), "");
    EXPECT_EQ(info(11, {}, "PARAMETER_NAME", 40), "old");    // a type that does not exist
    EXPECT_EQ(info(11, {}, "SHORT", 40), "");                // with a name at the offset of the current layout
    EXPECT_EQ(info(8, {}, "", 40), "");                      // without a name
    EXPECT_EQ(info(0, small, "ROL", 29), "");                // too short for the old one
}

// A generation of devices between the two has a third i32, the factor of the value.
TEST(Reading, recognizes_a_scaled_parameter_info_by_its_content) {
    const auto info = [](std::int32_t min, std::int32_t max, std::int32_t mul, std::string_view name, std::size_t size = 50) {
        support::Bytes data(14);
        data[0] = 1;
        store(data.data() + 2, min);
        store(data.data() + 6, max);
        store(data.data() + 10, mul);
        data.insert(data.end(), name.begin(), name.end());
        data.resize(size);
        return std::string{read(0xE2, data).message()->variant.label};
    };
    for (const std::int32_t mul : {0, 1, 10, 32, 100, 1000, 10'000, 65'536, 1'000'000}) {
        EXPECT_EQ(info(-100, 100, mul, "PID_P"), "scaled") << mul;
        EXPECT_EQ(info(0, 0, mul, "A_NAME_OF_20_BYTES_X"), "scaled") << mul;
        EXPECT_EQ(info(INT32_MIN, INT32_MAX, mul, "\xBD\xE2", 34), "scaled") << mul;
    }
    EXPECT_NE(info(0, 100, 100, "PID_P", 33), "scaled") << "too short";
    EXPECT_NE(info(100, -100, 100, "PID_P"), "scaled") << "no range";
    EXPECT_NE(info(0, 100, -1, "PID_P"), "scaled");
    EXPECT_NE(info(0, 100, 100'000'000, "PID_P"), "scaled");
    EXPECT_EQ(info(0, 100, 0x504950, "", 60), "old") << "PIP is a name, no factor";
}

TEST(Reading, returns_nothing_for_no_data_and_nan_as_its_number) {
    const support::Bytes data{0, 0, 0, 0x80, 1, 0, 0, 0, 2, 0, 0, 0};
    const Reading reading = read(0x32, data);
    EXPECT_TRUE(std::holds_alternative<Nothing>(reading.value(reading.fields()[0])));
    EXPECT_TRUE(std::isnan(reading.number(reading.fields()[0])));
    EXPECT_EQ(reading.number(reading.fields()[1]), 1.0);
}

// On the heap with exactly its size, so that a sanitizer detects a read after its end.
TEST(Reading, of_any_id_and_any_length_stays_within_its_data) {
    support::Random random{1};
    for (unsigned id = 0; id < 256; ++id) {
        for (std::size_t size = 0; size < 48; ++size) {
            const auto data = std::make_unique<std::uint8_t[]>(size);
            for (std::size_t i = 0; i < size; ++i)
                data[i] = random.one_in(2) ? random.of<std::uint8_t>({0, 1, 2, 16, 100}) : random.byte();
            const Reading reading = read(static_cast<std::uint8_t>(id), {data.get(), size});
            if (!reading) continue;
            std::size_t seen = 0;
            for (const Field& f : reading.fields()) {
                seen += reading.bytes_of(f).size();
                std::visit([](const auto& v) { static_cast<void>(v); }, reading.value(f));
            }
            for (std::size_t i = 0; i < reading.element_count(); ++i)
                for (const Field& f : reading.element_fields()) reading.element(i, f);
            EXPECT_EQ(seen + reading.extra().size(), size) << id;
        }
    }
}

}    // namespace
}    // namespace reading_tests
