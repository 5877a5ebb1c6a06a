// Hosts with several addresses ask the devices of one link, which answer only 0xFE, in any way: each answer reaches exactly the
// host that asked, and every acknowledgement contains the checks of the sent bytes.
#include <gateway/alias.hpp>
#include <gateway/present_as.hpp>
#include <gateway/queue_policy.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <map>

namespace present_as_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr std::uint8_t host = 0xFE;
constexpr std::array<std::uint8_t, 5> askers{host, 0xD2, 7, 100, 0xFD};
constexpr std::array<std::uint8_t, 3> devices{0xDC, 0xDD, 31};    // the address of the last is also 0xDE

Bytes bytes(ano::FrameView frame) {
    EXPECT_TRUE(ano::frame_at(frame.bytes()));
    return {frame.bytes().begin(), frame.bytes().end()};
}

// The answer of a device: to 0xFE, or none.
Bytes answer(const Bytes& request, std::uint8_t self) {
    const Bytes data{request.begin() + 6, request.end() - 2};
    const std::size_t n = request.size();
    const auto reply = [&](std::uint8_t id, const Bytes& with) { return support::frame(self, host, id, with); };
    switch (request[3]) {
    case 0x60: return data[0] == 0xFF ? reply(0x60, {9}) : reply(0x61, {data[0], 1, 2, 3});
    case 0xC1: return data[0] == 0 ? reply(0xC1, {0, 4, 0}) : reply(0xC2, {data[1], data[2], 1, 2, 3});
    case 0xF0: return reply(0xF0, {0, data[1], data[2]});
    case 0xE0:
        switch (data[0]) {
        case 0: return reply(0xE3, {self, 100, 0});
        case 1: return reply(0xE0, {1, 40, 0});
        case 2: return reply(0xE1, {data[1], data[2], 42});
        case 3: return reply(0xE2, {data[1], data[2], 0, 'x'});
        }
        break;
    }
    return reply(0x00, {request[3], request[n - 2], request[n - 1]});
}

// The link, and the devices on it.
struct Link {
    PresentAs hosts{host, 64};
    Aliases aliases{{{.device = 0xDE, .as = 31}}, 64};
    ano::TimePoint now{1h};
    std::uint64_t number = 0;

    Bytes out(const Bytes& sent) {
        const auto presented = hosts.outbound(ano::FrameView{sent}, ++number, now);
        return bytes(aliases.outbound(presented, now).value());
    }
    Bytes in(const Bytes& said) { return bytes(hosts.inbound(aliases.inbound(ano::FrameView{said}, now), now)); }
};

// Few of each kind, so that hosts often send equal questions.
Bytes question(support::Random& random, std::uint8_t from, std::uint8_t to) {
    const std::uint8_t n = random.below<std::uint8_t>(2);
    switch (random.below(9u)) {
    case 0: return support::frame(from, to, 0x60, {random.of<std::uint8_t>({0xFF, n})});
    case 1: return support::frame(from, to, 0x61, Bytes(22, n));
    case 2: return support::frame(from, to, 0xC0, {1, 2, n});
    case 3: return support::frame(from, to, 0xC1, {n, n, 0});
    case 4: return support::frame(from, to, 0xE1, {n, 0, 42});
    case 5: return support::frame(from, to, 0xF0, {0x10, n, 0, 1, 2});
    case 6: return support::frame(from, to, 0xE0, {0x10, 0xAB, 0});
    default: return support::frame(from, to, 0xE0, {random.below<std::uint8_t>(4), n, 0});
    }
}

TEST(PresentAs, sends_every_answer_exactly_to_the_requester) {
    for (std::uint64_t seed = 1; seed <= support::trials(20); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        Link link;
        std::array<std::deque<Bytes>, devices.size()> at_work;    // not yet answered by each device, as received
        std::map<Bytes, int> owed;                                // answers as the hosts must receive them
        std::size_t unanswered = 0;
        for (int step = 0; step < 2000 || unanswered > 0; ++step) {
            link.now += random.below(10u) * 1ms;
            const std::size_t d = random.below(devices.size());
            if (step < 2000 && unanswered < 40 && !random.one_in(3)) {
                const bool all = random.one_in(4);
                const std::uint8_t from = askers[random.below(askers.size())];
                const Bytes sent = question(random, from, all ? 0xFF : devices[d]);
                const Bytes reached = link.out(sent);
                ASSERT_EQ(reached[1], host);
                for (std::size_t k = 0; k < devices.size(); ++k) {
                    if (!all && k != d) continue;
                    const std::uint8_t self = devices[k] == 31 ? 0xDE : devices[k];
                    ASSERT_EQ(reached[2], all ? 0xFF : self);
                    at_work[k].push_back(answer(reached, self));
                    ++unanswered;
                    Bytes expected = answer(sent, devices[k]);
                    expected[2] = from;
                    ano::seal(expected);
                    ++owed[expected];
                }
            } else if (!at_work[d].empty()) {
                const Bytes got = link.in(at_work[d].front());
                at_work[d].pop_front();
                --unanswered;
                ASSERT_GT(owed[got]--, 0) << "to " << int{got[2]} << ", id " << int{got[3]};
            } else {
                const Bytes said = support::frame(devices[0], host, random.of<std::uint8_t>({0x03, 0xA0, 0xF1}), {random.byte()});
                ASSERT_EQ(link.in(said), said) << "nobody asked for it";
            }
        }
        for (const auto& [words, count] : owed) ASSERT_EQ(count, 0);
    }
}

TEST(PresentAs, allocates_nothing) {
    PresentAs hosts{host, 64};
    const Bytes out = support::frame(7, 0xDC, 0xE0, {2, 1, 0});
    const Bytes in = support::frame(0xDC, host, 0xE1, {1, 0, 3});
    const auto before = support::allocations;
    for (std::uint64_t n = 1; n < 2000; ++n) {
        const auto now = ano::TimePoint{} + n * 1ms;
        hosts.outbound(ano::FrameView{out}, n, now);
        hosts.inbound(ano::FrameView{in}, now);
    }
    EXPECT_EQ(support::allocations, before);
}

}    // namespace
}    // namespace present_as_tests
