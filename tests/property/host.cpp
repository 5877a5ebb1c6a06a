// The results of a host over faulty and slow lines, in simulated time; and that every task ends.
#include <host/firmware.hpp>
#include <host/parameter_apply.hpp>
#include <host/parameters.hpp>

#include <support/fake_loader.hpp>
#include <support/host_tasks.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace host_tests {

namespace {

using namespace ano::host;
using support::FakeDevice;
using support::LineFaults;
using support::Simulation;

struct Read {
    ano::Duration took;
    std::size_t frames_back, bytes_back, bytes_there;
    bool is_whole = true;
};

// Reads everything of a device with n parameters; `whole`: the result must be complete.
Read read_all(std::size_t n, LineFaults line, std::uint64_t seed, bool whole = true) {
    FakeDevice fake;
    fake.make_parameters(n);
    Device device{0xDC};
    Parameters parameters{device};
    Simulation simulation{device, fake, line, seed};
    parameters.read_all(simulation.now);
    const ano::Duration took = simulation.run(parameters);
    EXPECT_TRUE(parameters.end()) << "seed " << seed;
    if (!parameters.end()) return {};
    if (!whole && parameters.end()->ending != Ending::done) return {took, 0, 0, 0, false};
    EXPECT_EQ(parameters.end()->ending, Ending::done) << "seed " << seed << ": " << parameters.end()->fault.text();
    for (std::uint16_t id = 0; id < n; ++id) EXPECT_EQ(parameters.descriptions()[id].name, fake.parameters[id].name);
    EXPECT_FALSE(fake.crashed);
    return {took, simulation.frames_back, simulation.bytes_back, simulation.bytes_there};
}

double ratio(ano::Duration a, ano::Duration b) { return static_cast<double>(a.count()) / static_cast<double>(b.count()); }

TEST(Host, at_ten_percent_loss_and_200_ms_300_parameters_take_at_most_two_and_a_half_times_as_long) {
    using namespace std::chrono_literals;
    const ano::Duration clean = read_all(300, {.delay = 100ms}, 1).took;
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= support::trials(50); ++seed)
        worst = std::max(worst, ratio(read_all(300, {.delay = 100ms, .loss = 0.1}, seed).took, clean));
    RecordProperty("worst", std::to_string(worst));
    EXPECT_LE(worst, 2.5);
    EXPECT_GT(worst, 1.0);
}

TEST(Host, on_a_clean_line_of_115200_baud_300_parameters_take_at_most_1_3_times_the_wire_time) {
    const Read read = read_all(300, {.delay = std::chrono::milliseconds{1}, .baud = 115200}, 1);
    const auto wire = std::chrono::nanoseconds{std::max(read.bytes_back, read.bytes_there) * 10'000'000'000 / 115200};
    RecordProperty("ratio", std::to_string(ratio(read.took, wire)));
    EXPECT_LE(ratio(read.took, wire), 1.3);
    EXPECT_EQ(read.frames_back, 603u) << "nothing is asked twice";
}

// Random loss is not congestion. The line is fast; a value and a description of each parameter are read.
TEST(Host, at_random_loss_on_a_fast_line_121_parameters_are_read_in_seconds) {
    using namespace std::chrono_literals;
    struct Row {
        double loss;
        ano::Duration limit;
    };
    for (const Row& row : {Row{0.2, 3s}, Row{0.25, 5s}, Row{0.3, 8s}}) {
        std::vector<ano::Duration> times;
        std::size_t failed = 0;
        const std::uint64_t seeds = support::trials(100);
        for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
            const Read read = read_all(121, {.delay = 1ms, .loss = row.loss}, seed, false);
            if (read.is_whole) times.push_back(read.took);
            else ++failed;
        }
        std::sort(times.begin(), times.end());
        const auto name = "loss_" + std::to_string(static_cast<int>(100 * row.loss)) + "_ms_";
        RecordProperty(name + "median", std::to_string(times[times.size() / 2] / 1ms));
        RecordProperty(name + "nine_of_ten", std::to_string(times[times.size() * 9 / 10] / 1ms));
        RecordProperty(name + "worst", std::to_string(times.back() / 1ms));
        RecordProperty(name + "failed", std::to_string(failed));
        EXPECT_LE(times.back(), row.limit) << row.loss;
        EXPECT_EQ(failed, 0u) << row.loss;
    }
}

// Blocking code in the device's interrupt: questions that arrive while it sends an answer are lost.
TEST(Host, sends_one_request_at_a_time_to_a_device_that_loses_requests_while_answering) {
    using namespace std::chrono_literals;
    FakeDevice fake;
    fake.make_parameters(121);
    Device device{0xDC};
    Parameters first{device}, second{device};
    Simulation simulation{device, fake, {.delay = 1ms, .baud = 115200}};
    simulation.blocks = true;
    first.read_all(simulation.now);
    simulation.run(first);
    ASSERT_TRUE(first.end());
    EXPECT_EQ(first.end()->ending, Ending::done) << first.end()->fault.text();
    EXPECT_EQ(device.window(), 1u);
    const std::size_t sent = simulation.frames_there;
    second.read_all(simulation.now);
    const ano::Duration took = simulation.run(second);
    EXPECT_EQ(second.end()->ending, Ending::done);
    EXPECT_LE(simulation.frames_there - sent, 3 + 2 * 121 + 5u) << "hardly anything is lost any more";
    EXPECT_LE(took, 4s);
}

TEST(Host, does_not_limit_requests_to_one_on_a_line_with_random_loss) {
    using namespace std::chrono_literals;
    FakeDevice fake;
    fake.make_parameters(121);
    Device device{0xDC};
    Parameters parameters{device};
    Simulation simulation{device, fake, {.delay = 1ms, .loss = 0.3}, 3};
    parameters.read_all(simulation.now);
    simulation.run(parameters);
    ASSERT_TRUE(parameters.end());
    EXPECT_EQ(parameters.end()->ending, Ending::done) << parameters.end()->fault.text();
    EXPECT_GT(device.window(), 1u);
}

// `rate=30`: a question waits up to three seconds before it is sent.
TEST(Host, does_not_count_time_in_the_send_queue_as_waiting_for_an_answer) {
    using namespace std::chrono_literals;
    FakeDevice fake;
    fake.make_parameters(10);
    Device device{0xDC};
    Parameters parameters{device};
    Simulation simulation{device, fake, {.delay = 1ms}};
    simulation.queue_rate = 30;
    parameters.read_all(simulation.now);
    simulation.run(parameters);
    ASSERT_TRUE(parameters.end());
    EXPECT_EQ(parameters.end()->ending, Ending::done) << parameters.end()->fault.text();
    EXPECT_EQ(simulation.frames_there, 3u + 2 * 10) << "nothing is asked twice";
    ASSERT_TRUE(device.round_trip().smoothed());
    EXPECT_LE(*device.round_trip().smoothed(), 10ms);
}

TEST(Host, a_firmware_of_256_kib_at_500000_baud_takes_at_most_1_15_times_the_wire_time) {
    FakeDevice fake;
    support::FakeLoader loader;
    fake.instead = [&](ano::FrameView frame) { return loader.take(fake, frame); };
    Device device{0xDC};
    FirmwareImage image;
    const support::Bytes bytes(std::size_t{256} << 10, 0x5A);
    image.bytes = bytes;
    image.crc = ano::crc16_of(bytes);
    Firmware upgrade{device, image};
    Simulation simulation{device, fake, {.delay = std::chrono::microseconds{100}, .baud = 500000}};
    upgrade.start(simulation.now);
    const ano::Duration took = simulation.run(upgrade);
    ASSERT_TRUE(upgrade.end());
    ASSERT_EQ(upgrade.end()->ending, Ending::done) << upgrade.end()->fault.text();
    EXPECT_EQ(upgrade.repeats(), 0u);
    const auto wire = std::chrono::nanoseconds{(simulation.bytes_there + simulation.bytes_back) * 10'000'000'000 / 500000};
    RecordProperty("ratio", std::to_string(ratio(took, wire)));
    EXPECT_LE(ratio(took, wire), 1.15);
}

TEST(Host, reads_all_parameters_over_any_line_or_reports_the_missing_ones) {
    using namespace std::chrono_literals;
    for (std::uint64_t seed = 1; seed <= support::trials(300); ++seed) {
        support::Random random{seed};
        const LineFaults line{std::chrono::milliseconds{random.below(800u)}, std::chrono::milliseconds{random.below(400u)},
                              random.below(60u) / 100.0, random.below(50u) / 100.0, random.of({0u, 9600u, 115200u})};
        FakeDevice fake;
        fake.make_parameters(random.below(40u));
        Device device{0xDC};
        Parameters parameters{device};
        Simulation simulation{device, fake, line, seed};
        parameters.read_all(simulation.now);
        const ano::Duration took = simulation.run(parameters);
        ASSERT_TRUE(parameters.end()) << "seed " << seed;
        EXPECT_LT(took, 10min) << "seed " << seed;
        EXPECT_LE(simulation.most_on_their_way, Window::max_size);
        EXPECT_FALSE(fake.crashed);
        if (parameters.end()->ending != Ending::done) continue;
        for (std::uint16_t id = 0; id < fake.parameters.size(); ++id) {
            const auto bytes = parameters.bytes(id);
            EXPECT_TRUE(
                std::equal(bytes.begin(), bytes.end(), fake.parameters[id].value.begin(), fake.parameters[id].value.end()));
        }
    }
}

// Each kind of task with a device that answers partly, over a faulty line, among random frames that look like answers.
TEST(Host, random_frames_at_random_times_never_hang_a_task) {
    for (std::uint64_t seed = 1; seed <= support::trials(100 * support::task_kinds); ++seed) {
        support::Random random{seed};
        FakeDevice fake;
        support::FakeLoader loader;
        fake.make_parameters(12);
        fake.commands.resize(3);
        fake.waypoints.resize(4, support::Bytes(22));
        fake.instead = [&](ano::FrameView frame) -> std::optional<std::vector<support::Bytes>> {
            if (random.one_in(6)) return std::vector<support::Bytes>{};
            return loader.take(fake, frame);
        };
        Device device{0xDC};
        Simulation simulation{
            device, fake, {.delay = std::chrono::milliseconds{5}, .jitter = std::chrono::milliseconds{30}, .loss = 0.2}, seed};
        simulation.each_step = [&](ano::TimePoint now) {
            support::Bytes data(random.below(40u));
            for (auto& byte : data) byte = random.one_in(2) ? random.byte() : std::uint8_t(random.below(4u));
            const auto frame = support::frame(
                random.of<std::uint8_t>({0xDC, 0xDC, 0xFE, 0}), random.of<std::uint8_t>({0xFE, 0xFF, 1}),
                random.of<std::uint8_t>({0x00, 0x60, 0x61, 0xE0, 0xE1, 0xE2, 0xE3, 0xC1, 0xC2, 0xF0}), data);
            if (random.one_in(4)) device.take(ano::FrameView{frame}, now);
        };
        const auto task = support::task_of(static_cast<unsigned>(seed), device, simulation.now);
        const ano::Duration took = simulation.run(*task, std::chrono::hours{2});
        EXPECT_TRUE(task->end()) << "seed " << seed;
        EXPECT_LT(took, std::chrono::minutes{30}) << "seed " << seed;
        EXPECT_LE(simulation.most_on_their_way, Window::max_size);
        const auto calls = std::count_if(fake.heard.begin(), fake.heard.end(),
                                         [](const support::Bytes& f) { return f[3] == 0xC0; });
        EXPECT_LE(calls, 1) << "a command is sent once";
    }
}

// For any faults of the line: values of a successful apply are stored, and those of a failed one are as before.
TEST(Host, an_apply_with_rollback_stores_all_or_nothing_or_reports_the_difference) {
    using namespace std::chrono_literals;
    for (std::uint64_t seed = 1; seed <= support::trials(200); ++seed) {
        support::Random random{seed};
        FakeDevice fake;
        fake.make_parameters(20);
        const auto old = fake.parameters;
        const std::size_t stubborn = 1 + 10 * random.below(2u);    // keeps its value
        if (random.one_in(2))
            fake.parameters[stubborn].store = [&, stubborn](const support::Bytes&) { return old[stubborn].value; };
        Device device{0xDC};
        Simulation simulation{
            device, fake, {.delay = 20ms, .jitter = 60ms, .loss = random.below(35u) / 100.0, .duplicate = 0.2}, seed};
        ParameterApply apply{
            device,
            nullptr,
            {{"PAR_0", std::int64_t{77}}, {"PAR_11", std::int64_t{-3}}, {"PAR_1", std::int64_t{-4}}, {"PAR_18", 0.25}},
            {.rollback = true}};
        apply.start(simulation.now);
        simulation.run(apply);
        ASSERT_TRUE(apply.end()) << "seed " << seed;
        simulation.pass(10s);    // the frames still on the line
        for (const auto& row : apply.rows()) {
            const auto id = static_cast<std::size_t>(std::stoi(row.name.substr(4)));
            const auto now = value_of(fake.parameters[id].value, *ano::parameter_type(fake.parameters[id].type));
            const auto before = value_of(old[id].value, *ano::parameter_type(old[id].type));
            const bool is_done = apply.end()->ending == Ending::done;
            const bool is_back = row.state == ParameterApply::State::undone || row.state == ParameterApply::State::waiting;
            EXPECT_TRUE(!is_done || now == row.wanted) << "seed " << seed << ' ' << row.name;
            EXPECT_TRUE(is_done || !is_back || now == before) << "seed " << seed << ' ' << row.name;
        }
    }
}

}    // namespace
}    // namespace host_tests
