#include <gateway/alias.hpp>
#include <gateway/present_as.hpp>
#include <gateway/queue_policy.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace present_as_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

namespace {

constexpr std::uint8_t fc = 0xDC, host = 0xFE, ros = 0xD2, user = 100;

struct Presented : testing::Test {
    PresentAs hosts{host, 200};
    ano::TimePoint now{1h};
    std::uint64_t number = 0;

    Bytes in(const Bytes& bytes) { return whole(hosts.inbound(ano::FrameView{bytes}, now)); }
    Bytes out(const Bytes& bytes) { return whole(hosts.outbound(ano::FrameView{bytes}, ++number, now)); }
    static Bytes whole(ano::FrameView view) {
        EXPECT_TRUE(ano::frame_at(view.bytes())) << "both checks hold";
        return {view.bytes().begin(), view.bytes().end()};
    }
    static Bytes acknowledgement(const Bytes& request, std::uint8_t from, std::uint8_t to) {
        const std::size_t n = request.size();
        return frame(from, to, 0x00, {request[3], request[n - 2], request[n - 1]});
    }
    /// The address that receives `answer`, which a device sends to the host.
    std::uint8_t asker(std::uint8_t id, const Bytes& data, std::uint8_t device = fc) {
        return in(frame(device, host, id, data))[2];
    }
};

TEST_F(Presented, frames_of_any_host_are_sent_with_the_one_presented_address) {
    for (const std::uint8_t from : {ros, user, host})
        for (const std::uint8_t id : Bytes{0x40, 0x41, 0x60, 0x61, 0xC0, 0xC1, 0xE0, 0xE1, 0xF0})
            EXPECT_EQ(out(frame(from, fc, id, {1, 2, 3})), frame(host, fc, id, {1, 2, 3})) << int{from} << " " << int{id};
    EXPECT_EQ(out(frame(ros, 0xFF, 0xF1, {1})), frame(host, 0xFF, 0xF1, {1})) << "whatever a host address says";
}

TEST_F(Presented, frames_of_devices_keep_their_address) {
    EXPECT_EQ(out(frame(0xDE, 0xFF, 0x51, {1})), frame(0xDE, 0xFF, 0x51, {1})) << "a measurement";
    EXPECT_EQ(out(frame(0xDD, host, 0xE1, {1, 0, 5})), frame(0xDD, host, 0xE1, {1, 0, 5}))
        << "another device's answer to the host";
    EXPECT_EQ(out(frame(0xDD, ros, 0xE1, {1, 0, 5})), frame(0xDD, ros, 0xE1, {1, 0, 5}));
    in(frame(fc, host, 0x03));
    EXPECT_EQ(out(frame(fc, user, 0xE1, {1, 0, 5})), frame(fc, user, 0xE1, {1, 0, 5}))
        << "a device of the link to a host of the link";
}

TEST_F(Presented, an_answer_is_sent_to_the_requester) {
    struct Row {
        std::uint8_t asked;
        Bytes question;
        std::uint8_t answered;
        Bytes answer;
    };
    const Row rows[] = {
        {0xE0, {0, 0, 0}, 0xE3, {fc, 100, 0}},
        {0xE0, {1, 0, 0}, 0xE0, {1, 40, 0}},
        {0xE0, {2, 5, 1}, 0xE1, {5, 1, 7, 7}},
        {0xE0, {3, 5, 1}, 0xE2, {5, 1, 8, 'a'}},
        {0xC1, {0, 0, 0}, 0xC1, {0, 9, 0}},
        {0xC1, {1, 7, 1}, 0xC2, {7, 1, 0x10, 0, 1}},
        {0x60, {0xFF}, 0x60, {12}},
        {0x60, {3}, 0x61, {3, 1, 2, 3}},
        {0xF0, {0x01, 9, 9}, 0xF0, {0x00, 2, 1}},
    };
    for (const Row& row : rows) {
        for (const std::uint8_t to : {fc, std::uint8_t{0xFF}}) {
            SCOPED_TRACE(testing::Message() << "id " << int{row.asked} << " to " << int{to});
            out(frame(ros, to, row.asked, row.question));
            EXPECT_EQ(in(frame(fc, host, row.answered, row.answer)), frame(fc, ros, row.answered, row.answer));
            if (row.asked == 0xF0) continue;
            EXPECT_EQ(asker(row.answered, row.answer), host) << "nobody asked for a second one";
        }
    }
}

TEST_F(Presented, an_acknowledgement_carries_the_checksum_that_the_requester_sent) {
    const Bytes requests[] = {frame(user, fc, 0xC0, {1, 2, 3}), frame(user, fc, 0xE1, {3, 0, 42}),
                              frame(user, fc, 0xE0, {0x10, 0xAB, 0}), frame(user, 0xFF, 0xC0, {1, 2, 3}),
                              frame(user, fc, 0x61, Bytes(22))};
    for (const Bytes& sent : requests) {
        const Bytes reached = out(sent);
        EXPECT_EQ(in(acknowledgement(reached, fc, host)), acknowledgement(sent, fc, user));
        EXPECT_EQ(in(acknowledgement(reached, fc, host)), acknowledgement(sent, fc, user)) << "a device may answer twice";
    }
}

TEST_F(Presented, unsolicited_answers_are_sent_to_the_host) {
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {6, 0, 1}), host) << "another parameter";
    EXPECT_EQ(asker(0xE1, {5, 0, 1}, 0xDD), host) << "another device";
    EXPECT_EQ(asker(0x03, {5, 0, 1}), host);
    EXPECT_EQ(asker(0x00, {0xC0, 1, 1}), host) << "of a frame that was not sent";
    EXPECT_EQ(asker(0xF0, {0, 1, 1}), host);
    EXPECT_EQ(in(frame(fc, 0xFF, 0x51, {1})), frame(fc, 0xFF, 0x51, {1}));
    EXPECT_EQ(in(frame(fc, user, 0xE1, {5, 0, 1})), frame(fc, user, 0xE1, {5, 0, 1})) << "a device may answer others as well";
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros) << "and the one asked for is still to come";
}

TEST_F(Presented, several_equal_requests_are_answered_in_turn) {
    for (const std::uint8_t from : {user, host, ros}) out(frame(from, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), user);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host) << "all have theirs";
}

TEST_F(Presented, a_repeating_requester_does_not_keep_others_from_their_answer) {
    for (int n = 0; n < 5; ++n) out(frame(user, fc, 0xE0, {2, 5, 0}));
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), user);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros) << "the device heard one of the five";
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), user) << "or several";
}

TEST_F(Presented, acknowledgements_of_equal_commands_are_assigned_to_each_sender) {
    const Bytes mine = frame(user, fc, 0xC0, {1, 2, 3}), theirs = frame(ros, fc, 0xC0, {1, 2, 3});
    const Bytes reached = out(mine);
    EXPECT_EQ(out(theirs), reached);
    EXPECT_EQ(in(acknowledgement(reached, fc, host)), acknowledgement(mine, fc, user));
    EXPECT_EQ(in(acknowledgement(reached, fc, host)), acknowledgement(theirs, fc, ros));
}

TEST_F(Presented, a_broadcast_request_is_answered_by_each_device) {
    out(frame(user, 0xFF, 0xE0, {0, 0, 0}));
    out(frame(ros, 0xFF, 0xE0, {0, 0, 0}));
    for (const std::uint8_t device : {fc, std::uint8_t{0xDD}}) {
        EXPECT_EQ(asker(0xE3, {device}, device), user);
        EXPECT_EQ(asker(0xE3, {device}, device), ros);
        EXPECT_EQ(asker(0xE3, {device}, device), host) << "it says so itself";
    }
}

TEST_F(Presented, a_broadcast_answer_counts_as_the_answer) {
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(in(frame(fc, 0xFF, 0xE1, {5, 0, 1})), frame(fc, 0xFF, 0xE1, {5, 0, 1}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host);
}

TEST_F(Presented, a_request_to_a_port_is_answered_by_the_device_behind_it) {
    hosts.add_port(3);
    out(frame(ros, 3, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
    out(frame(ros, 4, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host) << "4 is a device";
}

TEST_F(Presented, a_frame_to_several_channels_is_one_request) {
    const Bytes question = frame(ros, fc, 0xE0, {2, 5, 0});
    ++number;
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_EQ(whole(hosts.outbound(ano::FrameView{question}, number, now)), frame(host, fc, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host);
}

TEST_F(Presented, memory_expires) {
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    const Bytes reached = out(frame(ros, fc, 0xC0, {1, 2, 3}));
    now += PresentAs::memory - 1ms;
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    now += PresentAs::memory;
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), host);
    EXPECT_EQ(in(acknowledgement(reached, fc, host)), acknowledgement(reached, fc, host));
}

TEST_F(Presented, memory_is_bounded_and_drops_the_oldest_request) {
    out(frame(ros, fc, 0xE0, {2, 0, 0}));
    out(frame(ros, fc, 0xE0, {2, 1, 0}));
    for (int n = 0; n < 255; ++n) out(frame(user, fc, 0xE0, {3, 0, 0}));
    EXPECT_EQ(asker(0xE1, {0, 0, 1}), host);
    EXPECT_EQ(asker(0xE1, {1, 0, 1}), ros);
}

TEST_F(Presented, answers_keep_the_order_of_the_requests_when_the_memory_is_full) {
    out(frame(ros, fc, 0xE0, {3, 0, 0}));
    out(frame(user, fc, 0xE0, {2, 5, 0}));
    for (int n = 0; n < 254; ++n) out(frame(user, fc, 0xE0, {3, 0, 0}));
    out(frame(ros, fc, 0xE0, {2, 5, 0}));    // replaces the first
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), user);
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
}

TEST_F(Presented, streams_displace_nothing_in_the_memory) {
    out(frame(ros, fc, 0xE0, {2, 5, 0}));
    for (int n = 0; n < 2000; ++n)
        out(frame(ros, fc, n % 2 ? 0x41 : 0xF1, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), ros);
}

TEST_F(Presented, all_answers_of_a_firmware_update_reach_the_requester) {
    out(frame(user, fc, 0xF0, {1, 9, 9}));
    EXPECT_EQ(asker(0xF0, {0, 0x02, 0x01}), user);
    now += 30s;
    EXPECT_EQ(asker(0xF0, {0, 0x12, 0x01}), user) << "erased";
    now += PresentAs::session - 30s - 1ms;
    EXPECT_EQ(asker(0xF0, {0, 0x12, 0x01}), user);
    now += 1ms;
    EXPECT_EQ(asker(0xF0, {0, 0x12, 0x01}), host);
}

TEST_F(Presented, short_and_large_frames_pass) {
    EXPECT_EQ(in(frame(fc, host, 0x00, {0xE1, 1})), frame(fc, host, 0x00, {0xE1, 1}));
    for (const std::uint8_t id : Bytes{0x60, 0x61, 0xC1, 0xC2, 0xE0, 0xE1, 0xE2, 0xE3, 0xF0}) {
        EXPECT_EQ(out(frame(ros, fc, id)), frame(host, fc, id));
        in(frame(fc, host, id));
    }
    EXPECT_EQ(out(frame(ros, fc, 0xE1, Bytes(200))), frame(host, fc, 0xE1, Bytes(200)));
    EXPECT_EQ(out(frame(ros, fc, 0xE1, Bytes(201))), frame(ros, fc, 0xE1, Bytes(201)));
}

// Outbound frames pass the host mapping, then the alias; inbound frames the alias, then the host mapping.
TEST_F(Presented, an_acknowledgement_also_returns_through_an_alias) {
    Aliases aliases{{{.device = 0xDE, .as = 31}}, 200};
    const Bytes sent = frame(ros, 31, 0xE1, {3, 0, 42});
    const Bytes presented = out(sent);
    const Bytes reached = whole(*aliases.outbound(ano::FrameView{presented}, now));
    EXPECT_EQ(reached, frame(host, 0xDE, 0xE1, {3, 0, 42}));
    const Bytes answer = whole(aliases.inbound(ano::FrameView{acknowledgement(reached, 0xDE, host)}, now));
    EXPECT_EQ(in(answer), acknowledgement(sent, 31, ros));
}

TEST_F(Presented, room_grows_for_a_link_with_larger_frames) {
    const Bytes largest = frame(user, fc, 0xC0, Bytes(300, 1));
    EXPECT_EQ(out(largest), largest) << "for the outbox to refuse";
    hosts.make_room(300);
    EXPECT_EQ(out(largest), frame(host, fc, 0xC0, Bytes(300, 1)));
    EXPECT_EQ(out(frame(user, fc, 0xC0, Bytes(301, 1)))[1], user);
    hosts.make_room(10);
    EXPECT_EQ(out(largest)[1], host) << "never less";
}

TEST_F(Presented, requests_to_a_removed_port_are_not_matched_with_answers) {
    constexpr std::uint8_t port = 3;
    hosts.add_port(port);
    out(frame(user, port, 0xE0, {2, 5, 0}));
    EXPECT_EQ(asker(0xE1, {5, 0, 1}), user);
    hosts.remove_port(port);
    out(frame(user, port, 0xE0, {2, 6, 0}));
    EXPECT_EQ(asker(0xE1, {6, 0, 1}), host);
}

}    // namespace
}    // namespace present_as_tests
