#include <gtest/gtest.h>
#include <ros/cdr_encoder.hpp>

#include <string>
#include <vector>

#include <support/bytes.hpp>

namespace cdr_encoder_tests {
namespace {

using namespace anogate;
using ano::Value;
using Shape = RosField::Shape;

std::string bytes(std::string_view digits) {
    const support::Bytes data = support::hex(digits);
    return {data.begin(), data.end()};
}

std::string cdr(const RosMessage& message, const std::vector<Value>& values) {
    CdrEncoder encoder;
    return std::string{encoder.encode(message, values)};
}

RosMessage message_of(std::vector<RosField> fields) {
    return {.package = "p", .name = "M", .comment = {}, .fields = std::move(fields)};
}

RosField field(RosType type, Shape shape = Shape::one, std::size_t count = 1) {
    return {.type = type, .name = "f", .shape = shape, .count = count};
}

TEST(CdrEncoder, numbers_are_aligned_to_multiples_of_their_size_after_the_header) {
    const RosMessage m = message_of({field(RosType::uint8), field(RosType::int16), field(RosType::uint8), field(RosType::float64),
                                     field(RosType::uint8), field(RosType::uint32), field(RosType::float32),
                                     field(RosType::boolean)});
    EXPECT_EQ(
        cdr(m, {std::int64_t{1}, std::int64_t{-2}, std::int64_t{3}, 1.0, std::int64_t{4}, std::int64_t{5}, 0.5, std::int64_t{7}}),
        bytes("00 01 00 00  01 00 FE FF 03 00 00 00  00 00 00 00 00 00 F0 3F  04 00 00 00 05 00 00 00  00 00 00 3F 01"));
}

TEST(CdrEncoder, text_has_a_length_that_includes_the_nul) {
    const RosMessage m = message_of({field(RosType::text), field(RosType::text), field(RosType::int8)});
    EXPECT_EQ(cdr(m, {Value{std::string_view{"ab"}}, Value{std::string_view{}}, Value{std::int64_t{-1}}}),
              bytes("00 01 00 00  03 00 00 00 61 62 00 00  01 00 00 00 00 FF"));
}

TEST(CdrEncoder, a_sequence_has_a_count_and_an_array_has_none) {
    const support::Bytes two{1, 2};
    const RosMessage m = message_of({field(RosType::uint8, Shape::sequence), field(RosType::uint8, Shape::array, 3),
                                     field(RosType::uint16, Shape::array, 2), field(RosType::float64, Shape::sequence)});
    EXPECT_EQ(
        cdr(m, {Value{ano::Bytes{two}}, Value{ano::Bytes{two}}, std::int64_t{4}, std::int64_t{5}, std::uint64_t{1}, 1.0}),
        bytes("00 01 00 00  02 00 00 00 01 02  01 02 00 00  04 00 05 00 00 00 01 00 00 00 00 00 00 00  00 00 00 00 00 00 F0 3F"));
    // Absent elements need no alignment.
    EXPECT_EQ(
        cdr(message_of({field(RosType::float64, Shape::sequence), field(RosType::uint8)}), {std::uint64_t{0}, std::int64_t{9}}),
        bytes("00 01 00 00  00 00 00 00 09"));
}

TEST(CdrEncoder, an_array_can_be_passed_as_bytes) {
    const support::Bytes three{1, 0, 2};
    EXPECT_EQ(cdr(message_of({field(RosType::uint8), field(RosType::uint16, Shape::array, 2), field(RosType::uint8)}),
                  {std::int64_t{9}, Value{ano::Bytes{three}}, std::int64_t{8}}),
              bytes("00 01 00 00  09 00 01 00 02 00 08"));
}

TEST(CdrEncoder, an_array_is_truncated_to_its_size) {
    const support::Bytes three{1, 2, 3};
    EXPECT_EQ(cdr(message_of({field(RosType::uint8, Shape::array, 2)}), {Value{ano::Bytes{three}}}), bytes("00 01 00 00 01 02"));
}

TEST(CdrEncoder, a_nested_message_has_no_header_and_no_separate_alignment) {
    const RosMessage inner = message_of({field(RosType::uint8), field(RosType::uint16)});
    RosField list = field(RosType::message, Shape::sequence), one = field(RosType::message);
    list.message = one.message = &inner;
    EXPECT_EQ(cdr(message_of({list, one}), {std::uint64_t{2}, std::int64_t{1}, std::int64_t{2}, std::int64_t{3}, std::int64_t{4},
                                            std::int64_t{5}, std::int64_t{6}}),
              bytes("00 01 00 00  02 00 00 00  01 00 02 00  03 00 04 00  05 00 06 00"));
}

TEST(CdrEncoder, a_message_without_fields_is_one_byte) {
    EXPECT_EQ(cdr(message_of({}), {}), bytes("00 01 00 00 00"));
    EXPECT_EQ(definition_of(message_of({})), "uint8 structure_needs_at_least_one_member\n");
}

TEST(CdrEncoder, missing_values_are_encoded_as_nan_zero_or_empty) {
    EXPECT_EQ(cdr(message_of({field(RosType::float64), field(RosType::int8), field(RosType::text)}), {}),
              bytes("00 01 00 00  00 00 00 00 00 00 F8 7F  00 00 00 00  01 00 00 00 00"));
    EXPECT_EQ(cdr(message_of({field(RosType::uint16, Shape::sequence)}), {std::uint64_t{0xFFFFFFFF}, std::int64_t{1}}),
              bytes("00 01 00 00  01 00 00 00 01 00"));
}

TEST(CdrEncoder, a_short_message_after_a_long_one_contains_no_bytes_of_it) {
    CdrEncoder encoder;
    const support::Bytes many(100, 0xEE);
    encoder.encode(message_of({field(RosType::uint8, Shape::array, 100)}), std::vector<Value>{Value{ano::Bytes{many}}});
    EXPECT_EQ(encoder.encode(message_of({field(RosType::uint8), field(RosType::uint32)}),
                             std::vector<Value>{std::int64_t{1}, std::int64_t{2}}),
              bytes("00 01 00 00  01 00 00 00 02 00 00 00"));
}

}    // namespace
}    // namespace cdr_encoder_tests
