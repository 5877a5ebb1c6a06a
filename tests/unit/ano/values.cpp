#include <gtest/gtest.h>
#include <ano/messages.hpp>
#include <ano/values.hpp>

namespace values_tests {
namespace {

using namespace ano;

TEST(Values, parameter_types_match_the_table) {
    const Field& f = *find_message("parameter_info")->field("par_type");
    for (std::uint64_t value = 0; value < 10; ++value) EXPECT_EQ(name_of(*parameter_type(value)), f.meaning(value));
    EXPECT_EQ(parameter_type(10), Type::text);
    EXPECT_EQ(parameter_type(11), std::nullopt);
    EXPECT_EQ(parameter_type(255), std::nullopt);
}

TEST(Values, command_value_types_match_the_table_except_for_7) {
    const Field& f = *find_message("command_info")->field("val_type");
    for (const ValueType7 seven : {ValueType7::f32, ValueType7::u64})
        for (std::uint64_t value = 1; value <= 10; ++value)
            if (value != 7) {
                EXPECT_EQ(name_of(*command_value_type(value, seven)), f.meaning(value));
            }
    EXPECT_EQ(command_value_type(7, ValueType7::f32), Type::f32);
    EXPECT_EQ(command_value_type(7, ValueType7::u64), Type::u64);
    EXPECT_EQ(command_value_type(0, ValueType7::f32), std::nullopt);
    EXPECT_EQ(command_value_type(11, ValueType7::f32), std::nullopt);
}

TEST(Values, of_a_parameter_need_all_bytes_of_their_type) {
    for (const Type type : {Type::u8, Type::i16, Type::f32, Type::f64}) {
        EXPECT_FALSE(is_whole_value(width(type) - 1, type));
        EXPECT_TRUE(is_whole_value(width(type), type));
        EXPECT_TRUE(is_whole_value(width(type) + 1, type));
    }
    EXPECT_TRUE(is_whole_value(3, Type::text));
    EXPECT_FALSE(is_whole_value(0, Type::text));
    for (std::size_t size = 0; size < 12; ++size)
        EXPECT_EQ(is_whole_value(size, std::nullopt), size == 1 || size == 2 || size == 4 || size >= 8) << size;
}

}    // namespace
}    // namespace values_tests
