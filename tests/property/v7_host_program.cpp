// A V7 host program, the two translations behind each other, and a simulated V7 device behind a line that loses frames: the program
// uses the device as if it had it at its own port.
#include <gateway/v7_host_translation.hpp>

#include <ano/frame.hpp>
#include <ano/wire.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>
#include <world/faulty_line.hpp>
#include <world/kinds.hpp>
#include <world/lx_unit.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace v7_host_program_tests {

using namespace std::chrono_literals;
using support::Bytes;
using support::v7_frame;
using support::operator+;
namespace v7 = ano::v7;

namespace {

constexpr std::uint8_t imu = 0xDD;

struct Chain {
    struct Side final : anogate::V7Output {
        std::function<void(v7::FrameView)> v7;
        std::function<void(ano::FrameView)> v8;
        void to_device(v7::FrameView frame) override { v7(frame); }
        void from_device(ano::FrameView frame) override { v8(frame); }
    };

    Chain(std::uint64_t seed, unsigned loss, const anogate::V7Settings& settings = with_table())
        : host_side{settings},
          device_side{settings},
          line{ano::world::make_device("lx", {0, 50, seed}, start), {.loss = loss, .delay = 5ms}, seed, start} {
        at_host.v7 = [this](v7::FrameView f) { to_program.emplace_back(f.bytes().begin(), f.bytes().end()); };
        at_host.v8 = [this](ano::FrameView f) { to_device_edge.emplace_back(f.bytes().begin(), f.bytes().end()); };
        at_device.v7 = [this](v7::FrameView f) {
            commands_sent += f.id() == 0xE0;
            to_line.emplace_back(f.bytes().begin(), f.bytes().end());
        };
        at_device.v8 = [this](ano::FrameView f) { to_host_edge.emplace_back(f.bytes().begin(), f.bytes().end()); };
    }
    static anogate::V7Settings with_table() {
        anogate::V7Settings made{.address = imu};
        made.parameters = anogate::v7_lx_parameters();
        return made;
    }

    ano::world::LxUnit& device() { return static_cast<ano::world::LxUnit&>(line.device()); }
    void exchange() {
        while (!to_line.empty() || !to_host_edge.empty() || !to_device_edge.empty()) {
            for (const Bytes& f : std::exchange(to_device_edge, {})) device_side.down(ano::FrameView{f}, now, at_device);
            for (const Bytes& f : std::exchange(to_host_edge, {})) host_side.down(ano::FrameView{f}, now, at_host);
            for (const Bytes& f : std::exchange(to_line, {})) line.take(ano::Bytes{f}, now, receive);
        }
    }
    void send(const Bytes& frame) {
        host_side.up(v7::FrameView{frame}, now, at_host);
        exchange();
    }
    void run_until(ano::TimePoint end, const std::function<bool()>& ended) {
        while (now < end && !ended()) {
            auto next = std::min(end, line.due());
            for (const auto due : {host_side.deadline(), device_side.deadline()})
                if (due) next = std::min(next, *due);
            now = std::max(now, next);
            host_side.expire(now, at_host);
            device_side.expire(now, at_device);
            line.run(now, receive);
            exchange();
        }
    }
    /// Sends `frame` up to `times` times, every second, until it is answered by a frame that `is_answer`.
    bool ask(const Bytes& frame, unsigned times, const std::function<bool(const Bytes&)>& is_answer) {
        bool is_answered = false;
        for (unsigned i = 0; i < times && !is_answered; ++i) {
            to_program.clear();
            send(frame);
            ++frames_of_program;
            run_until(now + 1500ms, [&] {
                for (const Bytes& f : std::exchange(to_program, {}))
                    if (is_answer(f)) is_answered = true;
                return is_answered;
            });
        }
        return is_answered;
    }
    static auto check_of(const Bytes& frame) {
        return [expected = v7_frame(0xAF, 0x00, {frame[2], frame[frame.size() - 2], frame[frame.size() - 1]})](const Bytes& f) {
            return f == expected;
        };
    }

    static constexpr ano::TimePoint start{1000s};
    ano::TimePoint now = start;
    anogate::V7HostTranslation host_side;
    anogate::V7Translation device_side;
    ano::world::FaultyLine line;
    Side at_host, at_device;
    std::vector<Bytes> to_program, to_device_edge, to_host_edge, to_line;
    std::size_t commands_sent = 0, frames_of_program = 0;
    const ano::world::FaultyLine::Send receive = [this](ano::Bytes bytes, ano::TimePoint) {
        if (const auto frame = v7::frame_at(bytes)) {
            ++received[frame->id()];
            device_side.up(*frame, now, at_device);
        }
    };
    std::size_t received[256]{};
};

Bytes u16(std::uint16_t value) {
    Bytes bytes(2);
    ano::store(bytes.data(), value);
    return bytes;
}
Bytes parameter(std::uint16_t number, std::int32_t value) {
    Bytes bytes(6);
    ano::store(bytes.data(), number);
    ano::store(bytes.data() + 2, value);
    return bytes;
}

class HostProgramWithLoss : public testing::TestWithParam<unsigned> {};    // %

// Neither side has a table.
TEST_P(HostProgramWithLoss, reads_and_writes_parameters_by_number_without_a_table) {
    for (std::uint64_t seed = 0; seed < support::trials(3); ++seed) {
        SCOPED_TRACE(seed);
        Chain chain{seed, GetParam(), {.address = imu}};
        for (const std::uint16_t number : std::initializer_list<std::uint16_t>{151, 300, 1001}) {
            SCOPED_TRACE(number);
            const auto is_value = [&](const Bytes& f) {
                return f == v7_frame(0xAF, 0xE2, parameter(number, chain.device().parameter(number)));
            };
            EXPECT_TRUE(chain.ask(v7_frame(0x60, 0xE1, u16(number)), 10, is_value));
            const Bytes write = v7_frame(0x60, 0xE2, parameter(number, 77));
            EXPECT_TRUE(chain.ask(write, 10, Chain::check_of(write)));
            EXPECT_EQ(chain.device().parameter(number), 77);
        }
    }
}

TEST_P(HostProgramWithLoss, reads_and_writes_parameters_by_number) {
    for (std::uint64_t seed = 0; seed < support::trials(3); ++seed) {
        SCOPED_TRACE(seed);
        Chain chain{seed, GetParam()};
        support::Random random{seed};
        for (const std::uint16_t number : std::initializer_list<std::uint16_t>{151, 152, 157, 300, 303, 1001, 1015}) {
            SCOPED_TRACE(number);
            const auto is_value = [&](const Bytes& f) {
                return f == v7_frame(0xAF, 0xE2, parameter(number, chain.device().parameter(number)));
            };
            EXPECT_TRUE(chain.ask(v7_frame(0x60, 0xE1, u16(number)), 10, is_value));
            const auto wanted = static_cast<std::int32_t>(random.below(100u)) + 20;
            const Bytes write = v7_frame(0x60, 0xE2, parameter(number, wanted));
            EXPECT_TRUE(chain.ask(write, 10, Chain::check_of(write)));
            EXPECT_EQ(chain.device().parameter(number), wanted);
            EXPECT_TRUE(chain.ask(v7_frame(0x60, 0xE1, u16(number)), 10, is_value));
        }
        EXPECT_TRUE(chain.ask(v7_frame(0x60, 0xE1, u16(1)), 10,
                              [](const Bytes& f) { return f == v7_frame(0xAF, 0xE2, parameter(1, 0x60)); }));
        EXPECT_EQ(chain.device().false_measurements(), 0u);
    }
}

TEST_P(HostProgramWithLoss, commands_reach_the_device_as_often_as_they_are_sent) {
    std::size_t checked = 0;
    for (const auto& vector : support::v7_vectors("valid")) {
        if (vector.v7[2] != 0xE0) continue;
        SCOPED_TRACE(vector.meaning);
        Chain chain{checked, GetParam()};
        const bool is_done = chain.ask(vector.v7, 10, Chain::check_of(vector.v7));
        EXPECT_EQ(chain.commands_sent, chain.frames_of_program);
        EXPECT_LE(chain.device().commands().size(), chain.frames_of_program);
        EXPECT_TRUE(is_done);
        ASSERT_FALSE(chain.device().commands().empty());
        const auto& data = chain.device().commands().back();
        EXPECT_TRUE(std::equal(data.begin(), data.end(), vector.v7.begin() + v7::header_size));
        ++checked;
    }
    EXPECT_GE(checked, 8u);
}

TEST_P(HostProgramWithLoss, waypoints_are_written_and_read) {
    Chain chain{5, GetParam()};
    for (std::uint8_t i = 0; i < 5; ++i) {
        Bytes point(22);
        point[0] = i;
        point[1] = static_cast<std::uint8_t>(i * 3);
        const Bytes write = v7_frame(0x60, 0x61, point);
        EXPECT_TRUE(chain.ask(write, 10, Chain::check_of(write)));
        EXPECT_TRUE(chain.ask(v7_frame(0x60, 0x60, {i}), 10, [&](const Bytes& f) { return f == v7_frame(0xAF, 0x61, point); }));
    }
    EXPECT_EQ(chain.device().waypoints(), 5u);
}

// Both translations together change nothing, except values that V8 rounds to its own units.
TEST(HostProgram, receives_the_telemetry_that_the_device_sends) {
    Chain chain{1, 0};
    chain.run_until(chain.now + 10s, [] { return false; });
    std::size_t received[256]{};
    for (const Bytes& f : chain.to_program) ++received[f[2]];
    for (const std::uint8_t id :
         Bytes{0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0D, 0x0E, 0x20, 0x30, 0x40, 0x41, 0xFA}) {
        EXPECT_GT(received[id], 0u) << unsigned{id};
        EXPECT_EQ(received[id], chain.received[id]) << unsigned{id};
    }
    EXPECT_EQ(chain.host_side.dropped(), 0u);
}

INSTANTIATE_TEST_SUITE_P(percent, HostProgramWithLoss, testing::Values(0, 10),
                         [](const auto& test) { return std::to_string(test.param); });

}    // namespace
}    // namespace v7_host_program_tests
