// A V8 host, the translation, and a simulated V7 device behind a line that loses frames: the host reads, writes and commands it
// like a V8 device.
#include <gateway/v7_translation.hpp>
#include <host/commands.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>

#include <ano/frame.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>
#include <world/faulty_line.hpp>
#include <world/kinds.hpp>
#include <world/lx_unit.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace v7_host_tests {

using namespace std::chrono_literals;
using ano::host::Ending;
using support::Bytes;
using support::Random;
namespace v7 = ano::v7;

namespace {

constexpr std::uint8_t imu = 0xDD;

// Host and translation are one computer; the line from there to the device loses frames in both directions.
struct V7Line final : anogate::V7Output {
    V7Line(std::uint64_t seed, std::vector<anogate::V7Parameter> table, unsigned loss = 0)
        : random{seed},
          translation{settings_with(std::move(table))},
          line{ano::world::make_device("lx", {0, 50, seed}, start), {.loss = loss, .delay = 5ms}, seed, start} {}
    static anogate::V7Settings settings_with(std::vector<anogate::V7Parameter> table) {
        anogate::V7Settings settings{.address = imu};
        settings.parameters = std::move(table);
        return settings;
    }

    ano::world::LxUnit& device() { return static_cast<ano::world::LxUnit&>(line.device()); }
    void to_device(v7::FrameView frame) override {
        commands_sent += frame.id() == 0xE0;
        to_line.emplace_back(frame.bytes().begin(), frame.bytes().end());
    }
    void from_device(ano::FrameView frame) override { to_host.emplace_back(frame.bytes().begin(), frame.bytes().end()); }
    void exchange() {
        while (!to_line.empty() || !to_host.empty()) {
            for (const Bytes& frame : std::exchange(to_line, {})) line.take(ano::Bytes{frame}, now, receive);
            for (const Bytes& frame : std::exchange(to_host, {})) host.take(ano::FrameView{frame}, now);
        }
    }
    void send(const Bytes& v8) {
        translation.down(ano::FrameView{v8}, now, *this);
        exchange();
    }
    Ending run(const ano::host::Task& task) {
        const auto end = now + 30min;
        while (!task.end() && now < end) {
            while (const auto frame = host.next_frame(now)) {
                const Bytes bytes{frame->bytes().begin(), frame->bytes().end()};
                commands_of_host += bytes[3] == 0xC0;
                send(bytes);
            }
            if (task.end()) break;
            auto next = std::min(end, line.due());
            for (const auto due : {host.due(), translation.deadline()})
                if (due) next = std::min(next, *due);
            wait_until(next);
        }
        EXPECT_TRUE(task.end()) << "it never ends";
        return task.end() ? task.end()->ending : Ending::failed;
    }
    void wait_until(ano::TimePoint then) {
        now = std::max(now, then);
        translation.expire(now, *this);
        line.run(now, receive);
        exchange();
    }
    void run_for(ano::Duration time) {
        for (const auto end = now + time; now < end;) wait_until(std::min(end, line.due()));
    }

    static constexpr ano::TimePoint start{1000s};
    Random random;
    anogate::V7Translation translation;
    ano::world::FaultyLine line;
    ano::host::Device host{imu};
    std::vector<Bytes> to_line, to_host;
    std::size_t commands_sent = 0, commands_of_host = 0;
    ano::TimePoint now = start;
    const ano::world::FaultyLine::Send receive = [this](ano::Bytes bytes, ano::TimePoint) {
        if (const auto frame = v7::frame_at(bytes)) translation.up(*frame, now, *this);
    };
};

class AnyLoss : public testing::TestWithParam<unsigned> {};    // %

TEST_P(AnyLoss, parameters_are_read_and_written) {
    for (std::uint64_t seed = 0; seed < support::trials(5); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, seed % 2 == 0 ? anogate::v7_lx_parameters() : anogate::v7_tkz_parameters(), GetParam()};
        ano::host::Parameters all{line.host};
        all.read_all(line.now);
        ASSERT_EQ(line.run(all), Ending::done) << all.end()->fault.text();
        const auto& rows = line.translation.settings().parameters;
        ASSERT_EQ(all.descriptions().size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto& info = all.descriptions()[i];
            EXPECT_EQ(info.name, rows[i].name);
            const auto value = all.value(info.id);
            ASSERT_TRUE(value) << info.name;
            EXPECT_TRUE(rows[i].as_f32 || std::get<std::int64_t>(*value) == line.device().parameter(rows[i].number)) << info.name;
        }
        if (seed % 2 != 0) continue;    // an LX IMU has the other numbers, but not these
        for (std::size_t k = 4; k < 14; k += 3) {
            const auto wanted = static_cast<std::int64_t>(line.random.below(100000u));
            ano::host::ParameterWrite write{line.host, all.descriptions()[k], wanted, {}};
            write.start(line.now);
            ASSERT_EQ(line.run(write), Ending::done) << write.end()->fault.text();
            EXPECT_EQ(line.device().parameter(rows[k].number), wanted);
        }
        EXPECT_EQ(line.device().false_measurements(), 0u);
    }
}

TEST_P(AnyLoss, parameters_without_a_table_are_read_and_written_by_number) {
    for (std::uint64_t seed = 0; seed < support::trials(5); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, {}, GetParam()};
        ano::host::Parameters some{line.host};
        line.host.ask_by_number(true);
        some.accept_unlisted({151, 9999, 162});
        some.read_numbered({}, line.now);
        ASSERT_EQ(line.run(some), Ending::done) << some.end()->fault.text();
        for (const std::uint16_t number : {std::uint16_t{151}, std::uint16_t{162}}) {
            ASSERT_TRUE(some.value(number)) << number;
            EXPECT_EQ(std::get<std::int64_t>(*some.value(number)), line.device().parameter(number));
        }
        EXPECT_FALSE(some.descriptions()[9999].type) << "the device has no such number";
        ano::host::ParameterWrite write{line.host, some.descriptions()[151], std::int64_t{77}, {}};
        write.start(line.now);
        ASSERT_EQ(line.run(write), Ending::done) << write.end()->fault.text();
        EXPECT_EQ(line.device().parameter(151), 77);
    }
}

TEST_P(AnyLoss, each_command_is_described_and_sent_as_often_as_the_host_sends_it) {
    int done = 0, calls = 0;
    for (std::uint64_t seed = 0; seed < support::trials(3); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, {}, GetParam()};
        ano::host::Commands all{line.host};
        all.read(line.now);
        ASSERT_EQ(line.run(all), Ending::done) << all.end()->fault.text();
        for (const auto& command : all.descriptions()) {
            SCOPED_TRACE(command.name);
            std::vector<ano::host::AnyValue> values;
            for (const auto type : command.types) values.emplace_back(std::int64_t{type == ano::Type::u8 ? 1 : 150});
            ano::host::CommandCall call{line.host, command, values};
            const std::size_t received = line.device().commands().size();
            call.start(line.now);
            const Ending ending = line.run(call);
            EXPECT_TRUE(ending == Ending::done || ending == Ending::unknown) << call.end()->fault.text();
            EXPECT_EQ(line.commands_sent, line.commands_of_host);
            ++calls;
            if (ending != Ending::done) continue;
            ++done;
            ASSERT_GT(line.device().commands().size(), received);
            const auto& data = line.device().commands().back();
            EXPECT_TRUE(std::equal(command.cid.begin(), command.cid.end(), data.begin()));
        }
        EXPECT_FALSE(line.device().is_erased());
        EXPECT_EQ(line.device().false_measurements(), 0u);
    }
    EXPECT_GE(done, GetParam() == 0 ? calls : calls / 2);
}

TEST_P(AnyLoss, waypoints_are_written_and_read) {
    for (std::uint64_t seed = 0; seed < support::trials(5); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, {}, GetParam()};
        std::vector<ano::host::Waypoint> route;
        for (std::uint8_t i = 0; i < 10; ++i)
            route.push_back(
                {.num = i, .lng = 1.5 * i, .lat = -2.25 * i, .alt = 100 * i, .spd = 5, .yaw = 400, .fun = 1, .cmd = {}});
        ano::host::WaypointsPut put{line.host, route};
        put.start(line.now);
        ASSERT_EQ(line.run(put), Ending::done) << put.end()->fault.text();
        ASSERT_EQ(line.device().waypoints(), route.size());
        ano::host::WaypointsGet get{line.host};
        get.start(line.now);
        ASSERT_EQ(line.run(get), Ending::done) << get.end()->fault.text();
        EXPECT_EQ(get.waypoints(), route);
    }
}

TEST(SimulatedV7, receives_the_commands_of_the_vectors) {
    std::size_t checked = 0;
    for (const auto& vector : support::v7_vectors("pair")) {
        if (vector.v7[2] != 0xE0) continue;
        SCOPED_TRACE(vector.meaning);
        V7Line line{1, {}};
        Bytes v8 = vector.v8;
        v8[2] = imu;
        ano::seal(v8);
        line.send(v8);
        line.run_for(20ms);
        ASSERT_EQ(line.device().commands().size(), 1u);
        const auto& data = line.device().commands()[0];
        EXPECT_TRUE(std::equal(data.begin(), data.end(), vector.v7.begin() + v7::header_size));
        ++checked;
    }
    EXPECT_GE(checked, 2u);
}

INSTANTIATE_TEST_SUITE_P(percent, AnyLoss, testing::Values(0, 10), [](const auto& test) { return std::to_string(test.param); });

}    // namespace
}    // namespace v7_host_tests
