// The gateway as a device: the frames that reach it, and the path of its answers.
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

TEST_F(OwnFrames, are_those_for_its_id_and_broadcasts) {
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

TEST_F(OwnFrames, that_a_filter_or_a_switch_drops_do_not_reach_the_gateway) {
    Channel& filtered = add_with([](ForwarderLink& link) { link.rules.receive = without(0xE1); });
    Channel& inhibited = add();
    forwarder.inhibit().set(forwarder.inhibit().add(LinkSet{inhibited.link}), true);
    const Bytes write = frame(host, self, 0xE1, {0, 0, 1});
    EXPECT_EQ(events(filtered, write), (Lines{"received 0", "dropped 0 denied_in"}));
    EXPECT_EQ(events(inhibited, write), (Lines{"received 1", "dropped 1 inhibited"}));
    EXPECT_TRUE(taker.frames.empty());
    receive(inhibited, frame(host, self, 0xE0, {1, 0, 0}));
    EXPECT_EQ(taker.frames.size(), 1u) << "a question changes nothing";
}

TEST_F(OwnFrames, of_the_control_interface_reach_the_gateway_too) {
    const LinkId control = forwarder.add_link({});
    Channel own{ourselves, control, "", ano::FrameParser::Options{}, Outbox::Options{ano::overhead, 0}, now};
    const Bytes question = frame(host, self, 0xE0, {0, 0, 0});
    forwarder.send_on(own, ano::FrameView{question}, now);
    EXPECT_EQ(taker.frames, Frames{question});
    EXPECT_EQ(taker.by, std::vector{ourselves});
    EXPECT_EQ(own.routed.no_route, 0u);
}

// RS-485, or a single wire: the receiver is not muted while it sends.
TEST_F(OwnFrames, that_a_line_echoes_do_not_count_as_frames_of_another_host) {
    Channel& line = add();
    Channel& ground = add();
    const LinkId control = forwarder.add_link({});
    Channel own{ourselves, control, "", ano::FrameParser::Options{}, Outbox::Options{ano::overhead, 0}, now};
    receive(line, telemetry);
    for (std::uint8_t value = 0; value < 6; ++value) {
        const Bytes write = frame(host, fc, 0xE1, {0, 0, value});
        own.arrived_at = now;
        forwarder.send_on(own, ano::FrameView{write}, now);
        now += 5ms;
        EXPECT_EQ(events(line, write).at(1), "dropped 0 looped");
        EXPECT_FALSE(line.echo.is_echo(frame_key(ano::FrameView{write}), false, now)) << "once for each that was sent";
    }
    EXPECT_FALSE(forwarder.router().heard_at(host, line.id));
    EXPECT_FALSE(forwarder.traffic(line.link).not_sent.lately(now));
    EXPECT_TRUE(line.echo.echoes(now));
    const Bytes forwarded = frame(host, fc, 0xE1, {0, 0, 99});
    receive(ground, forwarded);
    EXPECT_EQ(events(line, forwarded).at(1), "dropped 0 looped") << "of a host on another link";
    now += EchoWatch::reported_for;
    EXPECT_FALSE(line.echo.echoes(now));
}

TEST_F(OwnFrames, the_same_request_from_a_host_on_that_line_is_not_an_echo) {
    Channel& line = add();
    Channel& device = add();
    const LinkId control = forwarder.add_link({});
    Channel own{ourselves, control, "", ano::FrameParser::Options{}, Outbox::Options{ano::overhead, 0}, now};
    receive(device, telemetry);
    receive(line, telemetry);    // the gateway asks both
    receive(line, frame(host, fc, 0xE0, {2, 7, 0}));
    const Bytes question = frame(host, fc, 0xE0, {2, 1, 0});
    own.arrived_at = now;
    forwarder.send_on(own, ano::FrameView{question}, now);
    EXPECT_EQ(line.received().looped, 0u);
    receive(line, question);
    EXPECT_EQ(line.received().looped, 0u) << "a host was heard there, and a single one may be its own";
}

// The device returns the value that the host wrote: both have one address.
TEST_F(OwnFrames, a_read_back_of_a_device_with_the_address_of_the_host_is_no_echo) {
    Channel& line = add();
    Channel& ground = add();
    const Bytes write = frame(fc, fc, 0xE1, {0, 0, 1});
    receive(line, telemetry);
    for (int i = 0; i < 9; ++i) {
        receive(ground, write);
        receive(line, write);
    }
    EXPECT_EQ(line.received().looped, 0u);
}

// 0x00 and 0xFF are not addresses: two boards without one may send the same bytes.
TEST(Nobodies, on_two_links_are_neither_one_device_nor_a_loop) {
    for (const std::uint8_t nobody : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        Forwarder forwarder{GatewaySettings{}, 7};
        TimePoint now = start;
        std::vector<Channel*> channels;
        for (int i = 0; i < 3; ++i) {
            const LinkId link = forwarder.add_link({});
            channels.push_back(forwarder.open_channel(link, "", now));
            forwarder.link_up(link, now);
        }
        const auto receive = [&](Channel& from, const Bytes& bytes) {
            from.arrived_at = now;
            forwarder.receive(from, ano::FrameView{bytes}, now);
        };
        receive(*channels[2], frame(host, all, 0xE0, {0, 0, 0}));
        for (int i = 0; i < 100; ++i) {
            now += 50ms;
            for (const std::size_t board : {std::size_t{0}, std::size_t{1}}) {
                receive(*channels[board], frame(nobody, host, 0x03, Bytes(7)));
                receive(*channels[board], frame(nobody, all, 0x04, Bytes(9)));
            }
        }
        EXPECT_TRUE(forwarder.router().conflicts(now).empty());
        for (const std::size_t board : {std::size_t{0}, std::size_t{1}}) {
            EXPECT_FALSE(forwarder.loops().loop(channels[board]->id, now));
            EXPECT_EQ(channels[board]->received().looped + channels[board]->received().duplicate, 0u);
            EXPECT_TRUE(forwarder.traffic(channels[board]->link).nobody.lately(now)) << "the hint: set its id";
        }
    }
}

TEST_F(OwnFrames, answers_are_sent_only_to_the_requester_obey_the_rules_and_teach_no_address) {
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
    EXPECT_TRUE(taker.frames.empty());
    close_loop(ground, other);
    EXPECT_EQ(events(other, answer).at(1), "dropped 1 looped") << "it came round";
}

TEST_F(OwnFrames, log_lines_for_hosts_are_sent_only_where_a_host_was_received) {
    Channel& ground = add();
    Channel& device = add();
    Channel& tablet = add();
    const Bytes line = frame(self, host, 0xA0, {0, 'u', 'p'});
    forwarder.send_to_active_channels(ano::FrameView{line}, now);
    EXPECT_TRUE(taken(ground).empty()) << "nobody was heard";
    receive(ground, frame(host, self, 0xE0, {0, 0, 0}));
    receive(tablet, frame(host, self, 0xE0, {0, 0, 0}));
    receive(device, frame(fc, self, 0x03, {1}));
    forwarder.send_to_active_channels(ano::FrameView{line}, now);
    EXPECT_EQ(taken(ground), Frames{line});
    EXPECT_EQ(taken(tablet), Frames{line});
    EXPECT_TRUE(taken(device).empty());
}

}    // namespace
}    // namespace forwarder_own_tests
