#include <gateway/hints.hpp>
#include <link/kinds.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <string_view>

namespace anogate::hints_tests {
namespace {

LinkFigures line_that_sent(std::uint64_t frames) {
    LinkFigures link{};
    link.words = anogate::find_link_kind("serial")->hints;
    link.up = true;
    link.received.frames_in = link.received.bytes_in = 1000;
    link.sent.frames_out = frames;
    return link;
}

TEST(Hint, frames_received_stale_do_not_make_a_link_count_as_slow) {
    LinkFigures link = line_that_sent(100);
    link.sent.stale = link.came_stale = 50;
    EXPECT_EQ(hint(link), "");
    link.sent.stale += 11;
    EXPECT_EQ(hint(link), "frames are dropped: more is sent to this link than it can carry");
}

TEST(Hint, too_long_frames_among_valid_ones_are_reported) {
    LinkFigures link = line_that_sent(100);
    link.received.frames_in = 1000;
    link.received.bad_length = 4;
    EXPECT_EQ(hint(link), "");
    link.received.bad_length = 5;
    EXPECT_EQ(hint(link), "frames longer than max_data are refused: raise max_data on this link");
    link.received.bad_check = 1;
    EXPECT_EQ(hint(link), "") << "noise looks like long frames as well";
}

// Most of their bytes are skipped, as at a wrong baud rate.
TEST(Hint, only_images_above_max_data_are_no_wrong_baud_rate) {
    LinkFigures link = line_that_sent(0);
    link.received.frames_in = 0;
    link.received.skipped_bytes = 45'000;
    link.received.bad_length = 20;
    link.received.bad_check = 300;
    EXPECT_EQ(find_hint(link).id, "no_frames_at_baud");
    link.long_images = 2;
    EXPECT_EQ(find_hint(link).id, "above_max_data");
}

TEST(Hint, a_link_too_slow_for_its_traffic_is_reported_for_every_cause_of_drops) {
    for (const auto cause : {&SendCounters::superseded, &SendCounters::stale, &SendCounters::queue_full}) {
        LinkFigures link = line_that_sent(100);
        link.sent.*cause = 10;
        EXPECT_EQ(hint(link), "") << "one in ten is no news";
        link.sent.*cause = 11;
        EXPECT_EQ(hint(link), "frames are dropped: more is sent to this link than it can carry");
        link.sent.frames_out = 0;
        EXPECT_EQ(hint(link), "frames are dropped: more is sent to this link than it can carry");
    }
}

TEST(Hint, devices_that_act_for_others_or_have_no_address_are_reported) {
    LinkFigures link = line_that_sent(100);
    link.nobody = std::uint8_t{0};
    EXPECT_EQ(hint(link),
              "a device sends from 0x00, which is not a device address, and receives only broadcasts: set its id, or configure "
              "an `alias`");
    link.not_sent = std::uint8_t{0x44};
    EXPECT_EQ(find_hint(link).id, "unknown_device");
    EXPECT_EQ(find_hint(link).text, not_routed(0x44).text);
    link.not_sent = std::uint8_t{0xFF};
    EXPECT_EQ(find_hint(link).id, "no_broadcast");
    EXPECT_EQ(find_hint(link).text.find("--route"), std::string::npos) << "0xFF can't be routed";
    link.answers_for_others = std::uint8_t{1};
    EXPECT_EQ(hint(link), "device 0x01 acts on frames for other addresses: set profile=old on this link");
    EXPECT_EQ(find_hint(link).id, "answers_for_others");
}

TEST(Hint, a_line_that_echoes_is_reported) {
    LinkFigures link = line_that_sent(100);
    link.echoes = true;
    link.not_sent = std::uint8_t{0x44};
    EXPECT_EQ(find_hint(link).id, "echo");
}

TEST(Hint, frames_of_another_gateway_and_commands_on_a_v7_line_are_reported) {
    LinkFigures link = line_that_sent(100);
    link.v7_commands = true;
    EXPECT_EQ(find_hint(link).id, "v7_commands");
    link.echoes = true;
    EXPECT_EQ(find_hint(link).id, "echo");
    link.v7_loops = true;
    EXPECT_EQ(find_hint(link).id, "v7_loop");
    link.received.skipped_bytes = link.skipped_since = 1000;    // damage on that line
    link.bytes_ago = std::chrono::seconds{0};
    link.up_for = std::chrono::seconds{20};
    EXPECT_EQ(find_hint(link).id, "v7_loop");
}

TEST(Hint, for_contradictory_orientations_names_the_attitude_key) {
    LinkFigures link = line_that_sent(0);
    link.contradictory = 0xDD;
    EXPECT_EQ(hint(link), "Euler angles and quaternion of 0xDD contradict each other: try attitude=lx");
    EXPECT_EQ(find_hint(link).id, "attitude_contradiction");
    link.attitude = ano::EulerSigns::lx;
    EXPECT_EQ(hint(link), "Euler angles and quaternion of 0xDD contradict each other: try attitude=document");
}

TEST(Hint, corrupted_frames_and_v7_frames_are_reported_above_one_in_ten) {
    LinkFigures link = line_that_sent(100);
    link.received.bad_check = 60;
    link.received.expired = 40;
    link.v7_frames = 100;
    EXPECT_EQ(hint(link), "");
    ++link.received.expired;
    EXPECT_EQ(hint(link), "many corrupted frames: check cable, ground and baud rate");
    ++link.v7_frames;
    EXPECT_EQ(hint(link), "older V7 frames (0xAA) received: switch the device to protocol V8");
    EXPECT_EQ(find_hint(link).id, "v7_frames_only") << "a link of a kind without the key protocol";
}

TEST(Hint, about_corrupted_frames_ends_when_a_hundred_valid_ones_follow) {
    LinkFigures link = line_that_sent(100);
    link.received.bad_check = 1000;
    link.received.skipped_bytes = 20'000;
    link.v7_frames = 1000;
    link.frames_since_skipped = 99;
    EXPECT_EQ(find_hint(link).id, "v7_frames_only");
    link.frames_since_skipped = 100;
    EXPECT_EQ(hint(link), "");
    link.v7_frames = 0;
    link.frames_since_skipped = 0;
    EXPECT_EQ(find_hint(link).id, "many_damaged");
    link.frames_since_skipped = 100;
    EXPECT_EQ(hint(link), "");
}

TEST(Hint, for_v7_frames_proposes_the_keys_with_the_device_guessed_from_the_last_bytes) {
    LinkFigures link = line_that_sent(0);
    link.may_use_v7 = true;
    link.v7_frames = 200;
    const auto proposed = [&](const support::Bytes& skipped) {
        link.skipped = skipped;
        const Hint found = find_hint(link);
        EXPECT_EQ(found.id, "v7_frames");
        const std::string keys = std::get<std::string>(found.args.at(0).second);
        EXPECT_EQ(found.text,
                  "older V7 frames (0xAA) received: add " + keys + " to this link, or switch its sender to protocol V8");
        return keys;
    };
    using support::operator+;
    const support::Bytes attitude = support::v7_frame(0xAF, 0x03, {1, 0, 2, 0, 3, 0, 1}), incomplete{0xAA, 0xAF, 0x51};
    EXPECT_EQ(proposed({}), "protocol=v7,v7_device=ID");
    EXPECT_EQ(proposed(support::Bytes{7, 1, 2} + support::v7_frame(0xFF, 0x51, {0, 1, 0, 0, 9}) + incomplete),
              "protocol=v7,v7_device=0xDE");
    EXPECT_EQ(proposed(attitude + support::v7_frame(0xAF, 0xFA, {8, 0})), "protocol=v7,v7_device=0xDD,attitude=lx");
    EXPECT_EQ(proposed(support::v7_frame(0xFF, 0x51, {0, 1, 0, 0, 9}) + support::v7_frame(0xAF, 0x40, support::Bytes(20))),
              "protocol=v7,v7_device=0xDD,attitude=lx");
    EXPECT_EQ(proposed(attitude), "protocol=v7,v7_device=0xDD,attitude=lx");
    EXPECT_EQ(proposed(support::v7_frame(0xFF, 0xF2, {1})), "protocol=v7,v7_device=0x01");
    const support::Bytes request = support::v7_frame(0x60, 0xE1, {1, 0});
    EXPECT_EQ(proposed(request), "protocol=v7,v7_role=host,v7_device=ID");
    EXPECT_EQ(proposed(attitude + request), "protocol=v7,v7_device=0xDD,attitude=lx");
}

TEST(Hint, frames_dropped_by_filters_and_limits_are_not_reported) {
    LinkFigures link = line_that_sent(1);
    link.sent.limited = link.sent.denied_out = 1000;
    EXPECT_EQ(hint(link), "");
}

TEST(Hint, a_source_on_two_links_is_reported_as_one_device_or_two) {
    LinkFigures link = line_that_sent(1000);
    link.received.bad_check = 500;
    link.shared = SharedSource::one_device;
    EXPECT_EQ(
        hint(link),
        "the same frames arrive on two links: if it is one device, put both links in one `group`; if two, change the id of one")
        << "it matters more than damage";
    link.shared = SharedSource::two_peers;
    EXPECT_EQ(hint(link),
              "two peers send as the same device: see `conflicts` in the status; if these are two devices, change the id of one");
    link.shared = SharedSource::two_devices;
    EXPECT_EQ(hint(link), "different frames with one id arrive on two links: if these are two devices, change the id of one");
    link.shared = SharedSource::claims_pinned;
    EXPECT_EQ(hint(link),
              "frames from a pinned address arrive on another link: its route does not change; if it is one device, put both "
              "links in one `group`; if two, change the id of the other one");
}

// The hints at the links of one conflict, which share its meaning and ring, whatever other state each link has.
TEST(Hint, two_hints_for_one_conflict_never_contradict_each_other) {
    const std::string meanings[] = {"ring",
                                    "one_device_on_two_links",
                                    "two_devices_one_id",
                                    "two_peers_one_device",
                                    "pinned_address_claimed",
                                    "untrusted_peer_of_group"};
    const auto is_meaning = [&](std::string_view id) {
        return std::find(std::begin(meanings), std::end(meanings), id) != std::end(meanings);
    };
    const auto others = {0, 1, 2, 3, 4, 5, 6};
    const auto figures = [](SharedSource shared, bool ring, int other) {
        LinkFigures link = line_that_sent(1000);
        link.shared = shared;
        link.shared_address = 0xDC;
        if (ring) link.ring_out = "ground", link.ring_back = "radio";
        if (other == 1) link.answers_for_others = std::uint8_t{0xDD};
        if (other == 2) link.not_sent = std::uint8_t{0x44};
        if (other == 3) link.nobody = std::uint8_t{0};
        if (other == 4) link.hidden = 5;
        if (other == 5) link.contradictory = 0xDC;
        if (other == 6) link.undelivered_for = std::chrono::seconds{9};
        return link;
    };
    for (const SharedSource shared : {SharedSource::one_device, SharedSource::two_devices, SharedSource::two_peers,
                                      SharedSource::claims_pinned, SharedSource::of_a_group})
        for (const bool ring : {false, true})
            for (const int one : others)
                for (const int other : others) {
                    const Hint a = find_hint(figures(shared, ring, one)), b = find_hint(figures(shared, ring, other));
                    EXPECT_TRUE(is_meaning(a.id)) << a.id << ": nothing else is said while there is a conflict";
                    EXPECT_EQ(a.text, b.text);
                }
}

TEST(Hint, of_a_source_on_two_links_names_its_address) {
    LinkFigures link = line_that_sent(1000);
    link.shared = SharedSource::two_devices;
    link.shared_address = 0xDC;
    EXPECT_EQ(hint(link),
              "different frames with one id arrive on two links: if these are two devices, change the id of one (0xDC)");
    EXPECT_EQ(find_hint(link).args.at(0), (std::pair<std::string_view, Hint::Value>{"device", std::string{"0xDC"}}));
}

TEST(Hint, names_a_device_whose_address_is_also_a_port_id) {
    LinkFigures link = line_that_sent(1000);
    link.hidden = 5;
    EXPECT_EQ(hint(link), "device 0x05 can't be reached: its address is also the port id of a link; change one of them");
}

TEST(Hint, telemetry_without_a_receiver_is_reported_after_3_seconds) {
    LinkFigures link = line_that_sent(1000);
    link.undelivered_for = std::chrono::milliseconds{2999};
    EXPECT_EQ(hint(link), "");
    link.undelivered_for = std::chrono::seconds{3};
    EXPECT_EQ(hint(link),
              "no ground station is registered for this telemetry yet (anoctl and the page see it anyway); have it send a frame, "
              "or add --route 0xFE=LINK");
}

TEST(Hint, names_the_link_that_is_down_where_hosts_were_last_seen) {
    LinkFigures link = line_that_sent(1000);
    link.hosts_link = "radio";
    EXPECT_EQ(hint(link), "") << "it has a taker";
    link.undelivered_for = std::chrono::seconds{3};
    const Hint found = find_hint(link);
    EXPECT_EQ(found.text, "ground stations were last seen on radio, which is down: restore that link, or add --route 0xFE=LINK");
    EXPECT_EQ(found.id, "hosts_link_down");
    ASSERT_EQ(found.args.size(), 1u);
    EXPECT_EQ(found.args[0], (std::pair<std::string_view, Hint::Value>{"link", "radio"}));
}

TEST(Hint, a_loop_is_reported_with_its_links) {
    LinkFigures link = line_that_sent(100);
    link.ring_out = "ground";
    link.ring_back = "radio";
    EXPECT_EQ(hint(link), "loop: frames sent to ground come back from radio");
    link.ring_out = "radio";
    EXPECT_EQ(hint(link), "loop: frames sent to radio come back");
    link.up = false;
    EXPECT_EQ(hint(link), "");
}

TEST(Hint, a_recording_at_its_end_is_reported_as_ended_and_not_as_silent) {
    LinkFigures link = line_that_sent(100);
    link.silent_for = std::chrono::seconds{12};
    link.is_over = true;
    EXPECT_EQ(find_hint(link).id, "recording_ended");
    EXPECT_EQ(hint_of_trouble(link), "the recording has ended") << "it is written to the log";
    link.no_place = 1;
    EXPECT_EQ(find_hint(link).id, "no_place");
    link.handshakes = 1;
    EXPECT_EQ(find_hint(link).id, "handshakes") << "which leaves no place to anybody";
}

TEST(Hint, a_silent_link_that_sends_nothing_gets_the_advice_to_use_hello) {
    using namespace std::chrono_literals;
    const std::string advice = " (some devices send only after they receive a frame: try hello=on)";
    const auto ends_with_it = [&](const LinkFigures& link) { return hint(link).ends_with(advice); };
    for (const char* kind : {"serial", "udp", "can"}) {
        LinkFigures link{};
        link.words = anogate::find_link_kind(kind)->hints;
        link.up = true;
        link.up_for = 3s;
        EXPECT_FALSE(ends_with_it(link)) << "it says hello";
        link.could_send_hello = true;
        EXPECT_TRUE(ends_with_it(link)) << hint(link);
        EXPECT_EQ(hint(link), hint_of_trouble(link));
        link.for_hosts = true;
        EXPECT_EQ(hint(link), "") << "who watches does not speak";
        link.for_hosts = false;
        link.received.frames_in = link.received.bytes_in = 1000;
        EXPECT_EQ(hint(link), "");
        link.silent_for = 12s;
        EXPECT_EQ(hint(link), "silent for 12 s") << "it spoke by itself";
        link.for_hosts = true;
        EXPECT_EQ(hint(link), "") << "a host may only listen";
        link.for_hosts = false;
        link.received.frames_in = 19;
        EXPECT_EQ(hint(link), "silent for 12 s" + advice);
    }
    LinkFigures program{};
    program.words = anogate::find_link_kind("pty")->hints;
    program.up = program.could_send_hello = true;
    program.silent_for = 12s;
    EXPECT_EQ(hint(program), "silent for 12 s") << "no device";
}

TEST(Hint, bytes_without_frames_after_valid_frames_are_not_reported_as_silence) {
    using namespace std::chrono_literals;
    LinkFigures link = line_that_sent(1000);
    link.could_send_hello = true;
    link.silent_for = 12s;
    link.bytes_ago = 20ms;
    link.skipped_since = 64;
    EXPECT_EQ(hint(link), "data but no valid frames for 12 s: check baud rate and firmware");
    EXPECT_EQ(hint_of_trouble(link), "data but no valid frames any more: check baud rate and firmware")
        << "told once, so without the time";
    link.words = anogate::find_link_kind("udp")->hints;
    EXPECT_EQ(hint(link), "data but no valid frames for 12 s: does the sender still use ANO V8?");
    link.silent_for = 2s;
    EXPECT_EQ(hint(link), "") << "a noisy moment";
    link.silent_for.reset();
    link.up_for = 12s;
    EXPECT_EQ(hint(link), "data but no valid frames for 12 s: does the sender still use ANO V8?")
        << "there were some before it was plugged again";
}

TEST(Hint, a_few_bytes_or_old_bytes_do_not_end_a_silence) {
    using namespace std::chrono_literals;
    LinkFigures link = line_that_sent(1000);
    link.silent_for = 12s;
    link.bytes_ago = 20ms;
    link.skipped_since = 63;
    EXPECT_EQ(hint(link), "silent for 12 s") << "noise of the line";
    link.skipped_since = 2000;
    link.bytes_ago = 11s;
    EXPECT_EQ(hint(link), "silent for 12 s") << "what it wrote when it started again, before its end";
    link.bytes_ago.reset();
    EXPECT_EQ(hint(link), "silent for 12 s");
}

TEST(Hint, unknown_senders_and_listening_gateways_are_reported) {
    LinkFigures link = line_that_sent(1000);
    link.words = anogate::find_link_kind("udp-listen")->hints;
    link.listens = true;
    link.channels = 1;
    link.sent.held_back = 1;
    EXPECT_NE(hint(link).find("`trusted`"), std::string::npos);
    link.no_place = 1;
    EXPECT_NE(hint(link).find("max_per_address"), std::string::npos);
    link.gateways = 1;
    EXPECT_NE(hint(link).find("a udp: link"), std::string::npos) << "the one that tells most";
}

TEST(Hint, connected_clients_that_have_sent_no_frame_are_counted) {
    LinkFigures link;
    link.up = link.listens = link.has_connections = true;
    link.up_for = std::chrono::seconds{3};
    EXPECT_EQ(hint(link), "no peer is connected");
    link.without_frame = 1;
    EXPECT_EQ(hint(link), "connected clients that have not sent a complete valid frame yet: 1");
    link.without_frame = 2;
    EXPECT_EQ(hint(link), "connected clients that have not sent a complete valid frame yet: 2");
    EXPECT_EQ(find_hint(link).id, "clients_without_frame");
    link.channels = 1;
    EXPECT_EQ(hint(link), "");
}

TEST(Hint, refused_senders_are_reported_as_outside_allow_only_if_that_was_the_cause) {
    LinkFigures link;
    link.up = link.listens = true;
    link.received.denied_in = 3;
    EXPECT_EQ(hint(link).find("`allow`"), std::string::npos) << hint(link);
    link.outsiders = 1;
    EXPECT_EQ(find_hint(link).id, "senders_denied");
    link.no_memory = 2;
    EXPECT_EQ(find_hint(link).id, "no_memory");
    link.channels = 1;
    EXPECT_EQ(find_hint(link).id, "no_memory") << "a second sender was refused";
}

TEST(Hint, has_an_id_and_the_values_in_its_text) {
    using namespace std::chrono_literals;
    EXPECT_EQ(find_hint(line_that_sent(1000)).id, "") << "nothing to say";
    LinkFigures link = line_that_sent(1000);
    link.could_send_hello = true;
    link.silent_for = 12s;
    link.received.frames_in = 19;
    const Hint silent = find_hint(link);
    EXPECT_EQ(silent.id, "silent");
    ASSERT_EQ(silent.args.size(), 2u);
    EXPECT_EQ(silent.args[0], (std::pair<std::string_view, Hint::Value>{"seconds", std::int64_t{12}}));
    EXPECT_EQ(silent.args[1], (std::pair<std::string_view, Hint::Value>{"try_hello", true}));
    link.ring_out = "ground";
    link.ring_back = "radio";
    const Hint ring = find_hint(link);
    EXPECT_EQ(ring.id, "ring");
    ASSERT_EQ(ring.args.size(), 2u);
    EXPECT_EQ(ring.args[0], (std::pair<std::string_view, Hint::Value>{"out", std::string{"ground"}}));
    EXPECT_EQ(ring.args[1], (std::pair<std::string_view, Hint::Value>{"back", std::string{"radio"}}));
}

TEST(Hint, ids_match_the_texts_of_each_link_kind) {
    using namespace std::chrono_literals;
    const auto ids = [](const char* kind) {
        LinkFigures link = line_that_sent(1000);
        link.words = anogate::find_link_kind(kind)->hints;
        link.silent_for = 12s;
        link.bytes_ago = 20ms;
        link.skipped_since = 64;
        std::string all{find_hint(link).id};
        link.received.frames_in = 0;
        link.received.skipped_bytes = 64;
        all.append(" ").append(find_hint(link).id);
        link.received = {};
        link.silent_for.reset();
        link.up_for = 3s;
        return all.append(" ").append(find_hint(link).id);
    };
    EXPECT_EQ(ids("serial"), "no_frames_at_baud_any_more no_frames_at_baud nothing_on_line");
    EXPECT_EQ(ids("udp"), "no_frames_any_more no_frames nothing_from_peer");
    EXPECT_EQ(ids("can"), "no_frames_any_more no_frames nothing_on_bus");
    EXPECT_EQ(ids("pty"), "no_frames_any_more no_frames ");
}

}    // namespace
}    // namespace anogate::hints_tests
