// Observers see the result of each frame, and a frame of the gateway itself adds no route.
#include "forwarding.hpp"

#include <map>
#include <vector>

namespace forwarder_watched_tests {

using namespace forwarding;

namespace {

// Counts like the counters.
class Tally final : public Forwarder::Observer {
public:
    void received(const Channel&, ano::FrameView, TimePoint) override { ++in; }
    bool passes(const Channel&, ano::FrameView frame) override {
        passed.emplace_back(frame.bytes().begin(), frame.bytes().end());
        return takes;
    }
    void offered(const Channel&, ano::FrameView, ChannelId) override { ++offers; }
    void dropped(const Channel&, ano::FrameView, ReceiveCause cause) override { ++dropped_in[name_of(receive_counters, cause)]; }
    void refused(LinkId, ano::FrameView, SendCause cause) override { ++not_sent[name_of(send_counters, cause)]; }
    void left(const Channel&, ano::FrameView frame) noexcept override {
        ++out;
        last_left = {frame.bytes().begin(), frame.bytes().end()};
    }
    void discarded(const Channel&, ano::FrameView, SendCause cause) noexcept override {
        ++not_sent[name_of(send_counters, cause)];
    }
    void removed(LinkId) override { ++removals; }

    std::uint64_t in = 0, out = 0, offers = 0, removals = 0;
    std::map<std::string, std::uint64_t> dropped_in, not_sent;
    Bytes last_left;
    std::vector<Bytes> passed;
    bool takes = false;    // whether passed frames are for the gateway itself
};

class Watched : public Forwarding {
protected:
    Watched() { forwarder.add_observer(tally); }
    void expect_as_counted(const Channel& channel) {
        EXPECT_EQ(tally.out, channel.sent().frames_out);
        for (const auto& row : send_counters) {
            if (row.name == "frames_out" || row.name == "bytes_out" || row.name == "empty_out" || row.name == "flush_bytes")
                continue;
            EXPECT_EQ(tally.not_sent[std::string{row.name}], channel.sent().*row.value) << row.name;
        }
    }
    /// One of the gateway itself, on the link of `link`.
    Channel sender_of(const Channel& link) {
        return Channel{ourselves, link.link, "send", ano::FrameParser::Options{}, Outbox::Options{}, now};
    }
    Lines sent(Channel& from, const Bytes& bytes) {
        diary.pop_all();
        from.arrived_at = now;
        forwarder.send_on(from, ano::FrameView{bytes}, now);
        return diary.pop_all();
    }
    Tally tally;
};

TEST_F(Watched, an_observer_receives_only_the_events_it_selected) {
    Channel& device = add();
    Channel& taker = add();
    const auto happen = [&] {
        tally = Tally{};
        receive(device, frame(fc, all, 0x03, {1}));
        taker.outbox.set_congested();
        receive(device, frame(fc, all, 0x03, {2}));    // replaces the first
        std::span<const std::uint8_t> piece[1];
        while (taker.outbox.gather(piece, now) == 1) taker.outbox.sent_frame();
        receive(device, frame(fc, 0x77, 0x03, {1}));
        return tally;
    };
    forwarder.add_observer(tally, {true, false, false});
    Tally events = happen();
    EXPECT_EQ(events.in, 3u);
    EXPECT_EQ(events.offers + events.out + events.passed.size() + events.not_sent.size(), 0u);
    forwarder.add_observer(tally, {false, true, false});
    events = happen();
    EXPECT_GE(events.offers, 2u);
    EXPECT_GE(events.passed.size(), 2u);
    EXPECT_EQ(events.in + events.out + events.not_sent.count("superseded"), 0u);
    forwarder.add_observer(tally, {false, false, true});
    Channel& late = add();    // opened while this is observed
    events = happen();
    EXPECT_GT(events.out, 0u);
    EXPECT_GT(events.not_sent.at("superseded"), 0u);
    EXPECT_EQ(events.in + events.offers, 0u);
    std::span<const std::uint8_t> piece[1];
    ASSERT_EQ(late.outbox.gather(piece, now), 1u);
    tally = {};
    late.outbox.sent_frame();
    EXPECT_EQ(tally.out, 1u);
    forwarder.remove_observer(tally);
    events = happen();
    EXPECT_EQ(events.in + events.out + events.offers, 0u);
    EXPECT_TRUE(forwarder.is_observed()) << "by the diary";
}

TEST_F(Watched, a_removed_link_is_reported) {
    Channel& device = add();
    forwarder.add_observer(tally, {false, false, false});
    forwarder.remove_link(device.link);
    EXPECT_EQ(tally.removals, 1u);
}

TEST_F(Watched, each_offered_frame_is_sent_or_dropped_with_a_cause) {
    Channel& device = add();
    Channel& slow = add_with([](ForwarderLink& link) { link.outbox.bytes = 4104; });
    slow.outbox.set_congested();
    for (std::uint8_t n = 0; n < 200; ++n) receive(device, frame(fc, all, 0x03, {n}));    // newer ones replace older ones
    slow.outbox.set_congested();
    for (std::uint8_t n = 0; n < 200; ++n) {
        slow.outbox.set_congested();
        receive(device, frame(fc, all, 0x03, {n}));
        receive(device, frame(fc, all, 0xF1, Bytes(100, n)));
    }
    EXPECT_GT(tally.not_sent["superseded"], 100u);
    EXPECT_GT(tally.not_sent["queue_full"], 100u);
    std::span<const std::uint8_t> piece[1];
    ASSERT_EQ(slow.outbox.gather(piece, now), 1u);
    slow.outbox.sent_frame();
    ASSERT_EQ(slow.outbox.gather(piece, now), 1u);
    slow.outbox.drop_frame(&SendCounters::send_failed);
    now += 1h;
    EXPECT_EQ(slow.outbox.gather(piece, now), 0u);
    EXPECT_GT(tally.not_sent["stale"], 0u);
    receive(device, telemetry);
    forwarder.link_down(slow.link);
    EXPECT_EQ(tally.not_sent["link_down"], 1u);
    expect_as_counted(slow);
    EXPECT_EQ(tally.out, 1u);
}

TEST_F(Watched, sent_frames_are_reported_as_the_receiver_sees_them) {
    Channel& device = add();
    Channel& ground = add_with([](ForwarderLink& link) { link.present_as = 0x20; });
    receive(ground, frame(host, fc, 0xC0, {1, 2, 3}));
    receive(device, frame(fc, host, 0x00, {0xC0, 1, 2}));
    taken(device);
    EXPECT_EQ(tally.last_left, frame(host, fc, 0xC0, {1, 2, 3}));
}

TEST_F(Watched, passed_frames_are_reported_as_other_links_see_them_and_filtered_ones_are_not) {
    Channel& aliased = add_with([](ForwarderLink& link) {
        link.aliases = {{fc, 31}};
        link.rules.receive = without(0x03);
    });
    receive(aliased, telemetry);
    EXPECT_TRUE(tally.passed.empty());
    receive(aliased, frame(fc, host, 0xE1, {1, 0, 7}));
    EXPECT_EQ(tally.passed, Frames{frame(31, host, 0xE1, {1, 0, 7})}) << "though nobody takes it";
}

TEST_F(Watched, an_answer_to_the_gateway_has_a_receiver) {
    Channel& device = add();
    const Bytes answer = frame(fc, host, 0xE1, {1, 0, 7});
    receive(device, answer);
    EXPECT_EQ(device.received().no_route, 1u);
    tally.takes = true;
    receive(device, answer);
    EXPECT_EQ(device.received().no_route, 1u);
}

TEST_F(Watched, requests_that_wait_for_the_outbox_are_reported_too) {
    Channel& ground = add();
    Channel& few = add_with([](ForwarderLink& link) {
        link.limits_questions = true;
        link.sends_empty = false;
    });
    for (std::uint8_t n = 0; n < 20; ++n) receive(ground, frame(host, 0xFF, 0xE0, {1, n, 0}));
    ASSERT_GT(few.questions->waiting(), 0u);
    const auto waits = few.waiting();
    forwarder.link_down(few.link);
    EXPECT_EQ(tally.not_sent["link_down"], waits);
    expect_as_counted(few);
}

TEST_F(Watched, a_later_channel_is_observed_until_the_last_observer_is_removed) {
    Channel& device = add();
    Channel& late = add();
    receive(device, telemetry);
    taken(late);
    EXPECT_EQ(tally.out, 1u);
    forwarder.remove_observer(tally);
    forwarder.remove_observer(diary);
    receive(device, frame(fc, all, 0x03, {9}));
    taken(late);
    EXPECT_EQ(tally.out, 1u);
}

TEST_F(Watched, the_version_changes_when_links_and_channels_are_added_or_removed) {
    std::uint64_t before = forwarder.version();
    const auto changes = [&] { return std::exchange(before, forwarder.version()) != forwarder.version(); };
    const LinkId link = forwarder.add_link({});
    EXPECT_TRUE(changes());
    Channel* const channel = forwarder.open_channel(link, "", now);
    EXPECT_TRUE(changes());
    receive(*channel, telemetry);
    EXPECT_FALSE(changes());
    forwarder.close_channel(*channel);
    EXPECT_TRUE(changes());
    forwarder.remove_link(link);
    EXPECT_TRUE(changes());
}

TEST_F(Watched, a_frame_of_the_gateway_is_routed_and_teaches_no_address) {
    Channel& device = add();
    Channel& ground = add();
    Channel& control = add_with([](ForwarderLink& link) { link.route.broadcast = link.route.flood = false; });
    receive(device, telemetry);
    Channel own = sender_of(control);
    EXPECT_EQ(sent(own, command), (Lines{"received 64", "said 0"}));
    EXPECT_EQ(sent(own, frame(host, all, 0xE0, {0, 1, 0})), (Lines{"received 64", "said 0", "said 1"}));
    EXPECT_TRUE(forwarder.router().learned(host, now).links.empty()) << "0xFE is nowhere yet";
    receive(ground, command);
    EXPECT_EQ(forwarder.router().learned(host, now).links, LinkSet{ground.link});
    sent(own, frame(host, fc, 0xC0, {7}));
    EXPECT_EQ(forwarder.router().learned(host, now).links, LinkSet{ground.link}) << "as it is without what we send";
    EXPECT_TRUE(forwarder.router().conflicts(now).empty());
    sent(own, frame(fc, all, 0x03, {1}));
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{device.link});
    EXPECT_TRUE(forwarder.router().conflicts(now).empty());
}

TEST_F(Watched, rules_and_switches_of_its_link_apply_to_a_frame_of_the_gateway) {
    add();
    Channel& control = add_with([](ForwarderLink& link) {
        link.route.broadcast = link.route.flood = false;
        link.rules.receive = without(0xC0);
    });
    Channel own = sender_of(control);
    EXPECT_EQ(sent(own, command), (Lines{"received 64", "dropped 64 denied_in"}));
    EXPECT_EQ(own.routed.denied_in, 1u);
    const std::size_t place = forwarder.inhibit().add(LinkSet{control.link});
    forwarder.inhibit().set(place, true);
    EXPECT_EQ(sent(own, frame(host, fc, 0x40, {1, 2, 3})), (Lines{"received 64", "dropped 64 inhibited"}));
    forwarder.inhibit().set(place, false);
    EXPECT_EQ(sent(own, frame(host, 0x00, 0x03, {1})), (Lines{"received 64", "dropped 64 no_route"}));
}

TEST_F(Watched, a_frame_of_the_gateway_that_returns_is_dropped) {
    Channel& out = add();
    Channel& back = add();
    Channel& control = add_with([](ForwarderLink& link) { link.route.broadcast = link.route.flood = false; });
    Channel own = sender_of(control);
    const Bytes spread = frame(0xA0, all, 0x03, {1, 2});
    EXPECT_EQ(sent(own, spread), (Lines{"received 64", "said 0", "said 1"}));
    now += 5ms;
    receive(back, spread);
    EXPECT_EQ(out.sent().offered, 3u) << "it may be another device's, and a probe leaves";
    for (const Bytes& bytes : taken(out))
        if (is_probe(ano::FrameView{bytes})) receive(back, bytes);
    EXPECT_EQ(events(back, spread).at(1), "dropped 1 looped");
}

TEST_F(Watched, a_single_channel_may_have_a_port_id) {
    Channel& device = add();
    const LinkId link = forwarder.add_link({});
    Channel* const bearer = forwarder.open_channel(link, "a", now);
    forwarder.open_channel(link, "b", now);
    forwarder.link_up(link, now);
    forwarder.bear(*bearer, 7);
    EXPECT_EQ(events(device, frame(fc, 7, 0x03, {1})), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(forwarder.router().port(7), LinkSet{link});
    forwarder.close_channel(*bearer);
    EXPECT_TRUE(forwarder.router().port(7).empty());
    EXPECT_EQ(events(device, frame(fc, 7, 0x03, {2})), (Lines{"received 0", "offered 2"})) << "unknown";
}

}    // namespace
}    // namespace forwarder_watched_tests
