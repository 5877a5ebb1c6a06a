// A host and a simulated device on a bad link.
#include <host/commands.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <world/faulty_line.hpp>
#include <world/kinds.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace host_tests {
namespace {

using namespace ano::world;
using namespace std::chrono_literals;

constexpr ano::TimePoint start{1000s};

struct Day {
    Day(const Faults& faults, std::uint64_t seed) : line{make_device("fc", {0, 50, seed}, start), faults, seed, start} {}

    void run(const ano::host::Task& task) {
        for (const auto end = now + 10min; !task.end() && now < end;) {
            while (const auto frame = host.next_frame(now)) {
                const std::vector<std::uint8_t> bytes{frame->bytes().begin(), frame->bytes().end()};
                line.take(ano::FrameView{bytes}, now, receive);
            }
            if (task.end()) return;
            now = std::max(now, std::min({end, line.due(), host.due().value_or(end)}));
            line.run(now, receive);
        }
    }

    ano::TimePoint now = start;
    ano::host::Device host{0xDC};
    const FaultyLine::Send receive = [this](ano::Bytes bytes, ano::TimePoint) {
        if (const auto frame = ano::frame_at(bytes)) host.take(*frame, now);
    };
    FaultyLine line;
};

TEST(HostOfSimulated, reads_and_writes_over_a_bad_link) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        Faults faults;
        faults.loss = 15;
        faults.duplicate = 10;
        faults.corrupt = 5;
        faults.delay = 20ms;
        faults.jitter = 30ms;
        Day day{faults, seed};
        ano::host::Parameters all{day.host};
        all.read_all(day.now);
        day.run(all);
        ASSERT_TRUE(all.end());
        ASSERT_EQ(all.end()->ending, ano::host::Ending::done) << all.end()->fault.text();
        EXPECT_EQ(all.descriptions().size(), 150u);
        const auto speed = all.find("SIM_SPEED").parameter;
        ASSERT_NE(speed, nullptr);
        ano::host::ParameterWrite write{day.host, *speed, std::int64_t{5000}};
        write.start(day.now);
        day.run(write);
        ASSERT_EQ(write.end()->ending, ano::host::Ending::done) << write.end()->fault.text();
        EXPECT_TRUE(write.is_clamped());
        EXPECT_EQ(write.stored(), ano::host::AnyValue{std::int64_t{1000}});
        ano::host::Commands commands{day.host};
        commands.read(day.now);
        day.run(commands);
        ASSERT_EQ(commands.end()->ending, ano::host::Ending::done) << commands.end()->fault.text();
        EXPECT_EQ(commands.descriptions().size(), 12u);
    }
}

TEST(HostOfSimulated, reports_a_timeout_for_a_deaf_device) {
    Faults faults;
    faults.deaf_after = 1ms;
    Day day{faults, 1};
    ano::host::Parameters all{day.host};
    all.read_all(day.now + 1s);
    day.now += 1s;
    day.run(all);
    ASSERT_TRUE(all.end());
    EXPECT_EQ(all.end()->ending, ano::host::Ending::timeout);
}

}    // namespace
}    // namespace host_tests
