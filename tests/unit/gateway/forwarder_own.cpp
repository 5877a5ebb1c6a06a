// The gateway as a device: what reaches it, and what becomes of its answers.
#include "forwarding.hpp"

#include <vector>

using namespace forwarding;

namespace forwarder_own_tests {
namespace {

constexpr std::uint8_t self = 21;

class Taker final : public Forwarder::Own {
public:
    void take(const Channel& from, ano::FrameView frame, TimePoint) override {
        frames.emplace_back(frame.bytes().begin(), frame.bytes().end());
        by.push_back(from.id);
    }
    std::vector<Bytes> frames;
    std::vector<ChannelId> by;
};

class OwnFrames : public Forwarding {
protected:
    OwnFrames() {
        GatewaySettings settings;
        settings.id = self;
        forwarder.set(settings);
        forwarder.set_own(&taker);
    }
    Taker taker;
};

TEST_F(OwnFrames, are_those_for_its_id_and_for_everybody) {
    Channel& ground = add();
    Channel& device = add();
    const Bytes question = frame(host, self, 0xE0, {0, 0, 0}), to_all = frame(host, all, 0xE0, {0, 0, 0});
    receive(ground, question);
    receive(ground, to_all);
    receive(device, telemetry);
    receive(ground, command);
    EXPECT_EQ(taker.frames, (Frames{question, to_all, telemetry}));
    EXPECT_EQ(taker.by, (std::vector{ground.id, ground.id, device.id}));
    forwarder.set_own(nullptr);
    receive(ground, question);
    EXPECT_EQ(taker.frames.size(), 3u);
}

TEST_F(OwnFrames, that_a_filter_or_a_switch_keeps_back_do_not_reach_it) {
    Channel& filtered = add_with([](ForwarderLink& link) { link.rules.receive = without(0xE1); });
    Channel& inhibited = add();
    forwarder.inhibit().set(forwarder.inhibit().add(LinkSet{inhibited.link}), true);
    const Bytes write = frame(host, self, 0xE1, {0, 0, 1});
    EXPECT_EQ(told(filtered, write), (Lines{"received 0", "dropped 0 denied_in"}));
    EXPECT_EQ(told(inhibited, write), (Lines{"received 1", "dropped 1 inhibited"}));
    EXPECT_TRUE(taker.frames.empty());
    receive(inhibited, frame(host, self, 0xE0, {1, 0, 0}));
    EXPECT_EQ(taker.frames.size(), 1u) << "a question changes nothing";
}

TEST_F(OwnFrames, of_the_control_interface_reach_it_as_well) {
    const LinkId control = forwarder.add_link({});
    Channel own{ourselves, control, "", ano::FrameParser::Options{}, Outbox::Options{ano::overhead, 0}, now};
    const Bytes question = frame(host, self, 0xE0, {0, 0, 0});
    forwarder.send_on(own, ano::FrameView{question}, now);
    EXPECT_EQ(taker.frames, Frames{question});
    EXPECT_EQ(taker.by, std::vector{ourselves});
    EXPECT_EQ(own.routed.no_route, 0u);
}

TEST_F(OwnFrames, answers_go_to_who_asked_alone_pass_the_rules_and_teach_no_address) {
    Channel& ground = add();
    Channel& other = add();
    Channel& strict = add_with([](ForwarderLink& link) { link.rules.send = without(0xE3); });
    const Bytes answer = frame(self, host, 0xE3, {self});
    forwarder.answer(ground.id, ano::FrameView{answer}, now);
    forwarder.answer(strict.id, ano::FrameView{answer}, now);
    EXPECT_EQ(taken(ground), Frames{answer});
    EXPECT_TRUE(taken(other).empty());
    EXPECT_EQ(strict.sent().denied_out, 1u);
    EXPECT_FALSE(forwarder.router().heard_at(self, ground.id));
    now += 5ms;
    receive(other, answer);
    EXPECT_EQ(other.routed.looped, 1u) << "it came round";
    EXPECT_TRUE(taken(ground).empty());
    EXPECT_TRUE(taker.frames.empty());
}

TEST_F(OwnFrames, lines_for_hosts_go_where_one_was_heard_and_nowhere_else) {
    Channel& ground = add();
    Channel& device = add();
    Channel& tablet = add();
    const Bytes line = frame(self, host, 0xA0, {0, 'u', 'p'});
    forwarder.say_to_heard(ano::FrameView{line}, now);
    EXPECT_TRUE(taken(ground).empty()) << "nobody was heard";
    receive(ground, frame(host, self, 0xE0, {0, 0, 0}));
    receive(tablet, frame(host, self, 0xE0, {0, 0, 0}));
    receive(device, frame(fc, self, 0x03, {1}));
    forwarder.say_to_heard(ano::FrameView{line}, now);
    EXPECT_EQ(taken(ground), Frames{line});
    EXPECT_EQ(taken(tablet), Frames{line});
    EXPECT_TRUE(taken(device).empty());
}

}    // namespace
}    // namespace forwarder_own_tests
