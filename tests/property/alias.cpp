// Two devices with one id on two links, with two aliases, and a host: each writes to the others, at most twenty writes in flight,
// and every acknowledgement reaches its writer with the checks of the frame as it was sent.
#include <gateway/alias.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace alias_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr std::uint8_t host = 0xFE;
constexpr std::uint8_t device = 0xDE;    // the id of both

struct Network {
    Aliases flow1{{{.device = device, .as = 31}}, 64};
    Aliases flow2{{{.device = device, .as = 32}}, 64};
    ano::TimePoint now{};

    Aliases* link_of(std::uint8_t address) { return address == 31 ? &flow1 : address == 32 ? &flow2 : nullptr; }

    // Returns `frame` as its receiver gets it. `from` is the address by which the others know its sender.
    Bytes carry(Bytes frame, std::uint8_t from) {
        if (Aliases* link = link_of(from)) frame = bytes(link->inbound(ano::FrameView{frame}, now));
        EXPECT_EQ(frame[1], from);
        if (Aliases* link = link_of(frame[2])) frame = bytes(link->outbound(ano::FrameView{frame}, now).value());
        return frame;
    }
    static Bytes bytes(ano::FrameView frame) {
        EXPECT_TRUE(ano::frame_at(frame.bytes()));
        return {frame.bytes().begin(), frame.bytes().end()};
    }
};

TEST(Alias, every_acknowledgement_matches_the_frame_that_was_sent) {
    constexpr std::array<std::uint8_t, 3> addresses{host, 31, 32};
    for (std::uint64_t seed = 1; seed <= support::trials(40); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        Network network;
        struct Flight {
            Bytes sent, arrived;
            std::uint8_t from, to;
        };
        std::vector<Flight> flying;
        for (int step = 0; step < 500; ++step) {
            network.now += random.below(150u) * 1ms;
            if (flying.size() < 20) {
                const std::uint8_t from = addresses[random.below(addresses.size())];
                const std::uint8_t to = addresses[random.below(addresses.size())];
                if (from == to) continue;
                Bytes data(random.below(60u));
                for (auto& byte : data) byte = random.byte();
                const std::uint8_t id = random.of<std::uint8_t>({0x61, 0xC0, 0xE0, 0xE1});
                const Bytes sent = support::frame(from == host ? host : device, to, id, data);
                const Bytes arrived = network.carry(sent, from);
                EXPECT_EQ(arrived[1], from);
                EXPECT_EQ(arrived[2], to == host ? host : device);
                EXPECT_TRUE(std::equal(arrived.begin() + 3, arrived.end() - 2, sent.begin() + 3));
                flying.push_back({sent, arrived, from, to});
                continue;
            }
            network.now += 1s;
            std::shuffle(flying.begin(), flying.end(), std::mt19937{static_cast<unsigned>(seed)});
            for (const Flight& flight : flying) {
                const std::size_t n = flight.sent.size();
                const Bytes told{flight.arrived[3], flight.arrived[n - 2], flight.arrived[n - 1]};
                const Bytes answer = support::frame(flight.to == host ? host : device, flight.arrived[1], 0x00, told);
                const Bytes got = network.carry(answer, flight.to);
                const Bytes expected{flight.sent[3], flight.sent[n - 2], flight.sent[n - 1]};
                EXPECT_EQ(Bytes(got.begin() + 6, got.begin() + 9), expected) << int{flight.from} << " to " << int{flight.to};
                EXPECT_EQ(got[1], flight.to);
            }
            flying.clear();
        }
    }
}

TEST(Alias, allocates_nothing) {
    Aliases aliases{{{.device = device, .as = 31}}, 64};
    const Bytes in = support::frame(device, host, 0xE1, {1, 2, 3});
    const Bytes out = support::frame(host, 31, 0xE1, {1, 2, 3});
    const auto before = support::allocations;
    for (int n = 0; n < 10000; ++n) {
        aliases.inbound(ano::FrameView{in}, ano::TimePoint{} + n * 1ms);
        aliases.outbound(ano::FrameView{out}, ano::TimePoint{} + n * 1ms);
    }
    EXPECT_EQ(support::allocations, before);
}

}    // namespace
}    // namespace alias_tests
