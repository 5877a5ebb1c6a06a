// Properties of loops, in simulated time: a device, and two links that are connected outside the gateway.
#include "forwarding.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace forwarder_loops_tests {

using namespace forwarding;

namespace {

class Loops : public Forwarding {
protected:
    /// Frames sent on one of the two are received on the other after `way`, or none are.
    struct Bridge {
        bool joined = true, carries_probes = true;
        Duration way = 20ms;
    };
    static Channel& add_cable(Loops& loops) {
        return loops.add_with([](ForwarderLink& link) { link.allows_probes = false; });
    }
    void send(Channel& from, const Bytes& bytes, Duration at) { arriving.emplace(start + 1s + at, std::pair{&from, bytes}); }
    void run(Duration until) {
        for (; !arriving.empty() && arriving.begin()->first <= start + 1s + until; arriving.erase(arriving.begin())) {
            const auto& [at, arrival] = *arriving.begin();
            now = at;
            receive(*arrival.first, arrival.second);
            for (Channel* const channel : {&left, &right})
                for (const Bytes& bytes : taken(*channel)) pass(*channel, bytes);
            for (const Bytes& bytes : taken(vehicle)) ++reached[bytes];
            ASSERT_LT(++handled, 100'000u) << "a storm";
        }
    }
    void pass(const Channel& out, const Bytes& bytes) {
        ++left_by[bytes];
        probes += is_probe(ano::FrameView{bytes});
        if (bridge.joined && (bridge.carries_probes || !is_probe(ano::FrameView{bytes})))
            arriving.emplace(now + bridge.way, std::pair{&out == &left ? &right : &left, bytes});
    }
    static Bytes command(int n) {
        return frame(host, all, 0xC0, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
    }
    static Bytes state(std::uint8_t source, int n) {
        return frame(source, all, 0x03, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
    }
    std::uint64_t looped() const {
        return ground.routed.looped + left.routed.looped + right.routed.looped + vehicle.routed.looped;
    }
    bool is_known() const { return forwarder.loops().loop(left.id, now) && forwarder.loops().loop(right.id, now); }

    Channel &ground = add(), &vehicle = add_cable(*this), &left = add(), &right = add();
    Bridge bridge;
    std::multimap<TimePoint, std::pair<Channel*, Bytes>> arriving;
    std::map<Bytes, int> reached, left_by;
    std::size_t handled = 0, probes = 0;
};

TEST_F(Loops, are_not_assumed_for_repeated_frames_and_none_is_dropped_or_delayed) {
    bridge.joined = false;
    constexpr int frames = 3000;
    for (int n = 0; n < frames; ++n) {
        send(ground, command(1), n * 1ms);
        if (n % 7 == 0) send(left, command(1), n * 1ms);    // frequent frames from there alone would count as a loop
        send(ground, state(fc, 1), n * 5ms);
        send(right, state(fc, 1), n * 5ms + 1ms);
    }
    run(30s);
    EXPECT_EQ(reached[command(1)], frames + (frames + 6) / 7);
    EXPECT_EQ(reached[state(fc, 1)], 2 * frames);
    EXPECT_EQ(looped(), 0u);
    EXPECT_FALSE(forwarder.due()) << "no configuration is waiting";
}

class LoopsOf : public Loops, public testing::WithParamInterface<Duration> {};

TEST_P(LoopsOf, that_return_probes_let_a_frame_pass_three_times_and_then_once) {
    bridge.way = GetParam();
    for (int n = 0; n < 100; ++n)
        for (const Bytes& bytes : {command(n), state(fc, n)}) send(ground, bytes, n * 100ms);
    run(20s);
    EXPECT_TRUE(arriving.empty()) << "nothing circulates";
    EXPECT_TRUE(is_known());
    for (int n = 0; n < 100; ++n)
        for (const Bytes& bytes : {command(n), state(fc, n)}) {
            EXPECT_GE(reached[bytes], 1) << n;
            EXPECT_LE(reached[bytes], n * 100ms <= 2 * GetParam() ? 3 : 1) << n;
        }
    EXPECT_EQ(forwarder.loops().loop(left.id, now)->back == left.link, forwarder.loops().loop(left.id, now)->out == right.link);
}
INSTANTIATE_TEST_SUITE_P(Delays, LoopsOf, testing::Values(Duration{}, 1ms, 20ms, 500ms, 900ms));

TEST_F(Loops, are_over_five_seconds_after_their_last_probe) {
    for (int n = 0; n < 20; ++n) send(ground, command(n), n * 100ms);
    run(2s);
    EXPECT_TRUE(is_known());
    bridge.joined = false;
    for (int n = 0; n < 100; ++n) {    // another host sends the same
        send(ground, command(n), 3s + n * 100ms);
        send(left, command(n), 3s + n * 100ms + 50ms);
    }
    run(20s);
    for (int n = 60; n < 100; ++n) EXPECT_EQ(reached[command(n)], 2) << n;
}

TEST_F(Loops, that_return_no_probes_are_cut_within_two_seconds_with_a_hint) {
    bridge.carries_probes = false;
    bridge.way = 1ms;
    send(ground, command(1), 0ms);
    run(2s);
    const int before = reached[command(1)];
    EXPECT_TRUE(is_known()) << "for the hint";
    run(3s);
    EXPECT_LE(reached[command(1)] - before, 200);
    EXPECT_TRUE(arriving.empty());
    for (int n = 2; n < 200; ++n) send(ground, command(n), 3s + n * 10ms);
    run(10s);
    for (int n = 2; n < 200; ++n) EXPECT_EQ(reached[command(n)], 1) << "known for a minute";
}

TEST_F(Loops, that_return_no_probes_are_cut_by_the_sum_of_slow_frames) {
    bridge.carries_probes = false;
    bridge.way = 200ms;
    for (int n = 0; n < 1000; ++n) send(ground, state(fc, n), n * 10ms);
    run(20s);
    EXPECT_TRUE(arriving.empty());
    for (int n = 200; n < 1000; ++n) EXPECT_EQ(reached[state(fc, n)], 1) << n;
}

TEST_F(Loops, are_not_assumed_for_three_boards_with_one_id) {
    bridge.joined = false;
    int sent = 0;
    for (int n = 0; n < 1000; ++n) {
        send(ground, state(0x01, 0), n * 4ms);
        send(left, state(0x01, 0), n * 4ms + 3ms);
        if (n >= 250) send(right, state(0x01, 0), n * 4ms + 3ms);    // at the same time as the second
        sent += n >= 250 ? 3 : 2;
    }
    run(20s);
    EXPECT_EQ(reached[state(0x01, 0)], sent);
    EXPECT_EQ(looped(), 0u);
    EXPECT_EQ(forwarder.router().conflicts(now).size(), 1u) << "for the hint that asks for a group or another id";
    EXPECT_LE(probes, 2 * 5u) << "one a second";
}

}    // namespace
}    // namespace forwarder_loops_tests
