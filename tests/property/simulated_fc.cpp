// The simulated flight controller, whatever it is told: it goes on saying whole frames of values that its messages can carry, for each of
// which it asserts that they fit.
#include <gateway/simulated_fc.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::Random;

namespace {

Bytes random_write(Random& random) {
    const auto id = random.of<std::uint8_t>({0xE1, 0xE1, 0xE1, 0xC0, 0xE0, 0x61});
    Bytes data{static_cast<std::uint8_t>(random.below(34u)), 0};
    if (id == 0xC0) data = {0x10, 0, static_cast<std::uint8_t>(random.below(6u))};
    if (id == 0xE0) data = {0x10, random.of<std::uint8_t>({0xAA, 0xAB, 0x20, 0x21, 0x30, 0x31}), 0};
    for (std::size_t i = random.below(32u); i-- > 0;)
        data.push_back(random.of<std::uint8_t>({0, 0x7F, 0x80, 0xFF, random.byte()}));
    return support::frame(0xFE, 0xDC, id, data);
}

TEST(SimulatedFc, says_what_its_messages_can_carry) {
    for (std::uint64_t seed = 0; seed < support::trials(100); ++seed) {
        Random random{seed};
        ano::TimePoint now{1000s};
        SimulatedFc fc{100, now};
        std::size_t said = 0;
        const SimulatedFc::Send hear = [&](ano::FrameView frame) {
            ++said;
            ASSERT_TRUE(ano::frame_at(frame.bytes())) << "seed " << seed;
            ASSERT_EQ(frame.source(), 0xDC);
        };
        for (int i = 0; i < 200; ++i) {
            const Bytes frame = random_write(random);
            fc.receive(ano::FrameView{frame}, now, hear);
            now += random.of<ano::Duration>({1ms, 10ms, 1s});
            fc.run(now, hear);
        }
        ASSERT_GT(said, 200u);
    }
}

}    // namespace
