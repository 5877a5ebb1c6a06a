// Both engines, on a line that loses up to a third of the frames: the result that the host reports for an exchange is true.
#include <device/device.hpp>
#include <host/commands.hpp>
#include <host/firmware.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace host_and_device_tests {

namespace {

using namespace std::chrono_literals;
using ano::host::Ending;
using support::Bytes;
using support::Random;

constexpr std::uint64_t seeds = 60;

ano::device::Profile any_profile(Random& random) {
    auto profile = random.of({ano::device::Profile{}, ano::device::Profile::vendor()});
    profile.refuses_beyond_limits = random.one_in(3);
    return profile;
}

// A host, a device, and the line between them, in simulated time.
struct Line {
    explicit Line(std::uint64_t seed) : random{seed}, device{{.id = 0x21, .name = "thing"}, any_profile(random)} {}

    void put(ano::FrameView frame, bool to_device) {
        if (random.below(100u) < loss) return;
        on_their_way.emplace(now + delay, std::pair{to_device, Bytes(frame.bytes().begin(), frame.bytes().end())});
    }
    void arrive() {
        while (!on_their_way.empty() && on_their_way.begin()->first <= now) {
            const auto [to_device, frame] = on_their_way.begin()->second;
            on_their_way.erase(on_their_way.begin());
            if (to_device) device.take(ano::FrameView{frame}, now);
            else host.take(ano::FrameView{frame}, now);
        }
    }
    Ending run(const ano::host::Task& task) {
        const auto end = now + 30min;
        while (!task.end() && now < end) {
            while (const auto frame = host.next_frame(now)) put(*frame, true);
            if (task.end()) break;
            while (const auto out = device.next()) put(out->frame, false);
            auto next = end;
            if (const auto due = host.due()) next = std::min(next, *due);
            if (const auto due = device.due()) next = std::min(next, *due);
            if (!on_their_way.empty()) next = std::min(next, on_their_way.begin()->first);
            now = std::max(now, next);
            device.run(now);
            arrive();
        }
        EXPECT_TRUE(task.end()) << "it goes on for ever";
        const Ending ending = task.end() ? task.end()->ending : Ending::failed;
        ++ends[ending];
        return ending;
    }

    Random random;
    unsigned loss = random.below(30u);    // %
    ano::Duration delay = std::chrono::milliseconds{random.below(60u)};
    ano::device::Device device;
    ano::host::Device host{0x21};
    std::multimap<ano::TimePoint, std::pair<bool, Bytes>> on_their_way;
    ano::TimePoint now{1000s};
    std::map<Ending, int> ends;
};

struct Values {
    explicit Values(ano::device::Parameters& parameters) {
        parameters.add("A", a, {.info = "", .min = 1, .max = 100});
        parameters.add("B", b);
        parameters.add("C", c);
        parameters.add("D", d, {.info = "", .min = -1, .max = 1});
        parameters.add("E", e);
        parameters.add("F", f);
    }
    std::uint8_t a = 1;
    std::int16_t b = -2;
    std::uint64_t c = 3;
    float d = 0.5f;
    double e = 0.25;
    std::string f = "text";
};

ano::host::AnyValue any_value(Random& random, const ano::device::Value& like) {
    ano::host::AnyValue value = like;
    std::visit(
        [&]<class V>(V& v) {
            if constexpr (std::is_same_v<V, std::string>) v = random.of<std::string>({"a", "abc", "z"});
            else v = static_cast<V>(random.below(200));
        },
        value);
    return value;
}

// Done: the device has that value, or the nearest permitted one. Refused: the value is unchanged, or it can't be read.
void write_and_compare(Line& line, const ano::host::ParameterInfo& info) {
    const auto& row = line.device.parameters()[info.id];
    const ano::device::Value before = row.get();
    const ano::host::AnyValue wanted = any_value(line.random, before);
    ano::host::ParameterWrite write{line.host, info, wanted, {.longer = true, .max_bytes = {}}};
    write.start(line.now);
    const Ending ending = line.run(write);
    const ano::device::Value after = row.get();
    if (ending == Ending::done) {
        EXPECT_EQ(write.stored(), after);
        EXPECT_EQ(write.is_clamped(), after != wanted);
    } else if (ending == Ending::refused) {
        EXPECT_TRUE(after == before || !write.stored()) << write.end()->fault.text();
    } else {
        EXPECT_EQ(ending, Ending::timeout) << write.end()->fault.text();
    }
}

TEST(HostAndDevice, agree_on_parameters) {
    int done = 0, timed_out = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        Line line{seed};
        Values values{line.device.parameters()};
        ano::host::Parameters all{line.host};
        all.read_all(line.now);
        if (line.run(all) != Ending::done) continue;
        ASSERT_EQ(all.descriptions().size(), line.device.parameters().count());
        for (const auto& info : all.descriptions()) {
            const auto& row = line.device.parameters()[info.id];
            EXPECT_EQ(info.name, row.name);
            EXPECT_EQ(info.type, row.type);
            EXPECT_EQ(all.value(info.id), row.get());
        }
        for (int i = 0; i < 8; ++i) write_and_compare(line, all.descriptions()[line.random.below(6u)]);
        EXPECT_FALSE(line.device.crashed());
        ASSERT_FALSE(HasFailure());
        done += line.ends[Ending::done];
        timed_out += line.ends[Ending::timeout];
    }
    EXPECT_GT(done, 10 * timed_out);
}

// A command that must not be repeated is carried out at most once; "done" means once.
TEST(HostAndDevice, agree_on_commands) {
    int done = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        Line line{seed};
        int runs = 0;
        line.device.commands().add({1, 2, 3}, "GO", "", [&](std::uint8_t, float x) {
            ++runs;
            return x < 5;
        });
        ano::host::Commands all{line.host, line.device.profile().value_type_7};
        all.read(line.now);
        if (line.run(all) != Ending::done) continue;
        ASSERT_EQ(all.descriptions().size(), 1u);
        for (const double x : {1.0, 9.0}) {
            runs = 0;
            ano::host::CommandCall call{line.host, all.descriptions()[0], {std::int64_t{7}, x}};
            call.start(line.now);
            const Ending ending = line.run(call);
            ASSERT_LE(runs, 1);
            if (ending == Ending::done) {
                ASSERT_EQ(std::pair(runs, x), std::pair(1, 1.0));
            } else {
                ASSERT_EQ(ending, Ending::unknown) << call.end()->fault.text();
            }
        }
        done += line.ends[Ending::done] - 1;
    }
    EXPECT_GT(done, 30);
}

TEST(HostAndDevice, agree_on_waypoints) {
    int done = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        Line line{seed};
        line.device.waypoints().allow(20);
        std::vector<ano::host::Waypoint> route;
        for (std::uint8_t i = 0; i < 10; ++i)
            route.push_back(
                {.num = i, .lng = 1.5 * i, .lat = -2.25 * i, .alt = 100 * i, .spd = 5, .yaw = 400, .fun = 1, .cmd = {}});
        ano::host::WaypointsPut put{line.host, route};
        put.start(line.now);
        if (line.run(put) != Ending::done) continue;
        ASSERT_EQ(line.device.waypoints().count(), route.size());
        ASSERT_EQ(put.stored(), route);
        ano::host::WaypointsGet get{line.host};
        get.start(line.now);
        if (line.run(get) != Ending::done) continue;
        ++done;
        ASSERT_EQ(get.waypoints(), route);
    }
    EXPECT_GT(done, 40);
}

TEST(HostAndDevice, agree_on_firmware) {
    int done = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        Line line{seed};
        Bytes image(1 + line.random.below(5000u));
        for (auto& byte : image) byte = line.random.byte();
        Bytes installed;
        ano::device::Flash flash;
        flash.max_size = 8000;
        flash.install = [&](const ano::device::Image& whole) {
            installed.assign(whole.bytes.begin(), whole.bytes.end());
            return true;
        };
        flash.erase_time = 3s;
        flash.check_time = 1s;
        line.device.firmware().allow(flash);
        const auto file = ano::host::read_firmware(image);
        ASSERT_TRUE(file.image);
        ano::host::Firmware upgrade{line.host, *file.image};
        upgrade.start(line.now);
        const Ending ending = line.run(upgrade);
        done += ending == Ending::done;
        if (ending == Ending::done) {
            ASSERT_EQ(installed, image);
        } else {
            ASSERT_EQ(ending, Ending::timeout) << upgrade.end()->fault.text() << ", " << line.loss << " % are lost";
        }
    }
    EXPECT_GT(done, 20);
}

}    // namespace
}    // namespace host_and_device_tests
