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
    bool hears(const Bytes& bytes, TimePoint now) { return heard(ano::FrameView{bytes}, now); }
    void was_sent(const Bytes& bytes, TimePoint now) { sent(ano::FrameView{bytes}, now); }
};

Bytes answer_to(std::uint8_t address) { return frame(0xDC, address, 0xE3, Bytes(15, 1)); }
const Bytes command = frame(0xFE, 0xDC, 0xC0, {16, 0, 2});
const Bytes acknowledged = frame(0xDC, 0xFE, 0x00, {0xC0, command[command.size() - 2], command.back()});

TEST(FarPeer, gets_three_times_its_own_bytes_in_each_ten_seconds) {
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

TEST(FarPeer, is_there_when_it_answered_two_questions_at_the_addresses_that_asked) {
    Far far;
    const auto question = far.ask(start);
    ASSERT_TRUE(question);
    EXPECT_EQ(Bytes(question->begin(), question->end()), frame(asked_as, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_FALSE(far.ask(start)) << "one is open";
    EXPECT_TRUE(far.hears(answer_to(asked_as), start + 1s)) << "for nobody else";
    EXPECT_FALSE(far.is_there());
    ASSERT_TRUE(far.ask(start + 1s)) << "the next one at once";
    EXPECT_TRUE(far.hears(answer_to(asked_as), start + 2s));
    EXPECT_TRUE(far.is_there());
}

TEST(FarPeer, an_answer_to_another_address_makes_the_question_void) {
    Far far;
    far.ask(start);
    far.hears(answer_to(asked_as), start);
    far.ask(start);
    EXPECT_FALSE(far.hears(answer_to(asked_as + 1), start));
    EXPECT_FALSE(far.hears(answer_to(asked_as), start)) << "no second guess";
    EXPECT_FALSE(far.ask(start + 9s));
    far.came(100, start + 10s);
    EXPECT_TRUE(far.ask(start + 10s));
    far.hears(answer_to(asked_as), start + 10s);
    EXPECT_FALSE(far.is_there()) << "one right guess of those that came later is not two";
}

TEST(FarPeer, an_answer_to_a_host_is_not_ours_and_proves_nothing) {
    Far far;
    far.ask(start);
    EXPECT_FALSE(far.hears(answer_to(0xFE), start));
    EXPECT_TRUE(far.hears(answer_to(asked_as), start)) << "and disturbs nothing";
}

TEST(FarPeer, an_answer_that_comes_too_late_or_unasked_counts_for_nothing) {
    Far far;
    EXPECT_FALSE(far.hears(answer_to(asked_as), start));
    far.ask(start);
    EXPECT_FALSE(far.hears(answer_to(asked_as), start + 3s + 1ns));
    Far in_time;
    in_time.ask(start);
    EXPECT_TRUE(in_time.hears(answer_to(asked_as), start + 3s));
}

TEST(FarPeer, is_asked_only_within_its_allowance) {
    FarPeer far{start};
    const auto random = [] { return chance; };
    EXPECT_FALSE(far.question(random, start));
    far.came(3, start);
    EXPECT_FALSE(far.question(random, start)) << "9 bytes, and a question has 11";
    far.came(1, start);
    EXPECT_TRUE(far.question(random, start));
}

TEST(FarPeer, is_there_when_it_acknowledges_a_command_that_it_was_sent) {
    Far far;
    EXPECT_FALSE(far.hears(acknowledged, start));
    EXPECT_FALSE(far.is_there()) << "nothing was sent yet";
    far.was_sent(command, start);
    EXPECT_FALSE(far.hears(acknowledged, start + 10s)) << "whoever asked is to get it too";
    EXPECT_TRUE(far.is_there());
}

TEST(FarPeer, may_acknowledge_any_of_the_last_eight_commands) {
    for (const int later : {7, 8}) {
        Far far;
        far.was_sent(command, start);
        for (std::uint8_t n = 0; n < later; ++n) far.was_sent(frame(0xFE, 0xDC, 0xC0, {16, 1, n}), start);
        far.hears(acknowledged, start);
        EXPECT_EQ(far.is_there(), later < 8) << later;
    }
}

TEST(FarPeer, what_it_acknowledges_too_late_or_with_other_checks_proves_nothing) {
    Far late, wrong, telemetry;
    late.was_sent(command, start);
    late.hears(acknowledged, start + 10s + 1ns);
    EXPECT_FALSE(late.is_there());
    wrong.was_sent(command, start);
    wrong.hears(frame(0xDC, 0xFE, 0x00, {0xC0, acknowledged[7], static_cast<std::uint8_t>(acknowledged[8] + 1)}), start);
    EXPECT_FALSE(wrong.is_there());
    const Bytes euler = frame(0xDD, 0xFE, 0x03, Bytes(7, 0));
    telemetry.was_sent(euler, start);
    telemetry.hears(frame(0xDC, 0xFE, 0x00, {0x03, euler[euler.size() - 2], euler.back()}), start);
    EXPECT_FALSE(telemetry.is_there()) << "nobody acknowledges that, and anybody may know it";
}

TEST(FarPeer, has_few_guesses_at_the_checks_of_a_command) {
    Far far;
    far.was_sent(command, start);
    for (std::uint8_t n = 0; n < FarPeer::max_wrong_acknowledgements; ++n)
        far.hears(frame(0xDC, 0xFE, 0x00, {0xC0, n, n}), start);
    far.hears(acknowledged, start);
    EXPECT_FALSE(far.is_there());
    far.was_sent(command, start + 10s);
    far.hears(acknowledged, start + 10s);
    EXPECT_TRUE(far.is_there()) << "in the next ten seconds";
}

}    // namespace
}    // namespace anogate::far_peer_tests
