#include <gtest/gtest.h>
#include <ano/wire.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace wire_tests {
namespace {

using namespace ano;
constexpr Shape u8{Type::u8}, i16{Type::i16}, u16{Type::u16}, u64{Type::u64}, i64{Type::i64}, f32{Type::f32}, f64{Type::f64};

constexpr std::array<std::uint8_t, 8> counting{1, 2, 3, 4, 5, 6, 7, 0x88};
static_assert(load<std::uint16_t>(counting.data()) == 0x0201);
static_assert(load<std::uint32_t>(counting.data()) == 0x04030201);
static_assert(load<std::int64_t>(counting.data()) < 0);

static_assert(load<std::uint16_t>(counting.data(), ByteOrder::big) == 0x0102);
static_assert(load<std::int32_t>(counting.data() + 4, ByteOrder::big) == 0x05060788);

struct At {
    std::array<std::uint8_t, 8> bytes{0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE};
    Stored put(const Field& f, Number n) { return store_number(f, n, bytes.data()); }
};

TEST(Wire, loads_the_same_at_compile_time_and_at_run_time) {
    constexpr auto expected = load<double>(counting.data());
    auto copy = counting;
    EXPECT_EQ(load<double>(copy.data()), expected);
}

TEST(Wire, a_field_may_have_its_high_byte_first) {
    constexpr Field hundredth{"f", i16, times(100)};
    constexpr Field integer{"f", u64};
    constexpr Field number{"f", f64};
    Field scaled = hundredth, whole = integer, real = number;
    scaled.order = whole.order = real.order = ByteOrder::big;
    At at;
    EXPECT_EQ(at.put(scaled, 2.58), Stored::ok);
    EXPECT_EQ(at.bytes[0], 1);
    EXPECT_EQ(at.bytes[1], 2);
    EXPECT_EQ(at.put(whole, std::uint64_t{0x0102030405060788}), Stored::ok);
    EXPECT_EQ(at.bytes, counting);
    EXPECT_EQ(at.put(real, 1.5), Stored::ok);
    EXPECT_EQ(load<double>(at.bytes.data(), ByteOrder::big), 1.5);
    EXPECT_EQ(at.bytes[0], 0x3F);
}

TEST(Wire, every_scaled_i16_survives_conversion_to_its_unit_and_back) {
    for (const Scale scale : {Scale{100, 1}, Scale{10, 1}, Scale{10000, 1}, Scale{32768, 2000}, Scale{1, 100}}) {
        Field f{"f", i16};
        f.scale = scale;
        for (int v = -32768; v <= 32767; ++v) {
            At at;
            const double value = v * scale.value / scale.wire;
            ASSERT_EQ(at.put(f, value), Stored::ok);
            ASSERT_EQ(load<std::int16_t>(at.bytes.data()), v);
        }
    }
}

TEST(Wire, rejects_values_that_the_type_cannot_hold_and_writes_nothing) {
    constexpr Field byte{"b", u8};
    constexpr Field angle{"a", i16, times(100)};
    At at;
    EXPECT_EQ(at.put(byte, std::int64_t{256}), Stored::out_of_range);
    EXPECT_EQ(at.put(byte, std::int64_t{-1}), Stored::out_of_range);
    EXPECT_EQ(at.put(byte, 254.5), Stored::not_whole);
    EXPECT_EQ(at.put(byte, std::nan("")), Stored::out_of_range);
    EXPECT_EQ(at.put(byte, std::numeric_limits<double>::infinity()), Stored::out_of_range);
    EXPECT_EQ(at.put(byte, 1e300), Stored::out_of_range);
    EXPECT_EQ(at.put(angle, 327.68), Stored::out_of_range);
    EXPECT_EQ(at.put(angle, std::int64_t{328}), Stored::out_of_range);
    EXPECT_EQ(at.put(angle, std::numeric_limits<std::uint64_t>::max()), Stored::out_of_range);
    EXPECT_EQ(at.bytes, At{}.bytes);
    EXPECT_EQ(at.put(byte, 255.0), Stored::ok);
    EXPECT_EQ(at.put(angle, -327.68), Stored::ok);
    EXPECT_EQ(load<std::int16_t>(at.bytes.data()), -32768);
}

TEST(Wire, integers_of_64_bits_are_exact) {
    constexpr Field whole{"u", u64};
    constexpr Field with_sign{"i", i64};
    At at;
    EXPECT_EQ(at.put(whole, std::numeric_limits<std::uint64_t>::max()), Stored::ok);
    EXPECT_EQ(load<std::uint64_t>(at.bytes.data()), std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(at.put(with_sign, std::numeric_limits<std::uint64_t>::max()), Stored::out_of_range);
    EXPECT_EQ(at.put(with_sign, std::numeric_limits<std::int64_t>::min()), Stored::ok);
    EXPECT_EQ(load<std::int64_t>(at.bytes.data()), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(at.put(with_sign, 9223372036854775808.0), Stored::out_of_range);
    EXPECT_EQ(at.put(whole, 18446744073709551616.0), Stored::out_of_range);
    EXPECT_EQ(at.put(whole, 9223372036854775808.0), Stored::ok);
}

TEST(Wire, floats_accept_infinity_and_nan_but_no_overflow) {
    constexpr Field single{"f", f32};
    At at;
    EXPECT_EQ(at.put(single, 1e39), Stored::out_of_range);
    EXPECT_EQ(at.put(single, -std::numeric_limits<double>::infinity()), Stored::ok);
    EXPECT_EQ(load<float>(at.bytes.data()), -std::numeric_limits<float>::infinity());
    EXPECT_EQ(at.put(single, std::nan("")), Stored::ok);
    EXPECT_TRUE(std::isnan(load<float>(at.bytes.data())));
}

TEST(Wire, no_data_is_the_sentinel_or_nan) {
    constexpr Field speed{"s", i16, NoData{INT16_MIN}};
    constexpr Field plain{"p", u16};
    constexpr Field real{"r", f64};
    At at;
    EXPECT_FALSE(store_no_data(plain, at.bytes.data()));
    EXPECT_EQ(at.bytes, At{}.bytes);
    EXPECT_TRUE(store_no_data(speed, at.bytes.data()));
    EXPECT_EQ(load<std::int16_t>(at.bytes.data()), INT16_MIN);
    EXPECT_TRUE(store_no_data(real, at.bytes.data()));
    EXPECT_TRUE(std::isnan(load<double>(at.bytes.data())));
}

TEST(Wire, limits_are_returned_in_the_unit) {
    constexpr Field angle{"a", i16, times(100)};
    EXPECT_EQ(limits_of(angle), (std::pair{-327.68, 327.67}));
    constexpr Field precision{"p", u8, times(1, 100)};
    EXPECT_EQ(limits_of(precision), (std::pair{0.0, 25500.0}));
}

}    // namespace
}    // namespace wire_tests
