// Waypoints: read, written, read back.
#include <host/waypoints.hpp>

#include <support/fake_device.hpp>

#include <gtest/gtest.h>

namespace ano::host::waypoints_tests {
namespace {

using support::Bytes;
using support::FakeDevice;
using support::Simulation;

struct WaypointsOf : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = std::chrono::milliseconds{10}}};
    const std::vector<Waypoint> route{{0, 113.5, 22.25, 0, 0, 0, 0, {}}, {1, 113.6, 22.3, 1500, 500, 400, 2, {1, 2, 3, 4}}};

    End put(std::vector<Waypoint> all) {
        WaypointsPut task{device, std::move(all)};
        task.start(simulation.now);
        simulation.run(task);
        return task.end().value_or(End{Ending::cancelled, {"other", "never ended"}, {}});
    }
    std::vector<Waypoint> get() {
        WaypointsGet task{device};
        task.start(simulation.now);
        simulation.run(task);
        EXPECT_TRUE(task.end());
        EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
        return task.waypoints();
    }
};

TEST_F(WaypointsOf, a_device_are_written_and_read) {
    EXPECT_EQ(put(route).ending, Ending::done);
    EXPECT_EQ(get(), route);
}

TEST_F(WaypointsOf, a_device_without_waypoints_are_an_empty_list) { EXPECT_TRUE(get().empty()); }

TEST_F(WaypointsOf, an_online_device_that_stores_none_time_out_without_a_report_of_silence) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        return std::vector<Bytes>{fake.to_host(f, 0x03, Bytes(7))};
    };
    WaypointsGet get{device};
    get.start(simulation.now);
    simulation.run(get);
    EXPECT_EQ(
        get.end()->fault.text(),
        "0xDC is online, but did not answer the request for its number of waypoints, sent 30 times; it probably stores none");
    EXPECT_EQ(put(route).fault.text(),
              "0xDC is online, but did not acknowledge: write of waypoint 0, sent 6 times; it probably stores no more, or none");
    fake.deaf = true;
    simulation.pass(std::chrono::seconds{1});
    EXPECT_EQ(put(route).fault.text(), "0xDC does not answer: write of waypoint 0, sent 6 times");
}

TEST_F(WaypointsOf, a_device_are_compared_after_the_rounding_of_the_protocol) {
    const End end = put({{0, 113.123456789, 22.0, 0, 0, 0, 0, {}}});
    EXPECT_EQ(end.ending, Ending::done);
    EXPECT_EQ(end.fault.text(), "");
}

TEST_F(WaypointsOf, a_device_that_are_stored_differently_or_remain_are_reported) {
    fake.waypoints.assign(5, Bytes(22));
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0x61 && f.data()[0] == 1) {
            auto answers = fake.usual(f);
            fake.waypoints[1][9] = 7;    // the height
            return answers;
        }
        return std::nullopt;
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::done);
    EXPECT_EQ(end.fault.text(), "1 of them were stored differently (1), and 0xDC has 5, the last 3 are its old ones");
}

TEST_F(WaypointsOf, a_device_that_acknowledges_all_and_stores_none_fail) {
    fake.waypoints.clear();
    for (std::uint8_t num = 0; num < 2; ++num) fake.waypoints.push_back(support::operator+(Bytes{num}, Bytes(21)));
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0x61) return std::nullopt;
        return std::vector<Bytes>{fake.check(f)};
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::failed);
    EXPECT_EQ(end.fault.text(), "0xDC acknowledged all waypoints but stored none of them as written: 0, 1");
}

TEST_F(WaypointsOf, an_impossible_position_are_never_sent) {
    EXPECT_EQ(put({route[0], {1, 181, 0, 0, 0, 0, 0, {}}}).ending, Ending::invalid);
    EXPECT_EQ(put({{0xFF, 1, 0, 0, 0, 0, 0, {}}}).ending, Ending::invalid);
    EXPECT_EQ(put({{1, 1, -90.5, 0, 0, 0, 0, {}}}).ending, Ending::invalid);
    EXPECT_EQ(put({{1, 1, std::numeric_limits<double>::quiet_NaN(), 0, 0, 0, 0, {}}}).ending, Ending::invalid);
    EXPECT_TRUE(fake.heard.empty());
}

TEST_F(WaypointsOf, a_device_that_acknowledges_but_does_not_return_them_are_refused) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0x60) return std::vector<Bytes>{};
        return std::nullopt;
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::refused);
    EXPECT_EQ(end.fault.text(), "0xDC acknowledged waypoint 0 but does not return it");
}

TEST_F(WaypointsOf, a_device_that_acknowledges_with_wrong_check_bytes_are_read_back_and_reported) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0x61) return std::nullopt;
        fake.usual(f);
        return std::vector<Bytes>{fake.to_host(f, 0x00, {0x61, 1, 2})};
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::done) << end.fault.text();
    EXPECT_EQ(end.fault.text(), "2 of them were acknowledged with wrong check bytes but are stored");
}

// It writes flash for each waypoint, and receives nothing meanwhile.
TEST_F(WaypointsOf, a_device_that_acknowledges_3_s_late_are_still_written) {
    get();    // the round trip is known: 20 ms
    std::optional<TimePoint> busy_until;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        simulation.back.delay = std::chrono::milliseconds{10};
        if (busy_until && simulation.now < *busy_until) return std::vector<Bytes>{};
        if (f.id() != 0x61) return std::nullopt;
        busy_until = simulation.now + std::chrono::milliseconds{2950};
        simulation.back.delay = std::chrono::seconds{3};
        return std::nullopt;
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::done) << end.fault.text();
    fake.instead = nullptr;
    EXPECT_EQ(get(), route);
}

TEST_F(WaypointsOf, a_device_that_does_not_acknowledge_are_read_back) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0x61) return std::nullopt;
        fake.usual(f);
        return std::vector<Bytes>{};
    };
    const TimePoint begin = simulation.now;
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::done) << end.fault.text();
    EXPECT_EQ(end.fault.text(), "2 of them were not acknowledged but are stored");
    EXPECT_LT(simulation.now - begin, std::chrono::seconds{5});
    EXPECT_EQ(fake.waypoints.size(), 2u);
}

TEST_F(WaypointsOf, a_device_that_neither_acknowledges_nor_stores_time_out) {
    fake.waypoints.assign(2, Bytes(22));
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0x61) return std::nullopt;
        return std::vector<Bytes>{};
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::timeout);
    EXPECT_EQ(end.fault.text().substr(0, 60), "0xDC is online, but did not acknowledge: write of waypoint 0") << end.fault.text();
}

TEST_F(WaypointsOf, a_device_that_are_lost_by_a_restart_are_reported) {
    std::vector<Waypoint> long_route;
    for (std::uint8_t num = 0; num < 5; ++num) long_route.push_back({num, 113.5, 22.0 + num, 0, 0, 0, 0, {}});
    bool is_restarted = false;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0x61 || f.data()[0] != 3 || std::exchange(is_restarted, true)) return std::nullopt;
        fake.waypoints.clear();
        return std::vector<Bytes>{};    // this one is lost
    };
    const End end = put(long_route);
    EXPECT_EQ(end.ending, Ending::failed);
    EXPECT_EQ(end.fault.text(), "0xDC did not keep these waypoints (it has probably restarted): 0, 1, 2");
}

// It restarts between a write and its read-back, so fast that there is no sign: the read-back is answered from its old list.
TEST_F(WaypointsOf, a_device_that_are_lost_by_a_short_restart_are_all_reported) {
    std::vector<Waypoint> long_route;
    for (std::uint8_t num = 0; num < 6; ++num) long_route.push_back({num, 113.5, 22.0 + num, 0, 0, 0, 0, {}});
    for (const std::uint8_t at : {std::uint8_t{3}, std::uint8_t{5}}) {
        fake.waypoints.clear();
        for (std::uint8_t num = 0; num < 9; ++num) fake.waypoints.push_back(support::operator+(Bytes{num}, Bytes(21)));
        bool is_restarted = false;
        fake.instead = [&, old = fake.waypoints](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() != 0x61 || f.data()[0] != at || std::exchange(is_restarted, true)) return std::nullopt;
            auto answers = fake.usual(f);
            fake.waypoints = old;
            return answers;
        };
        WaypointsPut task{device, long_route};
        task.start(simulation.now);
        simulation.run(task);
        ASSERT_TRUE(task.end());
        EXPECT_EQ(task.end()->ending, Ending::failed);
        EXPECT_EQ(task.end()->fault.text(), std::string{"0xDC did not keep these waypoints (it has probably restarted): "} +
                                                (at == 3 ? "0, 1, 2" : "0, 1, 2, 3, 4"));
        EXPECT_EQ(task.progress().done, at == 3 ? 3u : 1u) << "the one that was read back otherwise is written again";
    }
}

// The rest of the list is unchanged, so that only the read-back shows it.
TEST_F(WaypointsOf, a_device_that_are_read_back_differently_are_written_once_more) {
    for (const std::size_t size : {1u, 2u}) {
        const std::vector<Waypoint> wanted{route.begin(), route.begin() + static_cast<std::ptrdiff_t>(size)};
        fake.waypoints.clear();
        for (std::uint8_t num = 0; num < 2; ++num) fake.waypoints.push_back(support::operator+(Bytes{num}, Bytes(21)));
        bool is_restarted = false;
        fake.instead = [&, old = fake.waypoints](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() != 0x61 || std::exchange(is_restarted, true)) return std::nullopt;
            auto answers = fake.usual(f);
            fake.waypoints = old;
            return answers;
        };
        const End end = put(wanted);
        EXPECT_EQ(end.ending, Ending::done) << end.fault.text();
        EXPECT_EQ(get()[0], route[0]);
        EXPECT_EQ(end.fault.text().find("otherwise"), std::string::npos) << end.fault.text();
    }
}

// An earlier answer that arrives late is not a sign that the list is lost: the list read at the end decides.
TEST_F(WaypointsOf, a_device_are_not_reported_as_lost_by_a_late_answer_from_before_the_write) {
    for (const std::size_t size : {1u, 2u}) {
        const std::vector<Waypoint> wanted{route.begin(), route.begin() + static_cast<std::ptrdiff_t>(size)};
        fake.waypoints.assign(size, Bytes(22));
        fake.waypoints.back()[0] = static_cast<std::uint8_t>(size - 1);
        unsigned stale = 2;    // also the one after the second write
        fake.instead = [&, old = fake.waypoints.back()](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() != 0x60 || f.data()[0] != size - 1 || stale == 0) return std::nullopt;
            --stale;
            return std::vector<Bytes>{fake.to_host(f, 0x61, old)};
        };
        WaypointsPut task{device, wanted};
        task.start(simulation.now);
        simulation.run(task);
        ASSERT_TRUE(task.end());
        EXPECT_EQ(task.end()->ending, Ending::done) << task.end()->fault.text();
        EXPECT_EQ(task.end()->fault.text(), "") << "neither lost nor stored otherwise";
        EXPECT_EQ(task.progress().done, size);
        EXPECT_EQ(task.stored().size(), size);
        EXPECT_EQ(get(), wanted);
    }
}

TEST_F(WaypointsOf, a_device_that_are_lost_after_the_read_back_are_reported) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0x60 && f.data()[0] == 0xFF) fake.waypoints[0][9] = 1;
        return std::nullopt;
    };
    const End end = put(route);
    EXPECT_EQ(end.ending, Ending::failed);
    EXPECT_EQ(end.fault.text(), "0xDC did not keep these waypoints (it has probably restarted): 0");
}

TEST_F(WaypointsOf, a_device_on_a_lossy_line_are_not_reported_as_lost_by_a_restart) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        fake.waypoints.clear();
        Device other{0xDC};
        Simulation bad{other, fake, {.delay = std::chrono::milliseconds{20}, .loss = 0.1}, seed};
        WaypointsPut task{other, route};
        task.start(bad.now);
        bad.run(task);
        ASSERT_TRUE(task.end());
        EXPECT_EQ(task.end()->ending, Ending::done) << "seed " << seed << ": " << task.end()->fault.text();
    }
}

TEST_F(WaypointsOf, a_cancelled_write_are_counted_up_to_the_last_one_written) {
    WaypointsPut task{device, route};
    simulation.each_step = [&](TimePoint now) {
        if (task.progress().done == 1) task.cancel(now);
    };
    task.start(simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->fault.text(), "1 of 2 waypoints are written");
}

}    // namespace
}    // namespace ano::host::waypoints_tests
