#include <gateway/channel.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>

using namespace anogate;

TEST(Channel, received_is_what_the_parser_and_the_gateway_counted) {
    Channel channel{{}, {}, "", {}, {}, {}};
    channel.routed.no_route = 2;
    channel.routed.looped = 1;
    const auto bytes = support::frame(0xDC, 0xFE, 0x03, {1, 2, 3});
    auto room = channel.parser.prepare();
    room[0] = 0x55;
    std::copy(bytes.begin(), bytes.end(), room.begin() + 1);
    channel.parser.commit(bytes.size() + 1, {});
    while (channel.parser.next()) {}
    const ReceiveCounters all = channel.received();
    EXPECT_EQ(all.frames_in, 1u);
    EXPECT_EQ(all.bytes_in, bytes.size() + 1);
    EXPECT_EQ(all.skipped_bytes, 1u);
    EXPECT_EQ(all.no_route, 2u);
    EXPECT_EQ(all.looped, 1u);
}
