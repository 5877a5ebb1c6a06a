#include <gateway/alias.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace alias_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

namespace {

struct Alias : testing::Test {
    Aliases aliases{{{.device = 0xDE, .as = 31}}, 200};
    ano::TimePoint now{1h};

    Bytes in(const Bytes& bytes) { return whole(aliases.inbound(ano::FrameView{bytes}, now)); }
    Bytes out(const Bytes& bytes) {
        const auto result = aliases.outbound(ano::FrameView{bytes}, now);
        return result ? whole(*result) : Bytes{};
    }
    static Bytes whole(ano::FrameView view) {
        EXPECT_TRUE(ano::frame_at(view.bytes())) << "both checks hold";
        return {view.bytes().begin(), view.bytes().end()};
    }
    // The acknowledgement of `request` by a device at `from`.
    static Bytes acknowledgement(const Bytes& request, std::uint8_t from) {
        const std::size_t n = request.size();
        return frame(from, request[1], 0x00, {request[3], request[n - 2], request[n - 1]});
    }
};

TEST_F(Alias, source_is_rewritten_on_the_way_in_and_destination_on_the_way_out) {
    EXPECT_EQ(in(frame(0xDE, 0xFE, 0x51, {1, 2, 3})), frame(31, 0xFE, 0x51, {1, 2, 3}));
    EXPECT_EQ(in(frame(0xDE, 0xFF, 0x51, {})), frame(31, 0xFF, 0x51, {}));
    EXPECT_EQ(out(frame(0xFE, 31, 0xE0, {2, 0, 0})), frame(0xFE, 0xDE, 0xE0, {2, 0, 0}));
}

TEST_F(Alias, frames_of_other_devices_pass_unchanged) {
    EXPECT_EQ(in(frame(0xDD, 0xDE, 0x01, {1})), frame(0xDD, 0xDE, 0x01, {1}));
    EXPECT_EQ(out(frame(0xFE, 0xFF, 0xE0, {0, 0, 0})), frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_EQ(out(frame(0xDE, 0xDC, 0x51, {1})), frame(0xDE, 0xDC, 0x51, {1}));
}

TEST_F(Alias, frame_to_the_original_id_of_an_aliased_device_is_not_sent) {
    EXPECT_EQ(out(frame(0xFE, 0xDE, 0xE0, {0, 0, 0})), Bytes{});
}

TEST_F(Alias, works_for_a_device_that_sends_from_no_address) {
    for (const std::uint8_t nobody : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        aliases = Aliases{{{.device = nobody, .as = 31}}, 200};
        EXPECT_EQ(in(frame(nobody, 0xFE, 0x51, {1, 2, 3})), frame(31, 0xFE, 0x51, {1, 2, 3}));
        EXPECT_EQ(out(frame(0xFE, 31, 0xE0, {2, 0, 0})), frame(0xFE, nobody, 0xE0, {2, 0, 0}));
        EXPECT_EQ(out(frame(0xFE, 0xFF, 0xE0, {0, 0, 0})), frame(0xFE, 0xFF, 0xE0, {0, 0, 0})) << "to everybody";
        EXPECT_EQ(out(frame(0xFE, 0xDE, 0xE0, {0, 0, 0})), frame(0xFE, 0xDE, 0xE0, {0, 0, 0}));
        const Bytes sent = frame(0xFE, 31, 0xE1, {3, 0, 42});
        EXPECT_EQ(in(acknowledgement(out(sent), nobody)), acknowledgement(sent, 31));
    }
}

TEST_F(Alias, device_info_contains_the_alias) {
    EXPECT_EQ(in(frame(0xDE, 0xFE, 0xE3, {0xDE, 100, 0, 'x'})), frame(31, 0xFE, 0xE3, {31, 100, 0, 'x'}));
    EXPECT_EQ(in(frame(0xDE, 0xFE, 0xE3, {0xDD, 100})), frame(31, 0xFE, 0xE3, {0xDD, 100}));
    EXPECT_EQ(in(frame(0xDE, 0xFE, 0xE3, {})), frame(31, 0xFE, 0xE3, {}));
}

TEST_F(Alias, acknowledgement_of_a_write_carries_the_checksum_as_it_was_sent) {
    const Bytes sent = frame(0xFE, 31, 0xE1, {3, 0, 42});
    const Bytes reached = out(sent);
    now += 4999ms;
    EXPECT_EQ(in(acknowledgement(reached, 0xDE)), acknowledgement(sent, 31));
    EXPECT_EQ(in(acknowledgement(reached, 0xDE)), acknowledgement(sent, 31)) << "a device may answer twice";
}

TEST_F(Alias, acknowledgement_of_a_write_by_the_device_carries_the_checksum_as_it_was_sent) {
    const Bytes sent = frame(0xDE, 0xFE, 0xE1, {3, 0, 42});
    const Bytes reached = in(sent);
    EXPECT_EQ(out(acknowledgement(reached, 0xFE)), acknowledgement(sent, 0xFE));
}

TEST_F(Alias, acknowledgement_of_a_broadcast_is_left_as_it_is) {
    const Bytes sent = frame(0xFE, 0xFF, 0xE1, {3, 0, 42});
    EXPECT_EQ(out(sent), sent);
    EXPECT_EQ(in(acknowledgement(sent, 0xDE)), acknowledgement(sent, 31));
}

TEST_F(Alias, acknowledgements_for_several_requesters_carry_the_checksum_that_each_sent) {
    const Bytes mine = frame(0xFE, 31, 0xE1, {3, 0, 42});
    const Bytes theirs = frame(0xD2, 31, 0xE1, {3, 0, 42});
    const Bytes mine_there = out(mine);
    const Bytes theirs_there = out(theirs);
    EXPECT_EQ(in(acknowledgement(mine_there, 0xDE)), acknowledgement(mine, 31));
    EXPECT_EQ(in(acknowledgement(theirs_there, 0xDE)), acknowledgement(theirs, 31));
}

TEST_F(Alias, memory_expires) {
    const Bytes sent = frame(0xFE, 31, 0xE1, {3, 0, 42});
    const Bytes reached = out(sent);
    now += Aliases::memory;
    EXPECT_EQ(in(acknowledgement(reached, 0xDE)), acknowledgement(reached, 31));
}

TEST_F(Alias, streams_displace_nothing_in_the_memory) {
    const Bytes sent = frame(0xFE, 31, 0xE1, {3, 0, 42});
    const Bytes reached = out(sent);
    for (int n = 0; n < 100000; ++n)
        in(frame(0xDE, 0xFE, 0x51, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}));
    EXPECT_EQ(in(acknowledgement(reached, 0xDE)), acknowledgement(sent, 31));
}

// 2000 frames of an image would displace everything else in the memory.
TEST_F(Alias, firmware_frames_displace_nothing_in_the_memory) {
    const Bytes sent = frame(0xFE, 31, 0xE1, {3, 0, 42});
    const Bytes reached = out(sent);
    for (int n = 0; n < 2000; ++n)
        out(frame(0xFE, 31, 0xF0, {0x10, static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}));
    EXPECT_EQ(in(acknowledgement(reached, 0xDE)), acknowledgement(sent, 31));
}

TEST_F(Alias, short_acknowledgement_and_large_frame_pass) {
    EXPECT_EQ(in(frame(0xDE, 0xFE, 0x00, {0xE1, 1})), frame(31, 0xFE, 0x00, {0xE1, 1}));
    EXPECT_EQ(out(frame(0xFE, 31, 0xE1, Bytes(200))), frame(0xFE, 0xDE, 0xE1, Bytes(200)));
    EXPECT_EQ(out(frame(0xFE, 31, 0xE1, Bytes(201))), frame(0xFE, 31, 0xE1, Bytes(201)));
}

TEST(Aliases, two_devices_may_swap_addresses) {
    Aliases aliases{{{.device = 30, .as = 31}, {.device = 31, .as = 30}}, 10};
    const Bytes to = frame(0xFE, 31, 0x01, {1});
    const Bytes from = frame(31, 0xFE, 0x01, {1});
    EXPECT_EQ(aliases.outbound(ano::FrameView{to}, {})->destination(), 30);
    EXPECT_EQ(aliases.inbound(ano::FrameView{from}, {}).source(), 30);
}

}    // namespace
}    // namespace alias_tests
