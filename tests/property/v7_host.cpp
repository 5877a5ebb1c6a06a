// A V8 host, the translation, and a simulated V7 device behind a line that loses frames: the host reads, writes and commands it
// like a V8 device.
#include <gateway/v7_translation.hpp>
#include <host/commands.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>

#include <ano/wire.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace v7_host_tests {

using namespace std::chrono_literals;
using ano::host::Ending;
using support::Bytes;
using support::Random;
using support::v7_frame;
namespace v7 = ano::v7;

namespace {

constexpr std::uint8_t imu = 0xDD;

// Answers as a 拓空者 or an LX IMU does (protocol-v7.md, sections 5 and 6).
struct V7Device {
    std::map<std::uint16_t, std::int32_t> parameters;
    std::map<std::uint8_t, Bytes> waypoints;
    std::vector<Bytes> commands;

    std::vector<Bytes> take(v7::FrameView frame) {
        const Bytes data{frame.data().begin(), frame.data().end()};
        const Bytes check = v7_frame(0xAF, 0x00, {frame.id(), frame.checks().sum, frame.checks().add});
        switch (frame.id()) {
        case 0xE0: commands.push_back(data); return {check};
        case 0xE1: {
            const auto number = ano::load<std::uint16_t>(data.data());
            Bytes value{data[0], data[1], 0, 0, 0, 0};
            ano::store(value.data() + 2, parameters.contains(number) ? parameters[number] : INT32_MIN);
            return {v7_frame(0xAF, 0xE2, value)};
        }
        case 0xE2: parameters[ano::load<std::uint16_t>(data.data())] = ano::load<std::int32_t>(data.data() + 2); return {check};
        case 0x60:
            if (data[0] == 0xFF) return {v7_frame(0xAF, 0x60, {static_cast<std::uint8_t>(waypoints.size())})};
            if (!waypoints.contains(data[0])) return {};
            return {v7_frame(0xAF, 0x61, waypoints[data[0]])};
        case 0x61: waypoints[data[0]] = data; return {check};
        default: return {};
        }
    }
};

// Host and translation are one computer; the line from there to the device loses frames in both directions.
struct V7Line final : anogate::V7Output {
    V7Line(std::uint64_t seed, std::vector<anogate::V7Parameter> table)
        : random{seed}, translation{settings_with(std::move(table))} {
        for (const auto& row : translation.settings().parameters) device.parameters[row.number] = row.number * 3;
    }
    static anogate::V7Settings settings_with(std::vector<anogate::V7Parameter> table) {
        anogate::V7Settings settings{.address = imu};
        settings.parameters = std::move(table);
        return settings;
    }

    void to_device(v7::FrameView frame) override { put(frame.bytes(), true); }
    void from_device(ano::FrameView frame) override { to_host.emplace_back(frame.bytes().begin(), frame.bytes().end()); }
    void put(std::span<const std::uint8_t> bytes, bool is_to_device) {
        if (is_to_device && bytes[2] == 0xE0) ++commands_sent;
        if (random.below(100u) < loss) return;
        on_their_way.emplace(now + delay, std::pair{is_to_device, Bytes(bytes.begin(), bytes.end())});
    }
    void deliver_to_host() {
        while (!to_host.empty()) {
            const auto frames = std::move(to_host);
            to_host.clear();
            for (const Bytes& frame : frames) host.take(ano::FrameView{frame}, now);
        }
    }
    void arrive() {
        while (!on_their_way.empty() && on_their_way.begin()->first <= now) {
            const auto [is_to_device, bytes] = on_their_way.begin()->second;
            on_their_way.erase(on_their_way.begin());
            if (is_to_device)
                for (const Bytes& answer : device.take(v7::FrameView{bytes})) put(answer, false);
            else translation.up(v7::FrameView{bytes}, now, *this);
        }
        deliver_to_host();
    }
    Ending run(const ano::host::Task& task) {
        const auto end = now + 30min;
        while (!task.end() && now < end) {
            while (const auto frame = host.next_frame(now)) {
                const Bytes bytes{frame->bytes().begin(), frame->bytes().end()};
                if (bytes[3] == 0xC0) ++commands_of_host;
                translation.down(ano::FrameView{bytes}, now, *this);
                deliver_to_host();
            }
            if (task.end()) break;
            auto next = end;
            for (const auto due : {host.due(), translation.deadline()})
                if (due) next = std::min(next, *due);
            if (!on_their_way.empty()) next = std::min(next, on_their_way.begin()->first);
            now = std::max(now, next);
            translation.expire(now, *this);
            arrive();
        }
        EXPECT_TRUE(task.end()) << "it never ends";
        return task.end() ? task.end()->ending : Ending::failed;
    }

    Random random;
    unsigned loss = 0;    // %
    ano::Duration delay = 5ms;
    V7Device device;
    anogate::V7Translation translation;
    ano::host::Device host{imu};
    std::multimap<ano::TimePoint, std::pair<bool, Bytes>> on_their_way;
    std::vector<Bytes> to_host;
    std::size_t commands_sent = 0, commands_of_host = 0;
    ano::TimePoint now{1000s};
};

class AnyLoss : public testing::TestWithParam<unsigned> {};    // %

TEST_P(AnyLoss, parameters_are_read_and_written) {
    for (std::uint64_t seed = 0; seed < support::trials(10); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, seed % 2 == 0 ? anogate::v7_lx_parameters() : anogate::v7_tkz_parameters()};
        line.loss = GetParam();
        ano::host::Parameters all{line.host};
        all.read_all(line.now);
        ASSERT_EQ(line.run(all), Ending::done) << all.end()->what;
        const auto& rows = line.translation.settings().parameters;
        ASSERT_EQ(all.descriptions().size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto& info = all.descriptions()[i];
            EXPECT_EQ(info.name, rows[i].name);
            const auto value = all.value(info.id);
            ASSERT_TRUE(value) << info.name;
            EXPECT_TRUE(rows[i].as_f32 || std::get<std::int64_t>(*value) == rows[i].number * 3) << info.name;
        }
        for (int i = 0; i < 5; ++i) {
            const std::size_t k = 4 + line.random.below(20u);
            const auto wanted = static_cast<std::int64_t>(line.random.below(100000u));
            ano::host::ParameterWrite write{line.host, all.descriptions()[k], wanted, {}};
            write.start(line.now);
            ASSERT_EQ(line.run(write), Ending::done) << write.end()->what;
            EXPECT_EQ(line.device.parameters[rows[k].number], wanted);
        }
    }
}

TEST_P(AnyLoss, commands_are_described_and_sent_as_often_as_the_host_sends_them) {
    int done = 0;
    for (std::uint64_t seed = 0; seed < support::trials(10); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, {}};
        line.loss = GetParam();
        ano::host::Commands all{line.host};
        all.read(line.now);
        ASSERT_EQ(line.run(all), Ending::done) << all.end()->what;
        const auto take_off = std::find_if(all.descriptions().begin(), all.descriptions().end(),
                                           [](const auto& command) { return command.name == "Take off"; });
        ASSERT_NE(take_off, all.descriptions().end());
        ano::host::CommandCall call{line.host, *take_off, {std::int64_t{150}}};
        call.start(line.now);
        const Ending ending = line.run(call);
        EXPECT_TRUE(ending == Ending::done || ending == Ending::unknown) << call.end()->what;
        EXPECT_EQ(line.commands_sent, line.commands_of_host);
        if (ending != Ending::done) continue;
        ++done;
        ASSERT_EQ(line.device.commands.size(), 1u);
        EXPECT_EQ(line.device.commands[0], support::hex("1000059600000000000000"));
    }
    EXPECT_GE(done, GetParam() == 0 ? 10 : 5);
}

TEST_P(AnyLoss, waypoints_are_written_and_read) {
    for (std::uint64_t seed = 0; seed < support::trials(10); ++seed) {
        SCOPED_TRACE(seed);
        V7Line line{seed, {}};
        line.loss = GetParam();
        std::vector<ano::host::Waypoint> route;
        for (std::uint8_t i = 0; i < 10; ++i)
            route.push_back(
                {.num = i, .lng = 1.5 * i, .lat = -2.25 * i, .alt = 100 * i, .spd = 5, .yaw = 400, .fun = 1, .cmd = {}});
        ano::host::WaypointsPut put{line.host, route};
        put.start(line.now);
        ASSERT_EQ(line.run(put), Ending::done) << put.end()->what;
        ASSERT_EQ(line.device.waypoints.size(), route.size());
        ano::host::WaypointsGet get{line.host};
        get.start(line.now);
        ASSERT_EQ(line.run(get), Ending::done) << get.end()->what;
        EXPECT_EQ(get.waypoints(), route);
    }
}

INSTANTIATE_TEST_SUITE_P(percent, AnyLoss, testing::Values(0, 10), [](const auto& test) { return std::to_string(test.param); });

}    // namespace
}    // namespace v7_host_tests
