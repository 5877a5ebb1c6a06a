// Two gateways joined by two links, each direction with its own delay: every broadcast arrives everywhere, nothing goes
// round, and with the links in one group a command arrives exactly once, while a link fails as well.
#include <gateway/recent.hpp>
#include <gateway/router.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <queue>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr unsigned device = 0;    // channel 0 of each; 1 and 2 join the two

constexpr Replaces replace_of(const Bytes& frame) {
    return frame[3] == 0x40 ? Replaces::same_id : Replaces::nothing;
}

// The order of the steps is that of Gateway::receive().
struct Node {
    explicit Node(std::uint8_t group) : group_of_links{group}, router{std::make_unique<Router>(GatewaySettings{})} {
        router->open(ChannelId{0}, router->add_link({}));
        router->open(ChannelId{1}, router->add_link({.group = group}));
        router->open(ChannelId{2}, router->add_link({.group = group}));
    }
    ChannelSet receive(unsigned channel, const Bytes& bytes, TimePoint now) {
        const ano::FrameView frame{bytes};
        const auto from = static_cast<ChannelId>(channel);
        const auto key = key_of(frame);
        if (loops.looped(key, from, now, asked_by_many(frame))) {
            ++looped;
            if (asked_by_many(frame) && !loops.suspect(from, now)) router->learn(from, frame.source(), now);
            return {};
        }
        const std::uint8_t group = channel == device ? 0 : group_of_links;
        if (group != 0 && copies.duplicate(key, group, static_cast<LinkId>(channel), replace_of(bytes), now)) {
            ++duplicates;
            return {};
        }
        if (!asked_by_many(frame) && loops.copied(key, from, now)) {
            ++looped;
            return {};
        }
        const Route route = router->route(from, frame.source(), frame.destination(), now);
        if (!route.guarded.empty()) loops.remember(key, from, route.guarded, now);
        return route.channels;
    }

    std::uint8_t group_of_links;
    std::unique_ptr<Router> router;
    LoopGuard loops;
    DuplicateGuard copies;
    int looped = 0;
    int duplicates = 0;
};

struct World {
    struct Event {
        TimePoint at;
        std::uint64_t number;
        unsigned node, channel;
        Bytes bytes;
        bool operator>(const Event& other) const { return std::tie(at, number) > std::tie(other.at, other.number); }
    };

    explicit World(std::uint8_t group) : nodes{Node{group}, Node{group}} {}

    void send(unsigned node, unsigned channel, const Bytes& bytes, TimePoint at) {
        events.push({at, ++numbers, node, channel, bytes});
    }
    void run() {
        while (!events.empty()) {
            const Event event = events.top();
            events.pop();
            ASSERT_LT(++handled, 100000u) << "a storm";
            now = event.at;
            for (const ChannelId to : nodes[event.node].receive(event.channel, event.bytes, now)) {
                const unsigned channel = static_cast<unsigned>(index(to));
                if (channel == device)
                    ++arrived[event.node][key_of(ano::FrameView{event.bytes})];
                else if (now < failing_from[channel - 1])
                    send(1 - event.node, channel, event.bytes, now + delay[event.node][channel - 1]);
            }
        }
    }

    std::array<Node, 2> nodes;
    Duration delay[2][2]{};
    TimePoint failing_from[2] = {TimePoint::max(), TimePoint::max()};
    std::priority_queue<Event, std::vector<Event>, std::greater<>> events;
    std::map<std::uint64_t, int> arrived[2];    // how often, by key_of()
    int times(unsigned node, const Bytes& bytes) { return arrived[node][key_of(ano::FrameView{bytes})]; }
    TimePoint now{};
    std::uint64_t numbers = 0;
    std::size_t handled = 0;
};

Bytes command(int n) {
    return support::frame(0xFE, 0xDC, 0xC0, {1, 0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}
Bytes attitude(int n) {
    return support::frame(0xDC, 0xFE, 0x03, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}

constexpr Duration delays[] = {0ms, 60ms, 500ms};

template <class Test>
void for_all_delays(Test test) {
    for (const Duration a : delays)
        for (const Duration b : delays)
            for (const Duration c : delays)
                for (const Duration d : delays) {
                    SCOPED_TRACE(testing::Message() << a / 1ms << ' ' << b / 1ms << ' ' << c / 1ms << ' ' << d / 1ms);
                    test({{a, b}, {c, d}});
                }
}

}    // namespace

TEST(TwoGateways, every_broadcast_arrives_once_and_nothing_goes_round) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        for (const bool grouped : {false, true}) {
            World world{static_cast<std::uint8_t>(grouped)};
            std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
            for (int n = 0; n < 100; ++n) {
                const unsigned from = static_cast<unsigned>(n) % 2;
                const auto source = static_cast<std::uint8_t>(0xDC + from);
                const Bytes data{static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)};
                world.send(from, device, support::frame(source, 0xFF, 0x03, data), TimePoint{} + n * 7ms);
            }
            world.run();
            for (const auto& arrived : world.arrived) {
                EXPECT_EQ(arrived.size(), 50u);
                for (const auto& [key, times] : arrived) EXPECT_EQ(times, 1);
            }
        }
    });
}

// The same bytes again and again, as of a device at rest.
TEST(TwoGateways, a_broadcast_that_repeats_still_arrives) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        World world{0};
        std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
        const Bytes frame = support::frame(0xDC, 0xFF, 0x03, {1, 2});
        for (int n = 0; n < 100; ++n) world.send(0, device, frame, TimePoint{} + n * 10ms);
        world.run();
        EXPECT_GE(world.times(1, frame), 100);
        EXPECT_LE(world.times(1, frame), 130);
    });
}

// Ground stations on both sides ask everybody who they are, once a second, in the same words.
TEST(TwoGateways, a_question_goes_round_at_most_once) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        World world{0};
        std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
        const Bytes question = support::frame(0xFE, 0xFF, 0xE0, {0, 0, 0});
        for (int n = 0; n < 50; ++n) {
            const unsigned from = static_cast<unsigned>(n) % 2;
            world.send(from, device, question, TimePoint{} + n * 500ms);
        }
        world.run();
        EXPECT_LE(world.handled, 50u * 8);
        for (unsigned node : {0u, 1u}) EXPECT_GE(world.times(node, question), 1);
    });
}

// With a ground station on both sides, each gateway may know of the other's by another way.
TEST(TwoGateways, what_is_for_hosts_on_both_sides_does_not_go_round) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        for (const std::uint8_t id : {std::uint8_t{0x03}, std::uint8_t{0xE0}}) {
            World world{0};
            std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
            for (const unsigned node : {0u, 1u}) {
                const Bytes word = support::frame(0xFE, 0xFF, id, {0, 0, 0});
                world.send(node, device, word, TimePoint{} + node * 3s);
            }
            for (int n = 0; n < 100; ++n) world.send(0, device, attitude(n), TimePoint{} + 6s + n * 10ms);
            world.run();
            EXPECT_LE(world.handled, 1000u);
            for (int n = 0; n < 100; ++n) EXPECT_EQ(world.times(1, attitude(n)), 1);
        }
    });
}

TEST(TwoGateways, a_command_over_a_group_arrives_exactly_once) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        for (const unsigned failing : {0u, 1u, 2u}) {    // 0: neither
            World world{1};
            std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
            const TimePoint failure = TimePoint{} + 1500ms;
            if (failing > 0) world.failing_from[failing - 1] = failure;
            for (int n = 0; n < 250; ++n) {
                world.send(1, device, attitude(n), TimePoint{} + n * 20ms);
                world.send(0, device, command(n), TimePoint{} + n * 20ms + 5ms);
            }
            world.run();
            int missing = 0;
            for (int n = 0; n < 250; ++n) {
                const int times = world.times(1, command(n));
                EXPECT_LE(times, 1);
                missing += times == 0;
            }
            // What was on its way when the link fell silent is lost, and what was sent until that showed.
            EXPECT_LE(missing, failing == 0 ? 0 : static_cast<int>((Router::group_silence + 1s) / 20ms));
            EXPECT_EQ(world.times(1, command(249)), 1) << "the other link has taken over";
        }
    });
}
