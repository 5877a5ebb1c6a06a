// Codes of a firmware upgrade in both byte orders: each is recognised by its bytes and the length of its frame.
#include <ano/firmware_codes.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace firmware_codes_tests {
namespace {

using namespace ano;
using support::Bytes;

constexpr std::uint16_t all_codes[]{0x0101, 0x0102, 0x0110, 0x0111, 0x0112, 0x1001, 0x1002, 0x1010, 0x1011, 0x1012};

bool reads_the_same(std::uint16_t code) { return code >> 8 == (code & 0xFF); }

TEST(FirmwareCodes, are_recognised_in_both_byte_orders) {
    for (const std::uint16_t code : all_codes)
        for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
            const auto low = static_cast<std::uint8_t>(code), high = static_cast<std::uint8_t>(code >> 8);
            Bytes data = order == ByteOrder::big ? Bytes{0, high, low} : Bytes{0, low, high};
            const bool is_of_frame = code == firmware_code::frame_failed || code == firmware_code::frame_written;
            if (is_of_frame) data.insert(data.end(), {7, 1});
            const auto bytes = support::frame(1, 2, 0xF0, data);
            const auto found = firmware_code_in(FrameView{bytes});
            ASSERT_TRUE(found) << code;
            EXPECT_EQ(found->code, code);
            EXPECT_EQ(found->order, reads_the_same(code) ? ByteOrder::little : order) << code;
            EXPECT_EQ(found->is_of_frame, is_of_frame) << code;
            EXPECT_EQ(found->frame_num, is_of_frame ? 0x0107 : 0) << code;
            if (is_of_frame) continue;
            std::array<std::uint8_t, 11> out{};
            EXPECT_EQ(firmware_step(code, order).encode(out, 1, 2), 11u);
            EXPECT_TRUE(std::equal(out.begin(), out.end(), bytes.begin())) << code;
        }
}

TEST(FirmwareCodes, return_unknown_codes_unchanged) {
    const auto unknown = support::frame(1, 2, 0xF0, {0, 0x07, 0x03});
    ASSERT_TRUE(firmware_code_in(FrameView{unknown}));
    EXPECT_EQ(firmware_code_in(FrameView{unknown})->code, 0x0307);
    const auto info = support::frame(1, 2, 0xF0, Bytes(20, 1));
    EXPECT_FALSE(firmware_code_in(FrameView{info}));
    const auto no_number = support::frame(1, 2, 0xF0, {0, 0x02, 0x10});
    EXPECT_FALSE(firmware_code_in(FrameView{no_number})) << "malformed";
}

}    // namespace
}    // namespace firmware_codes_tests
