#include <mqtt/backlog_pace.hpp>
#include <mqtt/delivery.hpp>
#include <mqtt/reconnection.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <string>
#include <vector>

namespace delivery_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

Record record(std::uint64_t seq, ano::TimePoint made, std::size_t size = 100) {
    return {seq, Keep::normal, made, 0, "t", std::string(size, 'x')};
}

struct Delivered {
    Delivery delivery;
    ano::TimePoint now{1000s};
    std::uint64_t seq = 0;

    void add(int count, std::size_t size = 100) {
        for (int i = 0; i < count; ++i) delivery.add(record(++seq, now, size));
    }
    std::vector<std::uint64_t> publish(std::size_t window = 20) {
        std::vector<std::uint64_t> all;
        while (const Record* next = delivery.next(window)) all.push_back(next->seq);
        return all;
    }
    std::vector<std::uint64_t> old() {
        std::vector<std::uint64_t> all;
        for (const Record& one : delivery.take_old(now)) all.push_back(one.seq);
        return all;
    }
};

using Seqs = std::vector<std::uint64_t>;

TEST(MqttDelivery, what_is_acknowledged_in_time_never_reaches_the_spool) {
    Delivered d;
    d.add(3);
    EXPECT_EQ(d.publish(), (Seqs{1, 2, 3}));
    d.delivery.on_answer(2, Fate::delivered);
    d.delivery.on_answer(1, Fate::unread);
    d.delivery.on_answer(3, Fate::denied);
    d.now += 2s;
    EXPECT_EQ(d.old(), Seqs{});
    EXPECT_EQ(d.delivery.bytes(), 0u);
    EXPECT_EQ(d.delivery.in_flight(), 0u);
}

TEST(MqttDelivery, what_is_not_acknowledged_in_time_goes_to_the_spool_once) {
    Delivered d;
    d.add(4);
    EXPECT_EQ(d.publish(3), (Seqs{1, 2, 3}));
    d.delivery.on_answer(2, Fate::delivered);
    d.now += Delivery::patience - 100ms;
    d.add(1);
    EXPECT_EQ(d.old(), Seqs{});
    d.now += 100ms;
    EXPECT_EQ(d.old(), (Seqs{1, 3, 4}));
    d.delivery.on_answer(3, Fate::delivered);    // too late: the reader drops what it has
    EXPECT_EQ(d.delivery.in_flight(), 0u);
    EXPECT_EQ(d.publish(), (Seqs{5}));
    d.delivery.on_answer(5, Fate::delivered);
    d.delivery.on_answer(99, Fate::delivered);
    EXPECT_EQ(d.delivery.bytes(), 0u);
}

TEST(MqttDelivery, at_most_a_window_is_in_flight) {
    Delivered d;
    d.add(50);
    EXPECT_EQ(d.publish(20).size(), 20u);
    EXPECT_EQ(d.publish(20).size(), 0u);
    for (std::uint64_t seq = 1; seq <= 5; ++seq) d.delivery.on_answer(seq, Fate::delivered);
    EXPECT_EQ(d.publish(20), (Seqs{21, 22, 23, 24, 25}));
}

TEST(MqttDelivery, a_full_broker_gets_the_same_record_again) {
    Delivered d;
    d.add(3);
    d.publish();
    d.delivery.on_answer(2, Fate::wait);
    EXPECT_EQ(d.publish(), Seqs{2});
    d.delivery.on_answer(2, Fate::delivered);
    d.now += 1s;
    EXPECT_EQ(d.old(), (Seqs{1, 3}));
}

TEST(MqttDelivery, after_a_new_connection_everything_in_flight_is_published_again) {
    Delivered d;
    d.add(3);
    d.publish();
    d.delivery.on_answer(1, Fate::delivered);
    d.delivery.on_disconnected();
    EXPECT_EQ(d.publish(), (Seqs{2, 3}));
}

TEST(MqttDelivery, memory_is_bounded) {
    Delivered d;
    for (int i = 0; i < 100; ++i) {
        d.add(100, 1000);
        d.old();
        EXPECT_LE(d.delivery.bytes(), Delivery::max_bytes);
    }
    EXPECT_GT(d.delivery.take_all().size(), 1000u);
    EXPECT_EQ(d.delivery.bytes(), 0u);
}

TEST(MqttPuback, reasons_below_0x80_and_refusals_that_stay_remove_a_record) {
    EXPECT_EQ(fate_of(0), Fate::delivered);
    EXPECT_EQ(fate_of(0x10), Fate::unread);
    EXPECT_EQ(fate_of(0x87), Fate::denied);
    EXPECT_EQ(fate_of(0x97), Fate::wait);
    EXPECT_EQ(fate_of(0x80), Fate::wait);
    EXPECT_EQ(fate_of(0x90), Fate::refused);
}

TEST(MqttBacklogPace, batches_take_at_most_a_quarter_of_the_time) {
    BacklogPace pace{1'000'000'000};
    ano::TimePoint now{1000s};
    ano::Duration busy{};
    const ano::TimePoint end = now + 60s;
    while (now < end) {
        if (pace.may_publish(now)) {
            pace.on_published(60'000, now);
            now += 40ms;
            busy += 40ms;
            pace.on_acknowledged(now);
        } else {
            now += 1ms;
        }
    }
    EXPECT_NEAR(std::chrono::duration<double>{busy}.count(), 15, 0.5);
}

TEST(MqttBacklogPace, bytes_per_second_are_limited) {
    BacklogPace pace{100'000};
    ano::TimePoint now{1000s};
    std::size_t bytes = 0;
    for (int i = 0; i < 10'000; ++i, now += 1ms) {
        if (!pace.may_publish(now)) continue;
        pace.on_published(50'000, now);
        pace.on_acknowledged(now);
        bytes += 50'000;
    }
    EXPECT_EQ(bytes, 1'000'000u);
}

TEST(MqttReconnection, pauses_are_as_long_as_the_outage_at_most_and_have_full_jitter) {
    EXPECT_EQ(reconnect_pause(0s, 1), 1s);
    EXPECT_EQ(reconnect_pause(5s, 1), 5s);
    EXPECT_EQ(reconnect_pause(5s, 0.5), 2500ms);
    EXPECT_EQ(reconnect_pause(5s, 0), 0s);
    EXPECT_EQ(reconnect_pause(24h, 1), 60s);
}

TEST(MqttReconnection, a_fleet_renews_between_half_and_nine_tenths_of_the_life_of_its_certificates) {
    std::set<std::int64_t> times;
    for (int i = 0; i < 200; ++i) {
        const std::int64_t time = renewal_time({1'000'000, 1'000'000 + 90 * 86400}, "drone-" + std::to_string(i));
        EXPECT_GE(time, 1'000'000 + 45 * 86400);
        EXPECT_LE(time, 1'000'000 + 81 * 86400);
        times.insert(time / 86400);
    }
    EXPECT_GT(times.size(), 30u) << "of 36 days";
}

}    // namespace
}    // namespace delivery_tests
