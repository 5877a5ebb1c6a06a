#include <ros2/rtps_message.hpp>

#include <gtest/gtest.h>

#include <string>
#include <support/bytes.hpp>

namespace rtps_message_tests {
namespace {

using anogate::valid_part;
using support::Bytes;

constexpr std::uint8_t info_timestamp = 0x09, heartbeat = 0x07, data = 0x15, statistics = 0x80, extension = 0x00;
constexpr std::size_t header_size = 20;

Bytes header() {
    Bytes bytes{'R', 'T', 'P', 'S', 2, 3, 1, 15};
    bytes.resize(header_size);
    return bytes;
}

void append(Bytes& message, std::uint8_t id, std::size_t size, bool little_endian = true) {
    const auto low = static_cast<std::uint8_t>(size), high = static_cast<std::uint8_t>(size >> 8);
    message.insert(message.end(), {id, static_cast<std::uint8_t>(little_endian ? 1 : 0), little_endian ? low : high,
                                   little_endian ? high : low});
    message.resize(message.size() + size);
}

TEST(RtpsMessage, complete_submessages_of_either_byte_order_are_valid) {
    Bytes message = header();
    append(message, info_timestamp, 8);
    append(message, data, 300, false);
    append(message, extension, 4);
    append(message, heartbeat, 28);
    EXPECT_EQ(valid_part(message), message.size());
}

TEST(RtpsMessage, a_length_of_0_extends_the_last_submessage_to_the_end) {
    Bytes message = header();
    append(message, data, 0);
    message.resize(message.size() + 70'000);
    EXPECT_EQ(valid_part(message), message.size());
    message.resize(header_size + 4 + 19);    // less than DATA has
    EXPECT_EQ(valid_part(message), 0u);
}

TEST(RtpsMessage, submessages_of_vendors_end_the_valid_part) {
    Bytes message = header();
    append(message, heartbeat, 28);
    const std::size_t size = message.size();
    append(message, statistics, 4);
    append(message, heartbeat, 28);
    EXPECT_EQ(valid_part(message), size);
}

TEST(RtpsMessage, incomplete_and_too_short_ones_end_it_too) {
    Bytes message = header();
    append(message, heartbeat, 28);
    const std::size_t size = message.size();
    append(message, heartbeat, 27);
    EXPECT_EQ(valid_part(message), size);
    message.resize(size);
    append(message, data, 40);
    for (std::size_t cut = size; cut < message.size(); ++cut) EXPECT_EQ(valid_part(std::span{message}.first(cut)), size);
}

TEST(RtpsMessage, nothing_of_other_datagrams_is_valid) {
    EXPECT_EQ(valid_part({}), 0u);
    EXPECT_EQ(valid_part(header()), 0u);
    Bytes message = header();
    append(message, heartbeat, 28);
    for (const std::size_t at : {0u, 1u, 2u, 3u, 4u}) {
        Bytes other = message;
        other[at] ^= 1;
        EXPECT_EQ(valid_part(other), 0u);
    }
}

}    // namespace
}    // namespace rtps_message_tests
