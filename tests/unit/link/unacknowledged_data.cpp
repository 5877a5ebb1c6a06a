#include <link/tcp/unacknowledged_data.hpp>

#include <gtest/gtest.h>

#include <chrono>

using anogate::InFlightLimit;
using anogate::UnacknowledgedData;
using namespace std::chrono_literals;

namespace unacknowledged_data_tests {
namespace {

struct Unacknowledged : testing::Test {
    void acknowledge(std::size_t left) { data.see(left, now); }
    void write(std::size_t bytes) {
        data.see(data.bytes(), now);
        data.wrote(bytes, now);
    }
    bool is_late(ano::Duration trip) {
        return data.is_late(now, [trip] { return InFlightLimit::RoundTrip{trip, trip}; });
    }

    bool may_be_interrupted(ano::Duration trip) {
        return data.may_be_interrupted(now, [trip] { return InFlightLimit::RoundTrip{trip, trip}; });
    }

    UnacknowledgedData data;
    ano::TimePoint now{1h};
};

TEST_F(Unacknowledged, ages_from_the_first_write_until_the_last_byte_is_acknowledged) {
    EXPECT_EQ(data.age(now), 0s);
    write(100);
    now += 3s;
    write(100);
    EXPECT_EQ(data.age(now), 3s);
    acknowledge(0);
    EXPECT_EQ(data.age(now + 1h), 0s);
    write(1);
    EXPECT_EQ(data.age(now + 1s), 1s);
}

TEST_F(Unacknowledged, each_acknowledgement_begins_a_new_age_even_if_more_is_written_than_acknowledged) {
    write(100);
    for (int i = 0; i < 10; ++i) {
        now += 100ms;
        acknowledge(data.bytes() - 50);
        write(200);
    }
    EXPECT_EQ(data.age(now), 0s);
    EXPECT_FALSE(is_late(1ms));
}

TEST_F(Unacknowledged, is_late_when_it_waits_much_longer_than_the_path_needs) {
    write(100);
    now += 250ms;
    EXPECT_FALSE(is_late(1ms)) << "small systems acknowledge a single frame that late";
    now += 50ms;
    EXPECT_TRUE(is_late(1ms));
    EXPECT_FALSE(is_late(600ms));
    now += 1300ms;
    EXPECT_TRUE(is_late(600ms));
    acknowledge(50);
    EXPECT_FALSE(is_late(1ms));
}

TEST_F(Unacknowledged, two_writes_may_be_interrupted_earlier_because_the_second_is_acknowledged_at_once) {
    write(100);
    now += 250ms;
    EXPECT_FALSE(may_be_interrupted(1ms)) << "one write may be acknowledged that late";
    write(100);
    now += 29ms;
    EXPECT_FALSE(may_be_interrupted(1ms));
    acknowledge(0);
    write(100);
    now += 20ms;
    write(100);
    now += 100ms;
    EXPECT_FALSE(may_be_interrupted(1ms));
    now += 10ms;
    EXPECT_TRUE(may_be_interrupted(1ms));
    EXPECT_FALSE(is_late(1ms));
    EXPECT_FALSE(may_be_interrupted(10ms)) << "a longer path";
    acknowledge(100);
    EXPECT_FALSE(may_be_interrupted(1ms)) << "something was acknowledged";
    acknowledge(0);
    EXPECT_FALSE(may_be_interrupted(1ms));
}

}    // namespace
}    // namespace unacknowledged_data_tests
