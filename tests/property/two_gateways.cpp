// Two gateways connected by two links, each direction with its own delay: every broadcast arrives everywhere, no frame loops, and
// with the links in one group a command arrives exactly once, even while a link fails.
#include <gateway/forwarder.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <queue>
#include <span>
#include <utility>
#include <vector>

namespace two_gateways_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr unsigned device = 0;    // channel 0 of each; 1 and 2 connect the two

// A gateway: every channel has its own link, and offered frames are sent at once.
struct Node {
    struct Leaves {
        ChannelId to;
        Bytes bytes;
    };
    Node(std::uint64_t number, std::uint8_t group, unsigned joints, bool probed)
        : group_of_links{group}, forwarder{std::make_unique<Forwarder>(GatewaySettings{}, number)} {
        for (unsigned n = 0; n <= joints; ++n) add(n, n != device && probed);
    }
    /// Replaces the link of a channel by one on which probes are allowed, or not.
    void open(unsigned channel, bool probed) {
        forwarder->remove_link(channels[channel]->link);
        add(channel, probed);
    }
    std::vector<Leaves> receive(unsigned channel, const Bytes& bytes, TimePoint now) {
        channels[channel]->arrived_at = now;
        forwarder->receive(*channels[channel], ano::FrameView{bytes}, now);
        return flushed(now);
    }
    std::vector<Leaves> tick(TimePoint now) {
        forwarder->tick(now);
        return flushed(now);
    }
    int looped() const {
        std::uint64_t all = 0;
        for (const Channel* channel : channels) all += channel->routed.looped;
        return static_cast<int>(all);
    }

    std::uint8_t group_of_links;
    std::unique_ptr<Forwarder> forwarder;
    std::vector<Channel*> channels;
    TimePoint ticks_at = TimePoint::max();    // the next scheduled call

private:
    void add(unsigned channel, bool probed) {
        ForwarderLink link;
        link.route.group = channel == device ? 0 : group_of_links;
        link.allows_probes = probed;
        const LinkId id = forwarder->add_link(link);
        channels.resize(std::max<std::size_t>(channels.size(), channel + 1));
        channels[channel] = forwarder->open_channel(id, {}, TimePoint::min());
        forwarder->link_up(id, TimePoint::min());
    }
    std::vector<Leaves> flushed(TimePoint now) {
        std::vector<Leaves> leave;
        while (Channel* const to = forwarder->next_to_flush()) {
            std::span<const std::uint8_t> piece[1];
            for (; to->outbox.gather(piece, now) == 1; to->outbox.sent_frame())
                leave.push_back({to->id, {piece[0].begin(), piece[0].end()}});
        }
        return leave;
    }
};

struct World {
    struct Event {
        TimePoint at;
        std::uint64_t number;
        unsigned node, channel;
        Bytes bytes;    // empty: a timer is due
        bool operator>(const Event& other) const { return std::tie(at, number) > std::tie(other.at, other.number); }
    };
    /// The end of a path that begins at a channel of a node.
    struct End {
        unsigned node, channel;
    };
    using Carries = std::function<bool(const Bytes&)>;

    /// Two nodes connected by two paths, each channel to the channel with the same number.
    explicit World(std::uint8_t group) : World{2, 2, group} {
        join({0, 1}, {1, 1});
        join({0, 2}, {1, 2});
    }
    World(unsigned count, unsigned joints, std::uint8_t group = 0, bool probed = true) : most{100000} {
        for (unsigned n = 0; n < count; ++n) nodes.emplace_back(n + 1, group, joints, probed);
        arrived.resize(count);
    }
    void join(End a, End b, Duration there = {}, Duration back = {}) {
        ways[{a.node, a.channel}] = {b, there};
        ways[{b.node, b.channel}] = {a, back};
    }

    void send(unsigned node, unsigned channel, const Bytes& bytes, TimePoint at) {
        events.push({at, ++numbers, node, channel, bytes});
    }
    void run() {
        while (!events.empty() && events.top().at < end) {
            const Event event = events.top();
            events.pop();
            ASSERT_LT(++handled, most) << "a storm";
            now = event.at;
            Node& node = nodes[event.node];
            for (const Node::Leaves& out : event.bytes.empty() ? tick(node) : node.receive(event.channel, event.bytes, now)) {
                const unsigned channel = static_cast<unsigned>(index(out.to));
                const auto way = ways.find({event.node, channel});
                if (way == ways.end()) ++arrived[event.node][frame_key(ano::FrameView{out.bytes})];
                else if (carries(out.bytes) && (channel > 2 || channel == 0 || now < failing_from[channel - 1]))
                    send(way->second.first.node, way->second.first.channel, out.bytes,
                         now + way->second.second + delay_of(event.node, channel));
            }
            if (const auto due = node.forwarder->due(); due && *due < node.ticks_at) {
                node.ticks_at = *due;
                send(event.node, 0, {}, *due);
            }
        }
    }
    std::vector<Node::Leaves> tick(Node& node) {
        if (now >= node.ticks_at) node.ticks_at = TimePoint::max();
        return node.tick(now);
    }
    Duration delay_of(unsigned node, unsigned channel) const {
        return node < 2 && (channel == 1 || channel == 2) ? delay[node][channel - 1] : Duration{};
    }
    int looped() const {
        int all = 0;
        for (const Node& node : nodes) all += node.looped();
        return all;
    }

    std::vector<Node> nodes;
    std::map<std::pair<unsigned, unsigned>, std::pair<End, Duration>> ways;
    Carries carries = [](const Bytes&) { return true; };
    Duration delay[2][2]{};
    TimePoint failing_from[2] = {TimePoint::max(), TimePoint::max()};
    std::priority_queue<Event, std::vector<Event>, std::greater<>> events;
    std::vector<std::map<std::uint64_t, int>> arrived;    // number of arrivals by frame_key()
    int times(unsigned node, const Bytes& bytes) { return arrived[node][frame_key(ano::FrameView{bytes})]; }
    TimePoint now{}, end = TimePoint::max();
    std::uint64_t numbers = 0;
    std::size_t handled = 0, most;
};

Bytes command(int n) {
    return support::frame(0xFE, 0xDC, 0xC0, {1, 0, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}
Bytes attitude(int n) {
    return support::frame(0xDC, 0xFE, 0x03, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}

// A broadcast of one device.
Bytes telemetry(int n) {
    return support::frame(0xDC, 0xFF, 0x03, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}

constexpr Duration delays[] = {0ms, 60ms, 500ms};

template <class Test>
void for_all_delays(Test test) {
    constexpr std::uint64_t ways = 81;
    const std::uint64_t step = std::max<std::uint64_t>(ways / support::trials(ways), 2) -
                               1;    // not a power of three, so that all four vary
    for (std::uint64_t way = 0; way < ways; way += step) {
        const Duration a = delays[way / 27], b = delays[way / 9 % 3], c = delays[way / 3 % 3], d = delays[way % 3];
        SCOPED_TRACE(testing::Message() << a / 1ms << ' ' << b / 1ms << ' ' << c / 1ms << ' ' << d / 1ms);
        test({{a, b}, {c, d}});
    }
}

// At most three times until the loop is known, however slow the path is: a copy may be from another board that sends the same
// bytes.
TEST(TwoGateways, every_broadcast_arrives_soon_only_once_and_nothing_circulates) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        for (const bool grouped : {false, true}) {
            World world{static_cast<std::uint8_t>(grouped)};
            std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
            for (int n = 0; n < 100; ++n) {
                const unsigned from = static_cast<unsigned>(n) % 2;
                const auto source = static_cast<std::uint8_t>(0xDC + from);
                const Bytes data{static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)};
                world.send(from, device, support::frame(source, 0xFF, 0x03, data), TimePoint{1h} + n * 50ms);
            }
            world.run();
            for (int n = 0; n < 100; ++n) {
                const unsigned from = static_cast<unsigned>(n) % 2;
                const auto source = static_cast<std::uint8_t>(0xDC + from);
                const Bytes data{static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)};
                const Bytes frame = support::frame(source, 0xFF, 0x03, data);
                EXPECT_GE(world.times(1 - from, frame), 1) << n;
                EXPECT_LE(world.times(1 - from, frame), grouped || n >= 60 ? 1 : 3) << n;
                EXPECT_LE(world.times(from, frame), grouped || n >= 60 ? 0 : 3) << n << ": its own side";
            }
        }
    });
}

// The same bytes repeatedly, as from a device at rest.
TEST(TwoGateways, a_broadcast_that_repeats_still_arrives) {
    for_all_delays([](const Duration(&&delay)[2][2]) {
        World world{0};
        std::copy_n(&delay[0][0], 4, &world.delay[0][0]);
        const Bytes frame = support::frame(0xDC, 0xFF, 0x03, {1, 2});
        for (int n = 0; n < 100; ++n) world.send(0, device, frame, TimePoint{} + n * 10ms);
        world.run();
        EXPECT_GE(world.times(1, frame), 100);
        EXPECT_LE(world.times(1, frame), 300);
    });
}

// Ground stations on both sides send the same broadcast question for device information once a second.
TEST(TwoGateways, a_request_circulates_at_most_once) {
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

// With a ground station on both sides, each gateway may have learned the other's on a different link.
TEST(TwoGateways, frames_for_hosts_on_both_sides_do_not_circulate) {
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
            // Frames on their way when the link fell silent are lost, and those sent until the silence was noticed.
            EXPECT_LE(missing, failing == 0 ? 0 : static_cast<int>((Router::group_silence + 1s) / 20ms));
            EXPECT_EQ(world.times(1, command(249)), 1) << "the other link has taken over";
        }
    });
}

// A broadcast of one host; several hosts may send the same.
Bytes order(int n) {
    return support::frame(0xFE, 0xFF, 0xC0, {0x10, 0, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)});
}
bool vendors_bridge(const Bytes& frame) { return frame[1] == 0xFE && frame[2] == 0xFF; }
bool lets_no_probe_through(const Bytes& frame) { return frame[3] != probe_id; }

// `count` gateways, each connected to the next and the last to the first; a single one is connected to itself, as by a bridge.
World ring_of(unsigned count, support::Random& random, Duration slowest, bool probed = true) {
    World world{count, 2, 0, probed};
    for (unsigned n = 0; n < count; ++n)
        world.join({n, 1}, {(n + 1) % count, 2}, random.below(slowest / 1us + 1) * 1us, random.below(slowest / 1us + 1) * 1us);
    return world;
}

// No frame was sent before. The probe returns before the frame has passed the ring a second time.
TEST(Ring, passes_a_command_at_most_three_times_and_once_when_the_ring_is_known) {
    support::Random random{1};
    for (std::uint64_t i = 0; i < support::trials(100); ++i) {
        const unsigned count = 1 + random.below(3u);
        SCOPED_TRACE(testing::Message() << i << ", gateways: " << count);
        World world = ring_of(count, random, 500ms / count);
        if (random.one_in(2)) world.carries = vendors_bridge;
        const unsigned from = random.below(count);
        for (int n = 0; n < 20; ++n) world.send(from, device, order(n), TimePoint{1h} + n * 1s);
        world.run();
        for (unsigned node = 0; node < count; ++node)
            for (int n = 0; n < 20; ++n) {
                const int own = node == from;    // the sender does not receive its own frame
                EXPECT_GE(world.times(node, order(n)) + own, 1) << node << ' ' << n;
                EXPECT_LE(world.times(node, order(n)), n == 0 ? 3 : 1 - own) << node << ' ' << n;
            }
        EXPECT_LT(world.handled, 1000u);
    }
}

// A cable at one end, on which no probe is sent. The probe sent at the other end returns before the frame if its path is no
// slower.
TEST(Ring, of_a_cable_and_the_vendors_bridge_passes_a_command_at_most_three_times) {
    support::Random random{5};
    for (std::uint64_t i = 0; i < support::trials(20); ++i) {
        SCOPED_TRACE(i);
        World world{1, 3};
        world.nodes[0].open(1, false);
        world.join({0, 1}, {0, 2}, (100 + random.below(150)) * 1ms, random.below(100) * 1ms);
        world.carries = vendors_bridge;
        for (int n = 0; n < 200; ++n) world.send(0, device, telemetry(n), TimePoint{1h} + n * 50ms);
        for (int n = 0; n < 5; ++n) world.send(0, 3, order(n), TimePoint{1h} + 5s + n * 1s);
        world.run();
        for (int n = 0; n < 5; ++n) {
            EXPECT_GE(world.times(0, order(n)), 1) << n;
            EXPECT_LE(world.times(0, order(n)), n == 0 ? 3 + 2 : 1) << n << ": what returned goes to the host as well";
        }
    }
}

// After two seconds at most 200 copies of a frame in a second, and a hint.
TEST(Ring, that_returns_no_probe_is_cut) {
    support::Random random{6};
    for (std::uint64_t i = 0; i < support::trials(100); ++i) {
        const unsigned count = 1 + random.below(3u);
        const bool probed = random.one_in(2);
        SCOPED_TRACE(testing::Message() << i << ", gateways: " << count << (probed ? "" : ", cables"));
        World world = ring_of(count, random, random.of({0ms, 5ms, 90ms, 200ms}), probed);
        world.carries = lets_no_probe_through;
        const unsigned from = random.below(count);
        const Bytes frame = random.one_in(2) ? order(0) : telemetry(0);
        world.send(from, device, frame, TimePoint{1h});
        std::vector<int> before(count);
        for (int second = 2; second < 10; ++second) {
            world.end = TimePoint{1h} + second * 1s;
            world.run();
            for (unsigned node = 0; node < count; ++node) {
                const int times = world.times(node, frame);
                EXPECT_LE(times - before[node], second == 2 ? 500 : 200) << node << ' ' << second;
                before[node] = times;
            }
        }
    }
}

// For any delay and any composition of the ring: every command arrives, and it stops looping if the probe returns.
TEST(Ring, is_detected_when_its_probe_returns) {
    support::Random random{2};
    for (std::uint64_t i = 0; i < support::trials(40); ++i) {
        const unsigned count = 1 + random.below(3u);
        SCOPED_TRACE(testing::Message() << i << ", gateways: " << count);
        World world = ring_of(count, random, random.of({0ms, 5ms, 90ms, 400ms}));
        world.carries = vendors_bridge;
        world.most = 1000;
        const unsigned from = random.below(count);
        const int orders = 1 + random.below(10);
        for (int n = 0; n < orders; ++n) world.send(from, device, order(n), TimePoint{1h} + n * 300ms);
        world.run();
        for (unsigned node = 0; node < count; ++node)
            for (int n = 0; n < orders; ++n) {
                EXPECT_GE(world.times(node, order(n)) + (node == from), 1) << node << ' ' << n;
                EXPECT_LE(world.times(node, order(n)), 3) << node << ' ' << n;
            }
    }
}

// The frame enters through the ring itself: the first is from a sender; later ones may be repeats of a sender until the loop is
// known.
TEST(Ring, stops_a_frame_that_entered_through_a_link_of_the_ring) {
    for (const int tokens : {1, 2, 5})
        for (const Duration way : {0ms, 20ms, 400ms}) {
            World world{1, 2};
            world.join({0, 1}, {0, 2}, way, way);
            for (int i = 0; i < tokens; ++i)
                for (const unsigned channel : {1u, 2u}) world.send(0, channel, order(0), TimePoint{1h} + i * 100us);
            world.run();
            EXPECT_GE(world.times(0, order(0)), 1) << tokens;
            EXPECT_LE(world.times(0, order(0)), tokens == 1 ? 3 : 4 * tokens) << tokens << ' ' << way / 1ms;
        }
}

// On links without probes, looping telemetry is cut within two seconds.
TEST(Ring, of_cables_is_detected_by_copies_of_telemetry) {
    support::Random random{10};
    for (std::uint64_t i = 0; i < support::trials(30); ++i) {
        const unsigned count = 1 + random.below(2u);
        SCOPED_TRACE(testing::Message() << i << ", gateways: " << count);
        World world = ring_of(count, random, random.of({0ms, 20ms, 200ms}), false);
        const unsigned from = random.below(count);
        for (int n = 0; n < 400; ++n) world.send(from, device, telemetry(n), TimePoint{1h} + n * 10ms);
        world.run();
        for (unsigned node = 0; node < count; ++node)
            for (int n = 0; n < 400; ++n) {
                const int own = node == from;
                EXPECT_GE(world.times(node, telemetry(n)) + own, 1) << node << ' ' << n;
                EXPECT_LE(world.times(node, telemetry(n)), n < 200 ? 2 * 202 : 3) << node << ' ' << n;
            }
    }
}

// Two boards with one address and the same bytes, on links without probes, each at any rate.
TEST(Devices, that_send_equal_frames_on_links_without_probes_lose_none) {
    support::Random random{8};
    for (std::uint64_t i = 0; i < support::trials(30); ++i) {
        SCOPED_TRACE(i);
        World world{1, 2};
        world.nodes[0].open(1, false);
        const Bytes frame = support::frame(random.of<std::uint8_t>({0x01, 0xFD, 0x00, 0xFF}), 0xFF, 0x03, {0, 0, 0});
        int sent = 0;
        for (const unsigned board : {0u, 1u}) {
            const Duration period = (10 + random.below(500)) * 1ms, lag = random.below(10'000) * 1us;
            for (Duration at = lag; at < 9s; at += period, ++sent) world.send(0, board, frame, TimePoint{1h} + at);
        }
        world.run();
        EXPECT_EQ(world.times(0, frame), 2 * sent);
        EXPECT_EQ(world.looped(), 0);
    }
}

// The same on links with probes, at equal rates.
TEST(Devices, that_send_equal_frames_at_one_rate_lose_none_from_the_first_on) {
    support::Random random{9};
    for (std::uint64_t i = 0; i < support::trials(30); ++i) {
        SCOPED_TRACE(i);
        World world{1, 3};
        const Bytes frame = support::frame(0x01, 0xFF, 0x03, {0, 0, 0});
        const Duration period = (10 + random.below(500)) * 1ms, lag = random.below(10'000) * 1us;
        int sent = 0;
        for (Duration at{}; at < 9s; at += period, sent += 2) {
            world.send(0, 1, frame, TimePoint{1h} + at);
            world.send(0, 2, frame, TimePoint{1h} + at + lag);
        }
        world.run();
        EXPECT_EQ(world.times(0, frame), 3 * sent);
        EXPECT_EQ(world.looped(), 0);
    }
}

// Each at its own rate, in any order of appearance, and also if the link of one is opened later.
TEST(Devices, that_send_equal_frames_at_any_rates_lose_none_from_the_first_on) {
    support::Random random{11};
    for (std::uint64_t i = 0; i < support::trials(60); ++i) {
        SCOPED_TRACE(i);
        World world{1, 3};
        const Bytes frame = support::frame(random.of<std::uint8_t>({0x01, 0xDC, 0x00, 0xFF}), 0xFF, 0x03, {0, 0, 0});
        const Duration later = random.of({0ms, 500ms, 3000ms});
        int sent = 0;
        for (const unsigned board : {1u, 2u}) {
            const Duration period = (10 + random.below(500)) * 1ms, lag = random.below(10'000) * 1us;
            for (Duration at = lag + (board == 2 ? later : 0ms); at < 9s; at += period, ++sent)
                world.send(0, board, frame, TimePoint{1h} + at);
        }
        if (later > 0ms) {
            world.end = TimePoint{1h} + later;
            world.run();
            world.nodes[0].open(2, true);
            world.end = TimePoint::max();
        }
        world.run();
        EXPECT_EQ(world.times(0, frame), 3 * sent);
        EXPECT_EQ(world.looped(), 0);
    }
}

// The ring is closed after a while, by existing or new links, while a device sends.
TEST(Ring, that_is_closed_later_never_causes_a_storm) {
    support::Random random{12};
    for (std::uint64_t i = 0; i < support::trials(40); ++i) {
        const unsigned count = 1 + random.below(2u);
        const bool opens = random.one_in(2), probed = random.one_in(2);
        SCOPED_TRACE(testing::Message() << i << ", gateways: " << count << (opens ? ", new links" : "")
                                        << (probed ? "" : ", cables"));
        World world = ring_of(count, random, random.of({0ms, 20ms, 200ms}), probed);
        constexpr Duration closed = 3s;
        world.carries = [&](const Bytes&) { return world.now >= TimePoint{1h} + closed; };
        const unsigned from = random.below(count);
        constexpr int frames = 900;
        for (int n = 0; n < frames; ++n) world.send(from, device, telemetry(n), TimePoint{1h} + n * 10ms);
        world.end = TimePoint{1h} + closed;
        world.run();
        if (opens)
            for (Node& node : world.nodes)
                for (const unsigned channel : {1u, 2u}) node.open(channel, probed);
        world.end = TimePoint::max();
        world.run();
        int all = 0;
        for (unsigned node = 0; node < count; ++node)
            for (int n = 300; n < frames; ++n) {
                const int times = world.times(node, telemetry(n)), own = node == from;
                all += times;
                EXPECT_GE(times + own, 1) << node << ' ' << n;
                EXPECT_LE(times, n < 500 ? 2 * 202 : 3) << node << ' ' << n;
            }
        EXPECT_LE(all, static_cast<int>(count) * (frames - 300 + 4 * static_cast<int>(LoopGuard::max_surplus)));
    }
}

// Several hosts that send the same bytes at any interval, without a ring: three gateways in a row, with hosts at all of them.
TEST(Hosts, that_repeat_one_another_lose_nothing) {
    support::Random random{4};
    for (std::uint64_t i = 0; i < support::trials(50); ++i) {
        SCOPED_TRACE(i);
        World world{3, 3};
        world.join({0, 1}, {1, 1}, random.below(50) * 1ms, random.below(50) * 1ms);
        world.join({1, 2}, {2, 1}, random.below(50) * 1ms, random.below(50) * 1ms);
        const auto leaves = [](unsigned node) { return node == 1 ? std::vector{0u, 3u} : std::vector{0u, 2u, 3u}; };
        const Duration pace = random.of({1ms, 20ms, 200ms, 1000ms});
        std::map<int, std::array<int, 3>> expected;
        TimePoint at{1h};
        for (int n = 0; n < 300; ++n, at += random.below(2 * pace / 1us + 1) * 1us) {
            const unsigned node = random.below(3u);
            const auto all = leaves(node);
            unsigned leaf = all[random.below(all.size())];
            if (leaf == 0) leaf = 3;    // this host is not on a cable
            const int what = random.below(3);
            world.send(node, leaf, order(what), at);
            for (unsigned other = 0; other < 3; ++other)
                expected[what][other] += static_cast<int>(leaves(other).size()) - (other == node);
        }
        world.run();
        EXPECT_EQ(world.looped(), 0);
        for (const auto& [what, times] : expected)
            for (unsigned node = 0; node < 3; ++node) EXPECT_EQ(world.times(node, order(what)), times[node]) << what;
    }
}

TEST(Hosts, one_that_repeats_itself_loses_nothing) {
    World world{1, 2};
    constexpr int times = 5000;
    for (int n = 0; n < times; ++n) {
        world.send(0, 1, order(0), TimePoint{1h} + n * 1900ms);    // just within the window
        world.send(0, 2, support::frame(0xDC, 0xFF, 0x01, {1}), TimePoint{1h} + n * 20ms);
    }
    world.run();
    EXPECT_EQ(world.times(0, order(0)), 2 * times);
    EXPECT_EQ(world.times(0, support::frame(0xDC, 0xFF, 0x01, {1})), 2 * times);
    EXPECT_EQ(world.looped(), 0);
}

// For any interval, and any time at which it stops: withheld frames are sent late.
TEST(Hosts, one_that_repeats_itself_and_stops_loses_nothing) {
    for (const Duration pace : {0ms, 1ms, 4ms, 20ms, 100ms, 250ms, 400ms, 490ms, 510ms, 700ms, 1000ms, 1900ms})
        for (const int times : {60, 63, 64, 65, 66, 67, 68, 70, 127, 130, 300}) {
            World world{1, 2};
            for (int n = 0; n < times; ++n) world.send(0, 1, order(0), TimePoint{1h} + n * pace);
            world.run();
            EXPECT_EQ(world.times(0, order(0)), 2 * times) << pace / 1ms << " ms";
            EXPECT_LE(world.now - (TimePoint{1h} + (times - 1) * pace), 500ms) << pace / 1ms << " ms";
        }
}

// One host is on a cable, where no probe is sent, the other is not. Devices send, or the hosts sent before.
TEST(Hosts, one_behind_a_cable_loses_nothing) {
    support::Random random{7};
    for (const bool devices_send : {true, false})
        for (const int frequency : {1, 5, 50})
            for (std::uint64_t i = 0; i < support::trials(10); ++i) {
                SCOPED_TRACE(testing::Message() << devices_send << ' ' << frequency << ' ' << i);
                World world{1, 2};
                world.nodes[0].open(1, false);
                if (devices_send)
                    for (int n = 0; n < 50; ++n) world.send(0, device, telemetry(n), TimePoint{1h} + n * 200ms);
                else world.send(0, 2, order(1), TimePoint{1h});
                const Duration lag = random.below(1'000'000 / frequency) * 1us;
                for (int n = 0; n < 6 * frequency; ++n) {
                    world.send(0, 2, order(0), TimePoint{1h} + 4s + n * 1s / frequency);
                    world.send(0, 1, order(0), TimePoint{1h} + 4s + n * 1s / frequency + lag);
                }
                world.run();
                EXPECT_EQ(world.times(0, order(0)), 2 * 12 * frequency);
                EXPECT_EQ(world.looped(), 0);
            }
}

}    // namespace
}    // namespace two_gateways_tests
