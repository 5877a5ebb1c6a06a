#include <gtest/gtest.h>
#include <ano/crc16.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <string_view>

namespace crc16_tests {
namespace {

using namespace ano;

// The check value for these nine digits in the catalogue of CRCs.
constexpr std::array<std::uint8_t, 9> digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
static_assert(crc16_of(digits) == 0x29B1);

TEST(Crc16, matches_the_check_values_of_the_catalogue) {
    const std::map<std::string_view, std::uint16_t> check{{"crc16/ibm-3740", 0x29B1},
                                                          {"crc16/xmodem", 0x31C3},
                                                          {"crc16/kermit", 0x2189},
                                                          {"crc16/modbus", 0x4B37},
                                                          {"crc16/arc", 0xBB3D}};
    EXPECT_EQ(crcs16.size(), check.size());
    for (const auto& [name, value] : check) {
        const auto crc = find_crc16(name);
        ASSERT_TRUE(crc) << name;
        EXPECT_EQ(crc16_of(digits, *crc), value) << name;
    }
    EXPECT_FALSE(find_crc16("crc16/none"));
}

}    // namespace
}    // namespace crc16_tests
