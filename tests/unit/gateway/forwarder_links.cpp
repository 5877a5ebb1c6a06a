// Links that are removed while the Forwarder runs: their state must not pass to a link that reuses the number.
#include "forwarding.hpp"

namespace forwarder_links_tests {

using namespace forwarding;

namespace {

class Removed : public Forwarding {
protected:
    LinkId remove(Channel& channel) {
        const LinkId link = channel.link;
        forwarder.remove_link(link);
        return link;
    }
};

TEST_F(Removed, a_link_leaves_no_route_no_pin_and_no_counter) {
    Channel& ground = add();
    Channel& device = add_with([](ForwarderLink& link) {
        link.route.port_id = 7;
        link.aliases = {{0xDE, 31}};
    });
    add();
    forwarder.pin(40, 41, device.link);
    receive(device, telemetry);
    EXPECT_EQ(events(ground, frame(host, 7, 0xC0, {1})), (Lines{"received 0", "offered 1"}));
    const ChannelId number = device.id;
    const LinkId gone = remove(device);
    EXPECT_FALSE(forwarder.channels().contains(number));
    for (const std::uint8_t to : {fc, std::uint8_t{7}, std::uint8_t{31}, std::uint8_t{40}, std::uint8_t{41}})
        EXPECT_EQ(events(ground, frame(host, to, 0xC0, {to})), (Lines{"received 0", "offered 2"})) << "unknown: " << int{to};
    Channel& next = add();
    EXPECT_EQ(next.link, gone);
    EXPECT_EQ(next.id, number);
    EXPECT_EQ(forwarder.traffic(gone).gone_sent.offered + forwarder.traffic(gone).gone_received.frames_in, 0u);
    EXPECT_EQ(next.sent().offered, 0u);
    EXPECT_EQ(forwarder.router().pinned(31) | forwarder.router().pinned(40) | forwarder.router().port(7), LinkSet{});
    EXPECT_EQ(events(ground, frame(host, fc, 0xC0, {9})), (Lines{"received 0", "offered 1", "offered 2"}));
}

TEST_F(Removed, a_link_leaves_no_rules_to_the_next) {
    Channel& device = add();
    Channel& ruled = add_with([](ForwarderLink& link) {
        link.rules.send = without(0x03);
        link.present_as = 0x20;
        link.hello = 2s;
        link.aliases = {{0xDE, 31}};
        link.limits_questions = true;
    });
    LinkSet links{ruled.link};
    forwarder.inhibit().add(links);
    remove(ruled);
    Channel& plain = add();
    EXPECT_EQ(events(device, telemetry), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(taken(plain), Frames{telemetry});
    EXPECT_EQ(events(plain, command), (Lines{"received 1", "offered 0"})) << "no switch";
    EXPECT_FALSE(plain.questions);
    forwarder.send_hellos(now + 1h);
    EXPECT_FALSE(forwarder.hello_due());
    receive(device, frame(host, 31, 0xC0, {1}));
    EXPECT_EQ(taken(plain), Frames{frame(host, 31, 0xC0, {1})});
}

TEST_F(Removed, a_link_for_unknown_addresses_no_longer_receives_their_frames) {
    GatewaySettings settings;
    settings.unknown = Unknown::link;
    Forwarder to_one{settings, 8};
    const LinkId ground = to_one.add_link({}), way = to_one.add_link({});
    to_one.set_unknown_link(way);
    Channel& from = *to_one.open_channel(ground, "", now);
    const auto receive_command = [&] { to_one.receive(from, ano::FrameView{command}, now); };
    receive_command();
    EXPECT_EQ(to_one.traffic(way).gone_sent.link_down, 1u);
    to_one.remove_link(way);
    const LinkId next = to_one.add_link({});
    EXPECT_EQ(next, way);
    receive_command();
    EXPECT_EQ(to_one.traffic(next).gone_sent.link_down, 0u);
    EXPECT_EQ(from.routed.no_route, 1u);
}

TEST_F(Removed, the_next_link_may_send_frames_that_the_removed_one_sent_and_received) {
    Channel& device = add();
    Channel& ground = add();
    Channel& third = add();
    receive(device, telemetry);
    remove(device);
    Channel& again = add();
    EXPECT_EQ(events(again, telemetry), (Lines{"received 0", "offered 1", "offered 2"}));
    receive(ground, telemetry);
    EXPECT_EQ(third.sent().offered, 4u) << "with a probe: it went there";
    remove(again);
    EXPECT_EQ(events(add(), telemetry), (Lines{"received 0", "offered 1", "offered 2"}));
}

TEST_F(Removed, frames_of_a_link_are_duplicates_on_the_next_link_with_its_number_and_group) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    add();
    Channel& radio = add_with(grouped);
    add_with(grouped);
    receive(radio, telemetry);
    const LinkId gone = remove(radio);
    Channel& next = add_with(grouped);
    ASSERT_EQ(next.link, gone);
    EXPECT_EQ(events(next, telemetry), (Lines{"received 1", "dropped 1 duplicate"}));
}

TEST_F(Removed, its_port_id_becomes_an_ordinary_address_for_links_that_share_the_host_address) {
    const auto presented = [](std::uint8_t port) {
        return [=](ForwarderLink& link) {
            link.route.group = 1;
            link.route.port_id = port;
            link.present_as = host;
        };
    };
    constexpr std::uint8_t user = 0x55;
    const Bytes answer{5, 0, 1};
    Channel& ground = add();
    Channel& radio = add_with(presented(1));
    Channel& wifi = add_with(presented(2));
    const auto answered = [&](std::uint8_t asked) {
        receive(ground, frame(user, asked, 0xE0, {2, 5, 0}));
        taken(ground);
        receive(wifi, frame(fc, host, 0xE1, answer));
        return taken(ground);
    };
    EXPECT_EQ(answered(1), Frames{frame(fc, user, 0xE1, answer)}) << "a device behind the port";
    remove(radio);
    now += 10s;
    EXPECT_EQ(answered(1), Frames{frame(fc, host, 0xE1, answer)}) << "the other port is another";
    EXPECT_EQ(answered(2), Frames{frame(fc, user, 0xE1, answer)});
}

TEST_F(Removed, a_group_leaves_no_copies_and_no_links) {
    const auto grouped = [](ForwarderLink& link) { link.route.group = 1; };
    Channel& ground = add();
    Channel& radio = add_with(grouped);
    Channel& wifi = add_with(grouped);
    receive(radio, telemetry);
    remove(radio);
    EXPECT_EQ(events(wifi, telemetry), (Lines{"received 2", "dropped 2 duplicate"})) << "what it brought is known to its group";
    receive(wifi, command);
    remove(wifi);
    EXPECT_EQ(forwarder.router().group(1), LinkSet{});
    Channel& lora = add_with(grouped);
    Channel& mesh = add_with(grouped);
    taken(ground);
    EXPECT_EQ(events(lora, command), (Lines{"received 1", "offered 0"}));
    EXPECT_EQ(events(mesh, command), (Lines{"received 2", "dropped 2 duplicate"}));
}

TEST_F(Removed, a_link_of_a_group_leaves_the_address_of_hosts_to_the_others) {
    const auto presented = [](std::uint8_t port, std::size_t max_data) {
        return [=](ForwarderLink& link) {
            link.route.group = 1;
            link.route.port_id = port;
            link.present_as = host;
            link.parser.max_data = link.outbox.max_data = max_data;
        };
    };
    constexpr std::uint8_t user = 0x55;
    Channel& ground = add();
    Channel& radio = add_with(presented(1, 8));
    Channel& wifi = add_with(presented(2, 64));
    receive(wifi, telemetry);
    remove(radio);
    const Bytes largest(64, 2);
    taken(wifi);
    receive(ground, frame(user, fc, 0xC0, largest));
    EXPECT_EQ(taken(wifi), Frames{frame(host, fc, 0xC0, largest)});
    remove(wifi);
    Channel& plain = add_with([](ForwarderLink& link) { link.route.group = 1; });
    receive(ground, frame(user, fc, 0xC0, largest));
    EXPECT_EQ(taken(plain), Frames{frame(user, fc, 0xC0, largest)});
}

TEST_F(Removed, a_conflict_ends_with_one_of_its_two_links) {
    const auto cable = [](ForwarderLink& link) { link.allows_probes = false; };
    Channel& one = add_with(cable);
    Channel& two = add_with(cable);
    Channel& three = add_with(cable);
    const auto same_on = [&](Channel& other, std::uint8_t n) {
        receive(one, frame(fc, host, 0x03, {n}));
        now += 1ms;
        receive(other, frame(fc, host, 0x03, {n}));
        now += 600ms;
    };
    same_on(two, 1);
    ASSERT_TRUE(forwarder.pop_conflict());
    EXPECT_EQ(forwarder.router().conflicts(now).size(), 1u);
    remove(two);
    EXPECT_TRUE(forwarder.router().conflicts(now).empty());
    EXPECT_FALSE(forwarder.pop_conflict());
    for (std::uint8_t n = 2; n < 6; ++n) same_on(three, n);
    ASSERT_EQ(forwarder.router().conflicts(now).size(), 1u);
    EXPECT_TRUE(forwarder.router().conflicts(now)[0].links.contains(three.link));
    EXPECT_TRUE(forwarder.pop_conflict()) << "another one";
}

TEST_F(Removed, a_link_leaves_no_conflict_to_the_next) {
    const auto cable = [](ForwarderLink& link) { link.allows_probes = false; };
    Channel& one = add_with(cable);
    Channel& two = add_with(cable);
    add_with(cable);
    receive(one, telemetry);
    const LinkId gone = remove(one);
    EXPECT_EQ(add_with(cable).link, gone);
    receive(two, telemetry);
    EXPECT_FALSE(forwarder.pop_conflict()) << "the next has not said anything";
}

TEST_F(Removed, a_link_is_no_longer_a_claimant) {
    Channel& one = add();
    Channel& two = add();
    receive(one, frame(fc, all, 0x03, {1}));
    receive(two, frame(fc, all, 0x03, {2}));
    receive(one, frame(fc, all, 0x03, {3}));
    const auto conflicts = forwarder.router().conflicts(now);
    ASSERT_EQ(conflicts.size(), 1u);
    ASSERT_NE(forwarder.claimant(conflicts[0]), nullptr);
    EXPECT_EQ(forwarder.claimant(conflicts[0])->link, two.link);
    remove(two);
    EXPECT_EQ(forwarder.claimant(conflicts[0]), nullptr);
}

TEST_F(Removed, frames_received_by_a_closed_channel_stay_counted) {
    Channel& device = add();
    Channel& ground = add();
    close_loop(device, ground);
    receive(device, telemetry);
    ASSERT_EQ(events(ground, telemetry).at(1), "dropped 1 looped");
    const LinkId link = ground.link;
    forwarder.close_channel(ground);
    EXPECT_EQ(forwarder.traffic(link).gone_received.looped, 2u) << "and its probe";
}

TEST_F(Removed, a_channel_is_not_flushed) {
    Channel& device = add();
    Channel& ground = add();
    receive(device, telemetry);
    forwarder.close_channel(ground);
    EXPECT_EQ(forwarder.next_to_flush(), nullptr);
    EXPECT_EQ(forwarder.traffic(LinkId{1}).gone_sent.link_down, 1u);
    EXPECT_EQ(forwarder.traffic(LinkId{1}).gone_sent.offered, 1u);
}

// Settings that change while frames pass.

TEST_F(Removed, a_pinned_route_ends_while_its_link_stays) {
    Channel& ground = add();
    Channel& device = add_with([](ForwarderLink& link) { link.aliases = {{0xDE, 31}}; });
    add();
    forwarder.pin(30, 41, device.link);
    forwarder.unpin(30, 41, device.link);
    EXPECT_EQ(events(ground, frame(host, 40, 0xC0, {1})), (Lines{"received 0", "offered 1", "offered 2"}));
    EXPECT_EQ(events(ground, frame(host, 31, 0xC0, {1})), (Lines{"received 0", "offered 1"})) << "its alias stays";
}

TEST_F(Removed, changed_settings_of_the_gateway_apply_and_keep_learned_addresses) {
    Channel& ground = add();
    Channel& device = add();
    add();
    receive(device, telemetry);
    GatewaySettings settings;
    settings.id = 199;
    settings.unknown = Unknown::drop;
    forwarder.set(settings);
    EXPECT_EQ(events(ground, frame(host, fc, 0xC0, {1})), (Lines{"received 0", "offered 1"}));
    EXPECT_EQ(events(ground, frame(host, 199, 0xC0, {1})), (Lines{"received 0"})) << "ends here";
    EXPECT_EQ(forwarder.router().own_frames(), 1u);
    EXPECT_EQ(events(ground, frame(host, 77, 0xC0, {1})), (Lines{"received 0", "dropped 0 no_route"}));
    settings.unknown = Unknown::link;
    forwarder.set(settings);
    EXPECT_EQ(events(ground, frame(host, 77, 0xC0, {2})), (Lines{"received 0", "dropped 0 no_route"})) << "no link was named yet";
    forwarder.set_unknown_link(device.link);
    EXPECT_EQ(events(ground, frame(host, 77, 0xC0, {3})), (Lines{"received 0", "offered 1"}));
    settings.id = 0;
    settings.forget_after = 1s;
    forwarder.set(settings);
    now += 2s;
    EXPECT_TRUE(forwarder.router().learned(fc, now).links.empty());
}

}    // namespace
}    // namespace forwarder_links_tests
