// Every task ends within its time, even if a device always answers just before the time-out.
#include <support/fake_loader.hpp>
#include <support/host_tasks.hpp>

#include <gtest/gtest.h>

#include <map>

namespace ano::host::bounds_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::FakeDevice;
using support::FakeLoader;
using support::Simulation;

/// Answers only every fifth of equal frames.
struct Tardy : testing::Test {
    FakeDevice fake;
    FakeLoader loader;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 10ms}};
    std::map<Bytes, unsigned> heard;

    Tardy() {
        fake.instead = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (++heard[Bytes(frame.bytes().begin(), frame.bytes().end())] % 5 != 0) return std::vector<Bytes>{};
            return loader.take(fake, frame);
        };
    }
};

TEST_F(Tardy, device_delays_no_task_beyond_its_time_limit) {
    fake.make_parameters(12);
    fake.commands.resize(3);
    fake.waypoints.resize(4, Bytes(22));
    for (unsigned kind = 0; kind < support::task_kinds; ++kind) {
        const auto task = support::task_of(kind, device, simulation.now);
        const Duration took = simulation.run(*task, 24h);
        ASSERT_TRUE(task->end()) << kind;
        EXPECT_LE(took, 3 * task->max_duration() + 2min) << kind << ": the tasks of a task, one behind the other";
    }
}

TEST_F(Tardy, device_with_1000_parameters_is_read_completely_in_a_longer_time) {
    fake.make_parameters(1000);
    Parameters all{device};
    all.read_all(simulation.now);
    const Duration took = simulation.run(all, 24h);
    ASSERT_TRUE(all.end());
    EXPECT_EQ(all.end()->ending, Ending::done) << all.end()->fault.text();
    EXPECT_GT(took, 2min);
    EXPECT_LE(took, all.max_duration());
}

TEST_F(Tardy, device_is_left_in_its_boot_loader_when_an_upgrade_times_out) {
    simulation.there.delay = simulation.back.delay = 400ms;
    FirmwareImage image;
    image.bytes = Bytes(100'000);
    fake.instead = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
        const bool is_of_image = frame.id() == 0xF0 && frame.data()[0] == 0x10;
        if (is_of_image && ++heard[Bytes(frame.bytes().begin(), frame.bytes().end())] % 20 != 0) return std::vector<Bytes>{};
        return loader.take(fake, frame);
    };
    loader.second_info = support::FakeLoader::SecondInfo::ignores;
    Firmware upgrade{device, image, {.frame_len = 50}};
    upgrade.start(simulation.now);
    const Duration took = simulation.run(upgrade, 24h);
    ASSERT_TRUE(upgrade.end());
    EXPECT_EQ(upgrade.end()->ending, Ending::timeout);
    EXPECT_EQ(upgrade.end()->fault.text(),
              "0xDC answers too slowly: given up after 6600 s; it is left in its boot loader; start again");
    EXPECT_LE(took, upgrade.max_duration() + 1min);
}

}    // namespace
}    // namespace ano::host::bounds_tests
