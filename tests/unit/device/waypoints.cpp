#include <gtest/gtest.h>
#include <device/device.hpp>

#include "talk.hpp"

namespace waypoints_tests {
namespace {

using ano::device::Device;
using ano::device::Waypoint;
using ano::device::Waypoints;
using namespace talk;
using support::operator+;

Bytes written(std::uint8_t number) {
    return ask(0x61, Bytes{number} + support::hex("15 CD 5B 45 B1 68 DE 17 E8 03 00 00 F4 01 90 01 02 0A 14 1E 28"));
}
Bytes read_number(std::uint8_t number) { return ask(0x60, {number}); }
Bytes count() { return read_number(0xFF); }

TEST(Waypoints, are_written_in_order_counted_and_read) {
    Device device{{.id = self}};
    device.waypoints().allow(3);
    EXPECT_EQ(answer(device, count()), expected_reply(0x60, {0}));
    for (const std::uint8_t number : Bytes{0, 1, 2}) EXPECT_EQ(answer(device, written(number)), acknowledges(written(number)));
    EXPECT_EQ(answer(device, count()), expected_reply(0x60, {3}));
    Bytes expected = written(1);
    EXPECT_EQ(answer(device, read_number(1)), expected_reply(0x61, Bytes(expected.begin() + 6, expected.end() - 2)));
    const Waypoint& w = device.waypoints()[1];
    EXPECT_DOUBLE_EQ(w.lng, 116.3644181);
    EXPECT_EQ(w.alt, 1000);
    EXPECT_EQ(w.spd, 500);
    EXPECT_EQ(w.yaw, 400);
    EXPECT_EQ(w.fun, 2);
    EXPECT_EQ(w.cmd, (std::array<std::uint8_t, 4>{10, 20, 30, 40}));
}

TEST(Waypoints, leave_no_gap_and_end_at_the_allowed_count) {
    Device device{{.id = self}};
    device.waypoints().allow(2);
    EXPECT_EQ(answer(device, written(1)), silence) << "0 comes first";
    EXPECT_NE(answer(device, written(0)), silence);
    EXPECT_NE(answer(device, written(0)), silence) << "again";
    EXPECT_NE(answer(device, written(1)), silence);
    EXPECT_EQ(answer(device, written(2)), silence);
    EXPECT_EQ(answer(device, written(255)), silence);
    EXPECT_EQ(answer(device, read_number(2)), silence);
    EXPECT_EQ(answer(device, read_number(254)), silence);
    EXPECT_EQ(device.waypoints().count(), 2u);
}

TEST(Waypoints, of_a_device_without_them_get_no_response) {
    Device device{{.id = self}};
    for (const auto& frame : {count(), read_number(0), written(0)}) EXPECT_EQ(answer(device, frame), silence);
    EXPECT_EQ(device.counters().unknown, 3u);
}

TEST(Waypoints, that_are_too_short_are_not_stored) {
    Device device{{.id = self}};
    device.waypoints().allow(2);
    EXPECT_EQ(answer(device, ask(0x61, Bytes(21))), silence);
    EXPECT_EQ(answer(device, ask(0x60, {})), silence);
    EXPECT_EQ(device.counters().malformed, 2u);
    EXPECT_EQ(device.waypoints().count(), 0u);
}

TEST(Waypoints, may_be_refused_by_the_user) {
    Device device{{.id = self}};
    device.waypoints().allow(2);
    device.waypoints().on_write([](std::size_t number, const Waypoint& w) { return number == 0 && w.alt < 2000; });
    EXPECT_NE(answer(device, written(0)), silence);
    EXPECT_EQ(answer(device, written(1)), silence);
    EXPECT_EQ(device.counters().refused, 1u);
    EXPECT_EQ(device.waypoints().count(), 1u);
}

// A message with 255 of them would equal the question for their number.
TEST(Waypoints, are_limited_so_that_their_count_never_equals_a_request) {
    Device device{{.id = self}};
    device.waypoints().allow(1000);
    device.waypoints().resize(1000);
    EXPECT_EQ(answer(device, count()), expected_reply(0x60, {254}));
    EXPECT_EQ(answer(device, written(254)), silence);
    device.waypoints().allow(1);
    EXPECT_EQ(device.waypoints().count(), 1u);
}

TEST(Waypoints, can_be_set_by_the_program) {
    Device device{{.id = self}};
    device.waypoints().allow(1);
    device.waypoints().resize(1);
    device.waypoints().set(0, {.lng = 1e-7, .lat = -90, .alt = -1});
    EXPECT_EQ(answer(device, read_number(0)),
              expected_reply(0x61, support::hex("00 01 00 00 00 00 17 5B CA FF FF FF FF") + Bytes(9)));
    device.waypoints().set(0, {.lng = 400});
    EXPECT_EQ(answer(device, read_number(0)), silence) << "no such place";
}

}    // namespace
}    // namespace waypoints_tests
