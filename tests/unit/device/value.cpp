#include <gtest/gtest.h>
#include <device/value.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace value_tests {
namespace {

using namespace ano::device;
using ano::Type;

static_assert(type_of<std::uint8_t> == Type::u8 && type_of<std::int64_t> == Type::i64 && type_of<float> == Type::f32);
static_assert(type_of<long long> == Type::i64 && type_of<double> == Type::f64 && type_of<std::string> == Type::text);
static_assert(Wire<std::uint64_t> && WireNumber<float> && !WireNumber<std::string>);
static_assert(!Wire<bool> && !Wire<const char*> && !Wire<long double>);

template <class T>
void comes_back(T value) {
    std::vector<std::uint8_t> bytes;
    append_value(bytes, type_of<T>, to_value(value));
    EXPECT_EQ(bytes.size(), sizeof(T));
    const Value read = read_value(type_of<T>, bytes);
    EXPECT_EQ(read, to_value(value));
    EXPECT_EQ(from_value<T>(read), value);
    EXPECT_TRUE(fits(read, type_of<T>));
}

template <class T>
void comes_back_at_its_ends() {
    comes_back(std::numeric_limits<T>::lowest());
    comes_back(std::numeric_limits<T>::max());
    comes_back(T{1});
    EXPECT_EQ(range_of(type_of<T>).first, to_value(std::numeric_limits<T>::lowest()));
    EXPECT_EQ(zero_of(type_of<T>), to_value(T{}));
}

TEST(Value, of_every_number_type_reads_back_unchanged) {
    comes_back_at_its_ends<std::uint8_t>();
    comes_back_at_its_ends<std::int8_t>();
    comes_back_at_its_ends<std::uint16_t>();
    comes_back_at_its_ends<std::int16_t>();
    comes_back_at_its_ends<std::uint32_t>();
    comes_back_at_its_ends<std::int32_t>();
    comes_back_at_its_ends<std::uint64_t>();
    comes_back_at_its_ends<std::int64_t>();
    comes_back_at_its_ends<float>();
    comes_back_at_its_ends<double>();
    comes_back(0.1f);
    comes_back(0.1);
}

TEST(Value, of_text_ends_with_its_first_nul) {
    const std::array<std::uint8_t, 5> bytes{'a', 'b', 0, 'c', 'd'};
    EXPECT_EQ(read_value(Type::text, bytes), Value{std::string{"ab"}});
    EXPECT_EQ(read_value(Type::text, ano::Bytes{bytes}.first(1)), Value{std::string{"a"}});
    std::vector<std::uint8_t> out;
    append_value(out, Type::text, std::string{});
    EXPECT_EQ(out, std::vector<std::uint8_t>{0}) << "a value is never of no bytes";
}

TEST(Value, fits_only_its_type) {
    EXPECT_TRUE(fits(std::int64_t{255}, Type::u8));
    EXPECT_FALSE(fits(std::int64_t{256}, Type::u8));
    EXPECT_FALSE(fits(std::int64_t{-1}, Type::u8));
    EXPECT_FALSE(fits(std::int64_t{1}, Type::u64)) << "which is another alternative";
    EXPECT_FALSE(fits(1.0, Type::u8));
    EXPECT_FALSE(fits(1e300, Type::f32));
    EXPECT_FALSE(fits(std::nan(""), Type::f64));
    EXPECT_TRUE(fits(std::string{"x"}, Type::text));
    EXPECT_FALSE(fits(std::string{"x"}, Type::f32));
}

TEST(Value, is_limited_to_the_i32_of_the_oldest_devices) {
    EXPECT_EQ(as_i32(std::int64_t{-5}), -5);
    EXPECT_EQ(as_i32(std::int64_t{1} << 40), INT32_MAX);
    EXPECT_EQ(as_i32(UINT64_MAX), INT32_MAX);
    EXPECT_EQ(as_i32(-1e10), INT32_MIN);
    EXPECT_EQ(as_i32(2.5), 3);
    EXPECT_EQ(as_i32(std::nan("")), 0);
    EXPECT_EQ(as_i32(std::string{"7"}), 0);
    EXPECT_EQ(from_i32(Type::u8, 300), Value{std::int64_t{255}});
    EXPECT_EQ(from_i32(Type::u64, -1), Value{std::uint64_t{0}});
    EXPECT_EQ(from_i32(Type::f32, 7), Value{7.0});
}

}    // namespace
}    // namespace value_tests
