// The order of the steps as arithmetic: which step counts a frame that several would drop, and the events of observers.
#include "forwarding.hpp"

namespace forwarder_tests {

using namespace forwarding;

TEST_F(Forwarding, a_received_frame_is_offered_to_its_channels) {
    Channel& device = add();
    Channel& ground = add();
    Channel& other = add();
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "offered 1", "offered 2"}));
    EXPECT_EQ(forwarder.next_to_flush(), &ground);
    EXPECT_EQ(taken(ground), Frames{telemetry});
    EXPECT_EQ(forwarder.next_to_flush(), &other);
    EXPECT_EQ(forwarder.next_to_flush(), nullptr) << "each once";
    EXPECT_EQ(events(ground, command), (Lines{"received 1", "offered 0"})) << "learned";
    EXPECT_EQ(device.heard_at, now);
}

TEST_F(Forwarding, frames_without_a_receiver_are_counted_and_reported) {
    Channel& device = add();
    add_with([](ForwarderLink& link) { link.route.flood = link.route.broadcast = false; });
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "dropped 0 no_route"}));
    EXPECT_EQ(device.routed.no_route, 1u);
    EXPECT_FALSE(forwarder.traffic(device.link).undelivered.duration(now)) << "it was not for hosts";
    receive(device, frame(fc, host, 0x03, {1}));
    EXPECT_TRUE(forwarder.traffic(device.link).undelivered.duration(now));
}

TEST_F(Forwarding, frames_for_a_host_that_reach_only_links_that_are_down_have_no_receiver) {
    Channel& device = add();
    Channel& ground = add();
    receive(ground, frame(host, all, 0xE0, {0, 0, 0}));
    forwarder.link_down(ground.link);
    const Bytes to_host = frame(fc, host, 0x03, {1});
    EXPECT_EQ(events(device, to_host), (Lines{"received 0", "refused 1 link_down"}));
    EXPECT_TRUE(forwarder.traffic(device.link).undelivered.duration(now));
    EXPECT_EQ(device.routed.no_route, 0u);
    Channel& listener = add();
    receive(device, to_host);
    EXPECT_EQ(taken(listener), Frames{to_host});
    EXPECT_FALSE(forwarder.traffic(device.link).undelivered.duration(now));
    forwarder.link_down(listener.link);
    receive(device, to_host);
    EXPECT_TRUE(forwarder.traffic(device.link).undelivered.duration(now));
    forwarder.link_up(ground.link, now);
    receive(device, to_host);
    EXPECT_FALSE(forwarder.traffic(device.link).undelivered.duration(now));
}

TEST_F(Forwarding, frames_for_a_link_without_a_channel_are_counted_at_that_link) {
    Channel& ground = add();
    const LinkId absent = forwarder.add_link({});
    forwarder.pin(fc, fc, absent);
    EXPECT_EQ(events(ground, command), (Lines{"received 0", "refused 1 link_down"}));
    EXPECT_EQ(forwarder.traffic(absent).gone_sent.link_down, 1u);
    EXPECT_EQ(forwarder.traffic(absent).gone_sent.offered, 1u);
    EXPECT_EQ(ground.routed.no_route, 0u);
}

TEST_F(Forwarding, frames_that_the_outbox_refuses_are_reported) {
    Channel& device = add();
    Channel& small = add_with([](ForwarderLink& link) { link.outbox.max_data = 3; });
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "offered 1"})) << "exactly max_data";
    EXPECT_EQ(events(device, frame(fc, all, 0x03, {1, 2, 3, 4})), (Lines{"received 0", "refused 1 too_big"}));
    EXPECT_EQ(small.sent().too_big, 1u);
    forwarder.link_down(small.link);
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "refused 1 link_down"}));
    EXPECT_EQ(small.sent().link_down, 2u) << "that one, and the one that waited";
}

TEST_F(Forwarding, exactly_max_data_passes_every_rewriting) {
    const Bytes largest(64, 0x11);
    const auto of_64 = [](ForwarderLink& link) { link.parser.max_data = link.outbox.max_data = 64; };
    Channel& device = add_with([&](ForwarderLink& link) {
        of_64(link);
        link.aliases = {{fc, 31}};
    });
    Channel& presented = add_with([&](ForwarderLink& link) {
        of_64(link);
        link.present_as = 0x20;
    });
    receive(device, frame(fc, all, 0x03, largest));
    EXPECT_EQ(taken(presented), Frames{frame(31, all, 0x03, largest)});
    receive(presented, frame(host, 31, 0xC0, largest));
    EXPECT_EQ(taken(device), Frames{frame(host, fc, 0xC0, largest)});
    receive(device, frame(host, 0x55, 0xC0, largest));
    EXPECT_EQ(taken(presented), Frames{frame(0x20, 0x55, 0xC0, largest)});
}

// A filter applies to the received frames of a link, so it counts before the switch; neither counts looped or duplicate frames.
TEST_F(Forwarding, a_dropped_frame_is_counted_at_the_first_step_that_drops_it) {
    const auto guarded = [](ForwarderLink& link) {
        link.rules.receive = without(0xC0);
        link.route.group = 1;
    };
    Channel& device = add();
    Channel& radio = add_with(guarded);
    Channel& wifi = add_with(guarded);
    LinkSet both{radio.link};
    both.insert(wifi.link);
    forwarder.inhibit().add(both);
    receive(device, telemetry);
    EXPECT_EQ(events(radio, command), (Lines{"received 1", "dropped 1 denied_in"})) << "the filter before the switch";
    EXPECT_EQ(events(wifi, command), (Lines{"received 2", "dropped 2 duplicate"})) << "a copy before the filter";
    EXPECT_EQ(events(radio, telemetry), (Lines{"received 1", "offered 0", "offered 1", "offered 0"}))
        << "with probes ahead of it";
    for (const Bytes& bytes : taken(device))
        if (is_probe(ano::FrameView{bytes})) receive(radio, bytes);
    EXPECT_EQ(events(radio, telemetry).at(1), "dropped 1 looped") << "what went round before all";
    const Bytes parameter = frame(host, fc, 0xE1, {1, 0, 0});
    EXPECT_EQ(events(radio, parameter), (Lines{"received 1", "dropped 1 inhibited"}));
    EXPECT_EQ(radio.routed.denied_in + radio.routed.inhibited + radio.routed.looped + radio.routed.duplicate, 4u)
        << "and the probe";
    EXPECT_EQ(radio.routed.no_route, 0u);
}

TEST_F(Forwarding, filtered_frames_teach_no_address) {
    Channel& ground = add();
    Channel& device = add_with([](ForwarderLink& link) { link.rules.receive = without(0x03); });
    Channel& other = add();
    receive(device, telemetry);
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{});
    receive(device, frame(fc, all, 0x04, {1}));
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{device.link});
    EXPECT_EQ(events(ground, command), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(device.routed.denied_in, 1u);
    EXPECT_EQ(other.sent().offered, 1u);
}

TEST_F(Forwarding, a_frame_for_several_channels_of_a_link_counts_once_for_its_limits) {
    Channel& device = add();
    Channel& first = add_with([](ForwarderLink& link) { link.rules.limit = {{0x03, 1}}; });
    Channel& second = *forwarder.open_channel(first.link, "peer", now);
    forwarder.link_up(first.link, now);
    now += 1ms;
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "offered 1", "offered 2"}));
    now += 100ms;
    EXPECT_EQ(events(device, frame(fc, all, 0x03, {4})), (Lines{"received 0", "refused 1 limited", "refused 1 limited"}));
    EXPECT_EQ(first.sent().limited + second.sent().limited, 2u);
}

TEST_F(Forwarding, frames_received_stale_do_not_count_for_a_limit) {
    Channel& device = add();
    Channel& slow = add_with([](ForwarderLink& link) { link.rules.limit = {{0x03, 1}}; });
    device.arrived_at = now - 2s;
    diary.pop_all();
    forwarder.receive(device, ano::FrameView{telemetry}, now);
    EXPECT_EQ(diary.pop_all(), (Lines{"received 0", "refused 1 stale"}));
    EXPECT_EQ(forwarder.traffic(slow.link).came_stale, 1u);
    EXPECT_EQ(events(device, frame(fc, all, 0x03, {4})), (Lines{"received 0", "offered 1"}));
}

TEST_F(Forwarding, time_spent_waiting_to_be_read_counts_to_the_age_in_the_queue) {
    Channel& device = add();
    Channel& ground = add();
    device.arrived_at = now - 700ms;
    forwarder.receive(device, ano::FrameView{telemetry}, now);
    now += 400ms;
    EXPECT_EQ(taken(ground), Frames{}) << "telemetry is of use for a second";
    EXPECT_EQ(ground.sent().stale, 1u);
}

// If an unknown sender replaced a host, only frames of hosts justify a question.
TEST_F(Forwarding, a_channel_records_whether_a_host_sent_to_it) {
    Channel& a = add();
    Channel& b = add();
    receive(a, telemetry);
    EXPECT_FALSE(b.had_host_frames);
    receive(a, frame(host, all, 0xE0, {0, 0, 0}));
    EXPECT_TRUE(b.had_host_frames);
    EXPECT_FALSE(a.had_host_frames);
    receive(a, telemetry);
    EXPECT_TRUE(b.had_host_frames) << "for good";
}

TEST_F(Forwarding, a_filter_counts_the_frames_that_it_drops) {
    Channel& device = add();
    Channel& ground = add_with([](ForwarderLink& link) {
        link.rules.send = without(0x03);
        link.sends_empty = false;
    });
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "refused 1 denied_out"}));
    EXPECT_EQ(events(device, frame(fc, all, 0x04)), (Lines{"received 0", "refused 1 denied_out"}));
    EXPECT_EQ(events(device, frame(fc, all, 0x04, {1})), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(ground.sent().denied_out, 2u);
}

TEST_F(Forwarding, an_aliased_device_is_reached_by_its_alias_only) {
    Channel& aliased = add_with([](ForwarderLink& link) { link.aliases = {{fc, 31}}; });
    Channel& ground = add();
    receive(aliased, telemetry);
    EXPECT_EQ(taken(ground), Frames{frame(31, all, 0x03, {1, 2, 3})});
    EXPECT_EQ(forwarder.router().pinned(31), LinkSet{aliased.link});
    EXPECT_EQ(events(ground, command), (Lines{"received 1", "refused 0 denied_out"}));
    receive(ground, frame(host, 31, 0xC0, {1}));
    EXPECT_EQ(taken(aliased), Frames{frame(host, fc, 0xC0, {1})});
}

TEST_F(Forwarding, a_source_is_elsewhere_if_its_visible_id_is_learned_or_pinned_on_another_link) {
    Channel& aliased = add_with([](ForwarderLink& link) { link.aliases = {{fc, 31}}; });
    Channel& home = add();
    Channel& stranger = add();
    receive(home, frame(fc, all, 0x03, {1}));
    EXPECT_FALSE(forwarder.is_elsewhere(home, fc));
    EXPECT_FALSE(forwarder.is_elsewhere(aliased, fc)) << "it appears as 31, which is pinned there";
    EXPECT_TRUE(forwarder.is_elsewhere(stranger, fc)) << "learned elsewhere";
    EXPECT_TRUE(forwarder.is_elsewhere(stranger, 31)) << "pinned elsewhere";
    EXPECT_FALSE(forwarder.is_elsewhere(stranger, 0x55)) << "at home nowhere";
    EXPECT_FALSE(forwarder.is_elsewhere(stranger, host));
    const Channel own{ourselves, stranger.link, "send", ano::FrameParser::Options{}, Outbox::Options{}, now};
    EXPECT_FALSE(forwarder.is_elsewhere(own, fc));
}

TEST_F(Forwarding, a_copy_is_recognized_by_its_bytes_before_the_alias_is_applied) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    Channel& radio = add_with([&](ForwarderLink& link) {
        grouped(link);
        link.aliases = {{fc, 31}};
    });
    Channel& wifi = add_with(grouped);
    add();
    receive(radio, telemetry);
    EXPECT_EQ(events(wifi, telemetry), (Lines{"received 1", "dropped 1 duplicate"}));
}

TEST_F(Forwarding, hosts_of_a_group_share_one_address_and_get_answers_by_any_of_its_links) {
    const auto presented = [](std::uint8_t port) {
        return [port](ForwarderLink& link) {
            link.route.group = 1;
            link.route.port_id = port;
            link.present_as = host;
        };
    };
    constexpr std::uint8_t user = 0x55;
    Channel& ground = add();
    Channel& radio = add_with(presented(1));
    Channel& wifi = add_with(presented(2));
    receive(radio, telemetry);
    receive(ground, frame(user, all, 0x04, {1}));
    taken(radio);
    receive(ground, frame(user, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(taken(radio), Frames{frame(host, fc, 0xE0, {2, 5, 0})});
    now += 1s;
    taken(ground);
    receive(wifi, frame(fc, host, 0xE1, {5, 0, 1}));
    EXPECT_EQ(taken(ground), Frames{frame(fc, user, 0xE1, {5, 0, 1})});
}

TEST_F(Forwarding, an_answer_that_returns_is_recognized_in_its_rewritten_form) {
    constexpr std::uint8_t ros = 0xD2;
    Channel& ground = add();
    Channel& radio = add_with([](ForwarderLink& link) { link.present_as = host; });
    add();
    receive(radio, telemetry);
    receive(ground, frame(ros, fc, 0xE0, {2, 5, 0}));
    taken(ground);
    receive(radio, frame(fc, host, 0xE1, {5, 0, 1}));
    const Bytes answer = frame(fc, ros, 0xE1, {5, 0, 1});
    EXPECT_EQ(taken(ground), Frames{answer});
    EXPECT_EQ(events(ground, answer).back(), "dropped 0 no_route") << "a copy may be another device's";
    close_loop(ground, radio);
    EXPECT_EQ(events(ground, answer).at(1), "dropped 0 looped");
}

TEST_F(Forwarding, a_device_on_two_links_of_a_group_is_no_conflict) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    add();
    Channel& radio = add_with(grouped);
    Channel& wifi = add_with(grouped);
    receive(radio, telemetry);
    now += 100ms;
    receive(radio, telemetry);
    now += DuplicateGuard::silence;
    EXPECT_EQ(events(wifi, telemetry), (Lines{"received 2", "offered 0"})) << "the radio failed";
    EXPECT_FALSE(forwarder.pop_conflict());
}

TEST_F(Forwarding, a_group_passes_the_acknowledgement_of_each_command) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    Channel& ground = add();
    Channel& radio = add_with(grouped);
    Channel& wifi = add_with(grouped);
    receive(radio, telemetry);
    const Bytes acknowledgement = frame(fc, host, 0x00, {0xC0, 1, 2});
    for (Channel* const by : {&radio, &wifi, &radio}) {
        receive(ground, command);
        now += 5ms;
        Channel& other = by == &radio ? wifi : radio;
        EXPECT_EQ(events(*by, acknowledgement).back(), "offered 0");
        EXPECT_NE(events(other, acknowledgement).back().find("duplicate"), std::string::npos);
        now += 300ms;
    }
}

TEST_F(Forwarding, waiting_frames_age_while_the_machine_sleeps) {
    Channel& device = add();
    Channel& ground = add();
    receive(device, telemetry);
    forwarder.grow_older(1h);
    EXPECT_EQ(taken(ground), Frames{});
    EXPECT_EQ(ground.sent().stale, 1u);
}

TEST_F(Forwarding, a_group_uses_another_link_after_a_peer_refuses_until_that_peer_sends_again) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    Channel& ground = add();
    Channel& wifi = add_with(grouped);
    Channel& radio = add_with(grouped);
    receive(radio, telemetry);
    now += 10ms;
    receive(wifi, frame(fc, all, 0x04, {1}));
    EXPECT_EQ(events(ground, command), (Lines{"received 0", "offered 1"})) << "heard last";
    forwarder.report_unreachable(wifi.link);
    EXPECT_EQ(events(ground, frame(host, fc, 0xC0, {4})), (Lines{"received 0", "offered 2"}));
    now += 10ms;
    receive(wifi, frame(fc, all, 0x04, {2}));
    EXPECT_EQ(events(ground, frame(host, fc, 0xC0, {5})), (Lines{"received 0", "offered 1"}));
}

TEST_F(Forwarding, frames_that_return_by_a_known_loop_are_dropped) {
    Channel& a = add();
    Channel& b = add();
    const Bytes order = frame(host, all, 0xC0, {1});
    receive(a, order);
    now += 10ms;
    receive(b, order);
    Bytes probe;
    for (const Bytes& bytes : taken(b))
        if (is_probe(ano::FrameView{bytes})) probe = bytes;
    ASSERT_FALSE(probe.empty());
    EXPECT_EQ(events(a, probe), (Lines{"received 0", "dropped 0 looped"})) << "its answer goes no further";
    EXPECT_TRUE(forwarder.loops().loop(a.id, now) && forwarder.loops().loop(b.id, now));
    EXPECT_EQ(events(b, order), (Lines{"received 1", "dropped 1 looped"}));
}

TEST_F(Forwarding, a_copy_that_waited_to_be_read_is_recognized_however_late_it_is_read) {
    Channel& a = add();
    Channel& b = add();
    add();
    receive(a, telemetry);
    diary.pop_all();
    b.arrived_at = now + 50ms;
    now += 10s;
    forwarder.receive(b, ano::FrameView{telemetry}, now);
    EXPECT_EQ(diary.pop_all(), (Lines{"received 1", "offered 0", "offered 1", "offered 2", "refused 0 stale", "refused 2 stale"}))
        << "with probes ahead of it";
    EXPECT_EQ(forwarder.router().learned(fc, a.arrived_at).links, LinkSet{a.link}) << "it teaches nothing";
}

TEST_F(Forwarding, a_dropped_copy_renews_the_last_heard_time_of_its_source) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    add();
    Channel& radio = add_with(grouped);
    Channel& wifi = add_with(grouped);
    receive(radio, telemetry);
    receive(wifi, frame(fc, all, 0x04, {1}));
    now += 20s;
    receive(radio, frame(fc, all, 0x04, {2}));
    EXPECT_EQ(events(wifi, frame(fc, all, 0x04, {2})).back(), "dropped 2 duplicate");
    EXPECT_EQ(forwarder.router().heard_at(fc, wifi.id), now);
}

TEST_F(Forwarding, a_probe_of_another_gateway_is_forwarded_unchanged) {
    Channel& a = add();
    add_with([](ForwarderLink& link) {
        link.rules.limit = {{0xC0, 1}};
        link.present_as = 0x20;
    });
    add_with([](ForwarderLink& link) { link.allows_probes = false; });
    LoopGuard other{8};
    other.open(ChannelId{0}, LinkId{0}, 0, true, now);
    const auto view = other.ask(ChannelId{0}, now).bytes();
    const Bytes probe{view.begin(), view.end()};
    EXPECT_EQ(events(a, probe), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(diary.last, probe);
}

TEST_F(Forwarding, the_holder_of_an_address_is_queried_before_the_address_moves) {
    Channel& home = add();
    Channel& thief = add();
    receive(home, telemetry);
    now += 1s;
    taken(home);
    receive(thief, frame(fc, host, 0x03, {9}));
    const auto question = device_info_question(fc);
    EXPECT_EQ(taken(home).front(), (Bytes{question.begin(), question.end()}));
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{home.link});
    for (int asked = 0; asked < 3; ++asked) {
        ASSERT_TRUE(forwarder.due());
        now = *forwarder.due();
        forwarder.tick(now);
    }
    EXPECT_FALSE(forwarder.due());
    EXPECT_EQ(home.sent().offered, 3u) << "and no telemetry for hosts";
    receive(thief, frame(fc, host, 0x03, {10}));
    EXPECT_EQ(forwarder.router().learned(fc, now).links, LinkSet{thief.link}) << "three times silent";
    EXPECT_FALSE(forwarder.pop_conflict());
}

TEST_F(Forwarding, a_refused_claim_is_a_conflict_that_names_its_peer_even_after_the_channel_closes) {
    Channel& home = add();
    const LinkId udp = forwarder.add_link({});
    Channel& thief = *forwarder.open_channel(udp, "10.0.0.9:5", now);
    now += 1ms;
    receive(home, telemetry);
    now += 1s;
    receive(thief, frame(fc, host, 0x03, {9}));
    EXPECT_FALSE(forwarder.pop_conflict());
    now += 10ms;
    receive(home, frame(fc, host, 0xE3, {fc}));
    forwarder.close_channel(thief);
    const auto conflict = forwarder.pop_conflict();
    ASSERT_TRUE(conflict);
    EXPECT_EQ(conflict->address, fc);
    ASSERT_TRUE(forwarder.claimant(*conflict));
    EXPECT_EQ(forwarder.claimant(*conflict)->peer, "10.0.0.9:5");
    EXPECT_EQ(forwarder.claimant(*conflict)->link, udp);
    EXPECT_FALSE(forwarder.pop_conflict()) << "once";
}

TEST_F(Forwarding, requests_beyond_the_limit_wait_for_an_answer_or_a_timeout) {
    Channel& ground = add();
    Channel& device = add_with([](ForwarderLink& link) { link.limits_questions = true; });
    receive(device, telemetry);
    taken(ground);
    constexpr std::size_t questions = 20;
    for (std::uint8_t n = 0; n < questions; ++n) receive(ground, frame(host, fc, 0xE0, {2, n, 0}));
    const std::size_t left = taken(device).size();
    EXPECT_LT(left, questions);
    EXPECT_EQ(device.waiting(), questions - left);
    ASSERT_TRUE(forwarder.due());
    receive(device, frame(fc, host, 0xE1, {0, 0, 1}));
    EXPECT_EQ(forwarder.next_to_flush(), &ground);
    EXPECT_EQ(forwarder.next_to_flush(), &device) << "the answer made room for the next";
    EXPECT_EQ(taken(device).size(), 1u);
    now = *forwarder.due();
    forwarder.tick(now);
    EXPECT_FALSE(taken(device).empty()) << "what is not answered makes room as well";
    forwarder.stop_asking();
    EXPECT_FALSE(forwarder.due());
    EXPECT_EQ(device.waiting(), 0u);
}

TEST_F(Forwarding, sends_a_hello_where_nothing_is_received) {
    const auto speaks = [](ForwarderLink& link) { link.hello = 2s; };
    Channel& first = add_with(speaks);
    const TimePoint up = now - 1ms;
    ASSERT_EQ(forwarder.hello_due(), std::optional{up + Hello::first_silence});
    now += 100ms;
    Channel& second = add_with(speaks);
    EXPECT_EQ(forwarder.hello_due(), std::optional{up + Hello::first_silence}) << "the earliest of several";
    now = up + Hello::first_silence;
    forwarder.send_hellos(now);
    EXPECT_EQ(taken(first), (Frames{Bytes{hello_frame.begin(), hello_frame.end()}}));
    EXPECT_TRUE(taken(second).empty());
    receive(first, frame(fc, all, 0x03, {7}));
    now += 200ms;
    forwarder.send_hellos(now);
    EXPECT_GT(*forwarder.hello_due(), now);
    forwarder.link_down(first.link);
    forwarder.link_down(second.link);
    forwarder.send_hellos(now + 10s);
    EXPECT_FALSE(forwarder.hello_due());
    forwarder.link_up(first.link, now + 10s);
    EXPECT_TRUE(forwarder.hello_due()) << "up again";
    forwarder.stop_asking();
    EXPECT_FALSE(forwarder.hello_due()) << "at the end";
}

TEST_F(Forwarding, frames_of_the_gateway_teach_no_address_and_obey_the_rules) {
    Channel& device = add_with([](ForwarderLink& link) { link.rules.limit = {{0xE0, 1}}; });
    const auto question = device_info_question(fc);
    diary.pop_all();
    forwarder.send_own(device.id, ano::FrameView{question}, now);
    forwarder.send_own(device.id, ano::FrameView{question}, now);
    EXPECT_EQ(diary.pop_all(), (Lines{"said 0", "refused 0 limited"}));
    EXPECT_EQ(forwarder.router().learned(host, now).links, LinkSet{});
}

TEST_F(Forwarding, opens_at_most_64_channels) {
    const LinkId link = forwarder.add_link({});
    std::vector<Channel*> channels;
    for (std::size_t n = 0; n < max_channels; ++n) channels.push_back(forwarder.open_channel(link, "", now));
    EXPECT_EQ(index(channels.back()->id), max_channels - 1);
    EXPECT_EQ(forwarder.open_channel(link, "", now), nullptr);
    forwarder.close_channel(*channels[5]);
    EXPECT_EQ(index(forwarder.open_channel(link, "", now)->id), 5u);
}

TEST_F(Forwarding, observers_can_be_added_and_removed) {
    Channel& device = add();
    add();
    Diary second;
    forwarder.add_observer(second);
    receive(device, telemetry);
    EXPECT_EQ(second.pop_all(), diary.pop_all());
    forwarder.remove_observer(diary);
    receive(device, telemetry);
    EXPECT_EQ(second.pop_all().size(), 2u);
    EXPECT_TRUE(diary.pop_all().empty());
    forwarder.remove_observer(second);
    receive(device, telemetry);
    EXPECT_TRUE(second.pop_all().empty());
}

TEST_F(Forwarding, zero_bytes_are_sent_where_the_next_frame_will_be_sent) {
    const auto uart = [](ForwarderLink& link) {
        link.outbox.flush_bytes = 206;
        link.parser.line_rate = 11520;
    };
    Channel& with_fc = add_with(uart);
    Channel& other = add_with(uart);
    Channel& no_uart = add();
    Channel& refuses = add_with([&](ForwarderLink& link) {
        uart(link);
        link.rules.send = without(0xE0);
    });
    const LinkId from = forwarder.add_link({});
    const Bytes question = frame(host, fc, 0xE0, {0, 0, 0});
    receive(with_fc, telemetry);
    for (Channel* const channel : {&other, &no_uart, &refuses}) taken(*channel);    // otherwise it waits there
    EXPECT_EQ(forwarder.flush_parsers(from, ano::FrameView{question}, now).busy, ano::Duration{206s} / 11520);
    EXPECT_EQ(forwarder.flush_parsers(from, ano::FrameView{question}, now).later, 0s) << "they have not left";
    EXPECT_EQ(with_fc.outbox.zeros(), 206u);
    EXPECT_EQ(forwarder.next_to_flush(), &with_fc);
    EXPECT_EQ(other.outbox.zeros(), 0u);
    const Bytes unknown = frame(host, 0x77, 0xE0, {0, 0, 0});
    EXPECT_GT(forwarder.flush_parsers(from, ano::FrameView{unknown}, now).busy, 0s) << "it is flooded";
    EXPECT_EQ(other.outbox.zeros(), 206u);
    EXPECT_EQ(no_uart.outbox.zeros(), 0u);
    EXPECT_EQ(refuses.outbox.zeros(), 0u) << "the frame may not leave there";
}

TEST_F(Forwarding, frames_that_wait_for_a_link_in_exclusive_use_are_dropped) {
    Channel& device = add_with([](ForwarderLink& link) { link.limits_questions = true; });
    Channel& ground = add();
    receive(device, telemetry);
    taken(ground);
    for (std::uint8_t n = 0; n < 12; ++n) receive(ground, frame(host, fc, 0xE0, {2, n, 0}));
    receive(ground, frame(host, fc, 0xC0, {1, 2, 3}));
    EXPECT_EQ(device.waiting(), 13u);
    forwarder.set_exclusive(device.link, true);
    EXPECT_EQ(device.waiting(), 0u);
    EXPECT_EQ(device.sent().denied_out, 13u);
    receive(ground, frame(host, fc, 0xC0, {1, 2, 3}));
    forwarder.tick(now + 10s);
    EXPECT_TRUE(taken(device).empty());
    forwarder.set_exclusive(device.link, false);
    receive(ground, frame(host, fc, 0xC0, {1, 2, 3}));
    EXPECT_EQ(taken(device).size(), 1u);
}

TEST_F(Forwarding, zero_bytes_are_not_sent_where_a_command_to_an_unknown_device_is_not_allowed) {
    const auto uart = [](ForwarderLink& link) {
        link.outbox.flush_bytes = 206;
        link.parser.line_rate = 11520;
    };
    Channel& device = add_with(uart);
    Channel& other = add_with(uart);
    const LinkId from = forwarder.add_link({});
    receive(device, telemetry);
    receive(other, frame(0xDD, all, 0x03, {1, 2, 3}));
    for (Channel* const channel : {&device, &other}) taken(*channel);
    const Bytes unknown = frame(host, 0x77, 0xC0, {1, 2, 3});
    EXPECT_EQ(forwarder.flush_parsers(from, ano::FrameView{unknown}, now).busy, 0s);
    EXPECT_EQ(device.outbox.zeros() + other.outbox.zeros(), 0u);
}

TEST_F(Forwarding, a_device_that_has_answered_for_another_address_gets_no_more_commands_for_unknown_ones) {
    Channel& device = add();
    Channel& ground = add();
    receive(device, telemetry);
    const Bytes for_unknown = frame(host, 0x77, 0xC0, {1, 2, 3});
    receive(ground, for_unknown);
    EXPECT_EQ(taken(device).size(), 1u);
    receive(device, frame(fc, host, 0x00, {0xC0, for_unknown[for_unknown.size() - 2], for_unknown.back()}));
    receive(ground, frame(host, 0x77, 0xC0, {1, 2, 4}));
    EXPECT_TRUE(taken(device).empty());
    receive(ground, command);
    EXPECT_EQ(taken(device).size(), 1u) << "its own";
}

// The configured class of an id applies to its queues, its age and the guards against loops and duplicates, and can be changed.
TEST_F(Forwarding, a_frame_with_a_configured_class_is_sent_as_one_of_that_class) {
    Channel& host_link = add();
    Channel& device = add();
    receive(device, frame(fc, all, 0xE3, {1}));
    taken(host_link);
    const auto leaving = [&] {
        device.outbox.close();
        device.outbox.open();
        std::array<std::span<const std::uint8_t>, 1> none{};
        receive(host_link, frame(host, fc, 0xA0, {0}));
        device.outbox.gather(none, now, 0);
        device.outbox.set_congested();
        for (std::uint8_t n = 1; n <= 3; ++n) receive(host_link, frame(host, fc, 0xF5, {n}));
        return taken(device);
    };
    const Bytes text = frame(host, fc, 0xA0, {0});
    const auto setpoint = [](std::uint8_t n) { return frame(host, fc, 0xF5, {n}); };
    EXPECT_EQ(leaving(), (Frames{text, setpoint(1), setpoint(2), setpoint(3)}));
    forwarder.set_classes({{.id = 0xF5, .frame_class = FrameClass::control, .age = 150ms}});
    EXPECT_EQ(leaving(), (Frames{setpoint(3), text}));
    receive(host_link, setpoint(1));
    now += 149ms;
    EXPECT_EQ(device.outbox.next(now).size, 9u);
    now += 1ms;
    EXPECT_EQ(device.outbox.next(now).size, 0u) << "stale";
    forwarder.set_classes({});
    EXPECT_EQ(leaving(), (Frames{text, setpoint(1), setpoint(2), setpoint(3)}));
}

}    // namespace forwarder_tests
