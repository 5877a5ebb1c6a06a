// Recorded frames that are sent again, together with live devices.
#include "forwarding.hpp"

namespace forwarder_replay_tests {
namespace {

using namespace forwarding;

class Replayed : public Forwarding {
protected:
    Channel& replay = add_with([](ForwarderLink& link) { link.route = {0, false, false, 0, false}; });
    Channel& live = add();
    Channel& ground = add();

    bool knows(std::uint8_t address) const { return !forwarder.router().learned(address, now).links.empty(); }
    bool is_behind(std::uint8_t address, const Channel& channel) const {
        return forwarder.router().learned(address, now).links == LinkSet{channel.link};
    }
};

TEST_F(Replayed, frames_are_forwarded_normally_and_teach_no_address) {
    receive(replay, telemetry);
    EXPECT_EQ(taken(ground), Frames{telemetry});
    EXPECT_EQ(taken(live), Frames{telemetry});
    EXPECT_FALSE(knows(fc));
    receive(ground, command);
    const Bytes answer = frame(fc, host, 0x03, {4, 5, 6});
    receive(replay, answer);
    EXPECT_EQ(taken(ground), Frames{answer});
    EXPECT_TRUE(taken(replay).empty());
}

TEST_F(Replayed, sources_are_recorded_at_the_replay_link_only) {
    receive(replay, telemetry);
    receive(live, frame(0x30, all, 0x03, {1}));
    EXPECT_TRUE(forwarder.traffic(replay.link).replayed.test(fc));
    EXPECT_EQ(forwarder.traffic(replay.link).replayed.count(), 1u);
    EXPECT_TRUE(forwarder.traffic(live.link).replayed.none());
}

TEST_F(Replayed, a_live_device_gets_its_address_with_its_first_frame_even_if_a_replay_sent_the_same) {
    receive(replay, telemetry);
    receive(live, telemetry);
    EXPECT_TRUE(is_behind(fc, live));
    taken(live);
    receive(replay, frame(fc, all, 0x03, {9}));
    EXPECT_TRUE(is_behind(fc, live));
    taken(live);
    receive(ground, command);
    EXPECT_EQ(taken(live), Frames{command});
    EXPECT_TRUE(taken(replay).empty());
}

TEST_F(Replayed, frames_do_not_cause_drops_of_the_same_frames_of_a_live_device) {
    std::size_t heard = 0;
    for (int i = 0; i < 200; ++i, now += 20ms) {
        receive(i % 2 == 0 ? replay : live, telemetry);
        for (const Bytes& bytes : taken(ground)) heard += bytes == telemetry;
        taken(live);
    }
    EXPECT_EQ(live.received().looped, 0u);
    EXPECT_EQ(replay.received().looped, 0u);
    EXPECT_EQ(heard, 200u);
}

TEST_F(Replayed, frames_do_not_conflict_with_a_live_device) {
    for (int i = 0; i < 100; ++i, now += 50ms) {
        receive(live, frame(fc, all, 0x03, {static_cast<std::uint8_t>(i)}));
        receive(replay, frame(fc, all, 0x03, {static_cast<std::uint8_t>(i)}));
        receive(replay, frame(fc, all, 0x04, {static_cast<std::uint8_t>(i)}));
    }
    EXPECT_TRUE(forwarder.router().conflicts(now).empty());
    EXPECT_FALSE(forwarder.pop_conflict());
    EXPECT_TRUE(is_behind(fc, live));
}

TEST_F(Replayed, frames_of_a_device_pinned_elsewhere_cause_no_conflict) {
    forwarder.pin(fc, fc, live.link);
    receive(replay, telemetry);
    EXPECT_TRUE(forwarder.router().conflicts(now).empty());
    EXPECT_EQ(taken(ground), Frames{telemetry});
}

TEST_F(Replayed, a_switch_drops_frames_that_command_a_vehicle) {
    const std::size_t inhibit = forwarder.inhibit().add(LinkSet{replay.link});
    EXPECT_EQ(events(replay, command), (Lines{"received 0", "dropped 0 inhibited"}));
    forwarder.inhibit().set(inhibit, false);
    EXPECT_EQ(events(replay, command), (Lines{"received 0", "offered 1", "offered 2"}));
}

TEST_F(Replayed, frames_do_not_count_as_answers_to_current_requests) {
    class Asks final : public Forwarder::Observer {
    public:
        void received(const Channel&, ano::FrameView, TimePoint) override {}
        bool passes(const Channel&, ano::FrameView) override { return was_asked = true; }
        void offered(const Channel&, ano::FrameView, ChannelId) override {}
        void dropped(const Channel&, ano::FrameView, ReceiveCause) override {}
        void refused(LinkId, ano::FrameView, SendCause) override {}
        bool was_asked = false;
    } asks;
    forwarder.add_observer(asks);
    receive(replay, telemetry);
    EXPECT_FALSE(asks.was_asked);
    receive(live, telemetry);
    EXPECT_TRUE(asks.was_asked);
}

// Two links to one other gateway, which returns on each the frames that it received on the other.
TEST_F(Replayed, frames_do_not_circulate_in_a_loop) {
    std::size_t round = 0;
    for (int i = 0; i < 50; ++i) {
        receive(replay, frame(fc, all, 0x03, {static_cast<std::uint8_t>(i)}));
        for (int hop = 0; hop < 20; ++hop, now += 1ms) {
            const Frames by_live = taken(live), by_ground = taken(ground);
            for (const Bytes& bytes : by_live) receive(ground, bytes);
            for (const Bytes& bytes : by_ground) receive(live, bytes);
            if (i > 0) round += by_live.size() + by_ground.size();
        }
    }
    EXPECT_LT(round, 49 * 6u);
}

}    // namespace
}    // namespace forwarder_replay_tests
