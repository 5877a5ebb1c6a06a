// The frames that may be sent to a peer outside our networks, and how it proves that it receives them.
#include <gateway/peers/far_peer.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

namespace anogate::far_peer_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::frame;

const TimePoint start = TimePoint{} + 1h;
constexpr std::uint64_t chance = 17;    // the seed of the questioning addresses
constexpr std::uint8_t asked_as = 21 + 17;

struct Far : FarPeer {
    Far() : FarPeer{start} { came(100, start); }
    std::optional<Question> ask(TimePoint now) {
        return question([] { return chance; }, now);
    }
    bool receives(const Bytes& bytes, TimePoint now) { return heard(ano::FrameView{bytes}, now); }
    void was_sent(const Bytes& bytes, TimePoint now) { sent(ano::FrameView{bytes}, now); }
};

Bytes answer_to(std::uint8_t address) { return frame(0xDC, address, 0xE3, Bytes(15, 1)); }
const Bytes command = frame(0xFE, 0xDC, 0xC0, {16, 0, 2});
const Bytes acknowledged = frame(0xDC, 0xFE, 0x00, {0xC0, command[command.size() - 2], command.back()});

TEST(FarPeer, receives_at_most_three_times_its_sent_bytes_in_each_ten_seconds) {
    FarPeer far{start};
    EXPECT_EQ(far.allowance(start), 0u);
    far.came(8, start);
    EXPECT_EQ(far.allowance(start), 24u);
    far.left(20);
    EXPECT_EQ(far.allowance(start + 1s), 4u);
    far.came(10, start + 2s);
    EXPECT_EQ(far.allowance(start + 2s), 34u);
    far.left(34);
    EXPECT_EQ(far.allowance(start + 10s - 1ns), 0u);
    EXPECT_EQ(far.allowance(start + 10s), 0u) << "what it said before counts no more";
    far.came(8, start + 12s);
    EXPECT_EQ(far.allowance(start + 12s), 24u);
    EXPECT_FALSE(far.is_there());
}

TEST(FarPeer, is_confirmed_when_it_answers_two_requests_at_their_source_addresses) {
    Far far;
    const auto question = far.ask(start);
    ASSERT_TRUE(question);
    EXPECT_EQ(Bytes(question->begin(), question->end()), frame(asked_as, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_FALSE(far.ask(start)) << "one is open";
    EXPECT_TRUE(far.receives(answer_to(asked_as), start + 1s)) << "for nobody else";
    EXPECT_FALSE(far.is_there());
    ASSERT_TRUE(far.ask(start + 1s)) << "the next one at once";
    EXPECT_TRUE(far.receives(answer_to(asked_as), start + 2s));
    EXPECT_TRUE(far.is_there());
}

TEST(FarPeer, an_answer_to_a_wrong_address_voids_the_request) {
    Far far;
    far.ask(start);
    far.receives(answer_to(asked_as), start);
    far.ask(start);
    EXPECT_FALSE(far.receives(answer_to(asked_as + 1), start));
    EXPECT_FALSE(far.receives(answer_to(asked_as), start)) << "no second guess";
    EXPECT_FALSE(far.ask(start + 9s));
    far.came(100, start + 10s);
    EXPECT_TRUE(far.ask(start + 10s));
    far.receives(answer_to(asked_as), start + 10s);
    EXPECT_FALSE(far.is_there()) << "one right guess of those that came later is not two";
}

TEST(FarPeer, an_answer_to_a_host_does_not_count_as_one_to_the_gateway) {
    Far far;
    far.ask(start);
    EXPECT_FALSE(far.receives(answer_to(0xFE), start));
    EXPECT_TRUE(far.receives(answer_to(asked_as), start)) << "and disturbs nothing";
}

TEST(FarPeer, a_late_or_unsolicited_answer_does_not_count) {
    Far far;
    EXPECT_FALSE(far.receives(answer_to(asked_as), start));
    far.ask(start);
    EXPECT_FALSE(far.receives(answer_to(asked_as), start + 3s + 1ns));
    Far in_time;
    in_time.ask(start);
    EXPECT_TRUE(in_time.receives(answer_to(asked_as), start + 3s));
}

TEST(FarPeer, receives_a_request_only_within_its_allowance) {
    FarPeer far{start};
    const auto random = [] { return chance; };
    EXPECT_FALSE(far.question(random, start));
    far.came(3, start);
    EXPECT_FALSE(far.question(random, start)) << "9 bytes, and a question has 11";
    far.came(1, start);
    EXPECT_TRUE(far.question(random, start));
}

TEST(FarPeer, is_confirmed_when_it_acknowledges_a_command_sent_to_it) {
    Far far;
    EXPECT_FALSE(far.receives(acknowledged, start));
    EXPECT_FALSE(far.is_there()) << "nothing was sent yet";
    far.was_sent(command, start);
    EXPECT_FALSE(far.receives(acknowledged, start + 10s)) << "whoever asked is to get it too";
    EXPECT_TRUE(far.is_there());
}

TEST(FarPeer, may_acknowledge_any_of_the_last_eight_commands) {
    for (const int later : {7, 8}) {
        Far far;
        far.was_sent(command, start);
        for (std::uint8_t n = 0; n < later; ++n) far.was_sent(frame(0xFE, 0xDC, 0xC0, {16, 1, n}), start);
        far.receives(acknowledged, start);
        EXPECT_EQ(far.is_there(), later < 8) << later;
    }
}

TEST(FarPeer, is_not_confirmed_by_a_late_acknowledgement_or_one_with_a_wrong_checksum) {
    Far late, wrong, telemetry;
    late.was_sent(command, start);
    late.receives(acknowledged, start + 10s + 1ns);
    EXPECT_FALSE(late.is_there());
    wrong.was_sent(command, start);
    wrong.receives(frame(0xDC, 0xFE, 0x00, {0xC0, acknowledged[7], static_cast<std::uint8_t>(acknowledged[8] + 1)}), start);
    EXPECT_FALSE(wrong.is_there());
    const Bytes euler = frame(0xDD, 0xFE, 0x03, Bytes(7, 0));
    telemetry.was_sent(euler, start);
    telemetry.receives(frame(0xDC, 0xFE, 0x00, {0x03, euler[euler.size() - 2], euler.back()}), start);
    EXPECT_FALSE(telemetry.is_there()) << "nobody acknowledges that, and anybody may know it";
}

TEST(FarPeer, has_few_attempts_to_guess_the_checksum_of_a_command) {
    Far far;
    far.was_sent(command, start);
    for (std::uint8_t n = 0; n < FarPeer::max_wrong_acknowledgements; ++n)
        far.receives(frame(0xDC, 0xFE, 0x00, {0xC0, n, n}), start);
    far.receives(acknowledged, start);
    EXPECT_FALSE(far.is_there());
    far.was_sent(command, start + 10s);
    far.receives(acknowledged, start + 10s);
    EXPECT_TRUE(far.is_there()) << "in the next ten seconds";
}

}    // namespace
}    // namespace anogate::far_peer_tests
