// Actions that are not allowed on a device now, and other hosts that write to it.
#include <host/air_guard.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace ano::host::air_guard_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;

const TimePoint start = TimePoint{} + 1h;
constexpr RouteInfo known{.is_known = true};

struct Guard : AirGuard {
    void receive(std::uint8_t from, std::uint8_t to, std::uint8_t id, const Bytes& data, TimePoint now = start) {
        const Bytes frame = support::frame(from, to, id, data);
        AirGuard::receive(FrameView{frame}, now);
    }
    void mode(std::uint8_t sflag) { receive(0xDC, 0xFF, 0x06, {1, sflag, 0, 0, 0}); }
};

TEST(AirGuard, rejects_ground_only_operations_in_flight_unless_forced) {
    Guard guard;
    EXPECT_FALSE(guard.refusal(Operation::ground, 0xDC, known));
    for (const std::uint8_t sflag : std::initializer_list<std::uint8_t>{1, 2, 7}) {
        guard.mode(sflag);
        EXPECT_EQ(guard.refusal(Operation::ground, 0xDC, known), Refusal::in_the_air);
        EXPECT_FALSE(guard.refusal(Operation::ground, 0xDC, known, true));
        EXPECT_FALSE(guard.refusal(Operation::write, 0xDC, known));
        EXPECT_FALSE(guard.refusal(Operation::ground, 0xDD, known)) << "another device";
    }
    guard.mode(0);
    EXPECT_FALSE(guard.refusal(Operation::ground, 0xDC, known));
}

TEST(AirGuard, rejects_forced_operations_if_the_target_device_is_unknown_or_ambiguous) {
    Guard guard;
    EXPECT_EQ(guard.refusal(Operation::ground, 0xDC, {}, true), Refusal::not_known);
    EXPECT_EQ(guard.refusal(Operation::ground, 0xDC, {.is_known = true, .in_conflict = true}, true), Refusal::in_conflict);
    EXPECT_EQ(guard.refusal(Operation::ground, 0xDC, {.is_known = true, .on_several_channels = true}, true),
              Refusal::on_several_channels);
    for (const std::uint8_t nobody : std::initializer_list<std::uint8_t>{0x00, 0xFF, 0xFE, 0xD2})
        for (const Operation operation : {Operation::read, Operation::write, Operation::ground})
            EXPECT_EQ(guard.refusal(operation, nobody, known, true), Refusal::no_device) << int{nobody};
}

// Any program on a link can send such frames, with any source address.
TEST(AirGuard, reports_another_host_that_writes_for_two_seconds_and_rejects_nothing) {
    for (const std::uint8_t id : std::initializer_list<std::uint8_t>{0xE1, 0x61, 0xF0})
        for (const std::uint8_t to : std::initializer_list<std::uint8_t>{0xDC, 0xFF}) {
            Guard guard;
            guard.receive(0xD2, to, id, {1, 2, 3});
            for (const Operation operation : {Operation::read, Operation::write, Operation::ground})
                EXPECT_FALSE(guard.refusal(operation, 0xDC, known));
            EXPECT_EQ(guard.other_writer(0xDC, start), 0xD2);
            EXPECT_EQ(guard.other_writer(0xDC, start + 1999ms), 0xD2);
            EXPECT_EQ(guard.other_writer(0xDC, start + 2s), std::nullopt);
            EXPECT_EQ(guard.other_writer(0x21, start).has_value(), to == 0xFF);
        }
}

TEST(AirGuard, does_not_count_answers_and_requests_as_writes) {
    Guard guard;
    guard.receive(0xDC, 0xFE, 0xE1, {1, 0, 3});
    guard.receive(0xDC, 0xFF, 0xF0, {0, 0x02, 0x10, 0, 0});
    guard.receive(0xFE, 0xDC, 0xE0, {2, 0, 0});
    EXPECT_EQ(guard.other_writer(0xDC, start), std::nullopt);
}

}    // namespace
}    // namespace ano::host::air_guard_tests
