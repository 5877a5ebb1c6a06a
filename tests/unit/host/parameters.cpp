// Reading the parameters of a device, from devices with and without faults.
#include <host/parameters.hpp>

#include <support/fake_device.hpp>

#include <gtest/gtest.h>

#include <set>

namespace ano::host::parameters_tests {
namespace {

using support::Bytes;
using support::FakeDevice;
using support::Simulation;

struct Reads : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    DescriptionCache cache;
    Parameters parameters{device, &cache};
    Simulation simulation{device, fake, {.delay = std::chrono::milliseconds{10}}};

    Ending read(Parameters::Values values = Parameters::Values::all) {
        parameters.read(values, simulation.now);
        simulation.run(parameters);
        return parameters.end() ? parameters.end()->ending : Ending::cancelled;
    }
    std::size_t heard(std::uint8_t id, std::uint8_t cmd) const {
        return static_cast<std::size_t>(
            std::count_if(fake.heard.begin(), fake.heard.end(), [&](const Bytes& f) { return f[3] == id && f[6] == cmd; }));
    }
};

TEST_F(Reads, all_types_with_their_values) {
    const std::vector<std::pair<std::uint8_t, AnyValue>> wanted{{0, std::int64_t{200}},
                                                                {1, std::int64_t{-5}},
                                                                {2, std::int64_t{40'000}},
                                                                {3, std::int64_t{-30'000}},
                                                                {4, std::int64_t{4'000'000'000}},
                                                                {5, std::int64_t{-2'000'000'000}},
                                                                {6, ~std::uint64_t{}},
                                                                {7, INT64_MIN},
                                                                {8, 0.5},
                                                                {9, 0.1},
                                                                {10, std::string{"text"}}};
    for (const auto& [type, value] : wanted) {
        Bytes wire;
        ASSERT_TRUE(append(wire, value, *parameter_type(type)).empty());
        fake.parameters.push_back({type, "P" + std::to_string(type), "info", wire});
    }
    ASSERT_EQ(read(), Ending::done);
    ASSERT_EQ(parameters.descriptions().size(), wanted.size());
    for (std::uint16_t id = 0; id < wanted.size(); ++id) {
        EXPECT_EQ(parameters.descriptions()[id].name, "P" + std::to_string(id));
        EXPECT_EQ(parameters.descriptions()[id].info, "info");
        EXPECT_EQ(parameters.value(id), wanted[id].second) << id;
    }
    EXPECT_EQ(parameters.find("P3").parameter->id, 3);
    EXPECT_EQ(parameters.find("P").parameter, nullptr);
    EXPECT_EQ(parameters.progress().done, 2 * wanted.size());
}

TEST_F(Reads, a_device_without_parameters) {
    EXPECT_EQ(read(), Ending::done);
    EXPECT_TRUE(parameters.descriptions().empty());
}

TEST_F(Reads, at_most_eight_parameters_at_a_time) {
    fake.make_parameters(60);
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(simulation.most_on_their_way, Window::max_size);
    EXPECT_FALSE(fake.crashed);
}

Bytes i32(std::int32_t n) {
    Bytes bytes(4);
    store(bytes.data(), n);
    return bytes;
}

TEST_F(Reads, values_and_ranges_of_older_devices) {
    fake.old = true;
    fake.parameters = {{0, "ROL", "", i32(-7)}, {0, "\xB8\xDF\xB6\xC8", "", i32(8'503'346)}};
    fake.parameters[1].max = 10'000'000;
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.value(0), AnyValue{std::int64_t{-7}});
    EXPECT_EQ(parameters.value(1), AnyValue{std::int64_t{8'503'346}});
    EXPECT_EQ(parameters.descriptions()[1].limits, (ParameterInfo::Limits{-10, 10'000'000}));
    EXPECT_EQ(parameters.descriptions()[1].layout, ParameterLayout::ranged);
}

TEST_F(Reads, scaled_values_and_divides_them) {
    fake.scaled = true;
    fake.parameters = {{0, "P", "", i32(1234)}, {0, "I", "", i32(-5)}, {0, "COUNT", "a whole number", i32(55)}};
    fake.parameters[0].mul = 1000;
    fake.parameters[1].mul = 100;
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.value(0), AnyValue{1.234});
    EXPECT_EQ(parameters.value(1), AnyValue{-0.05});
    EXPECT_EQ(parameters.value(2), AnyValue{std::int64_t{55}});
    EXPECT_EQ(parameters.descriptions()[0].mul, 1000);
    EXPECT_EQ(parameters.descriptions()[0].name, "P");
    EXPECT_EQ(parameters.descriptions()[2].mul, 1);
    EXPECT_EQ(parameters.descriptions()[2].limits, (ParameterInfo::Limits{-10, 100}));
}

// 8202 is 0x200A: in the current layout this is a text whose name begins with a space.
TEST_F(Reads, all_descriptions_of_a_device_in_one_layout) {
    for (const bool scaled : {false, true}) {
        fake.old = !scaled;
        fake.scaled = scaled;
        fake.version += 1;    // another device
        fake.parameters.clear();
        for (int i = 0; i < 5; ++i) fake.parameters.push_back({0, "PAR_" + std::to_string(i), "", i32(i)});
        fake.parameters[3].min = 8202;
        fake.parameters[3].max = 9000;
        fake.parameters[3].value = i32(8500);
        Parameters all{device, &cache};
        all.read_all(simulation.now);
        simulation.run(all);
        ASSERT_EQ(all.end()->ending, Ending::done);
        EXPECT_EQ(all.descriptions()[3].name, "PAR_3");
        EXPECT_EQ(all.descriptions()[3].limits, (ParameterInfo::Limits{8202, 9000}));
        EXPECT_EQ(all.value(3), AnyValue{std::int64_t{8500}});
        EXPECT_EQ(all.descriptions()[3].layout, scaled ? ParameterLayout::scaled : ParameterLayout::ranged);
    }
}

TEST_F(Reads, descriptions_from_the_cache_but_never_values) {
    fake.make_parameters(20);
    ASSERT_EQ(read(), Ending::done);
    fake.heard.clear();
    fake.parameters[3].value[0] = 77;
    Parameters again{device, &cache};
    again.read_all(simulation.now);
    simulation.run(again);
    ASSERT_EQ(again.end()->ending, Ending::done);
    EXPECT_TRUE(again.from_cache());
    EXPECT_EQ(heard(0xE0, 3), 0u);
    EXPECT_EQ(heard(0xE0, 2), 20u);
    EXPECT_EQ(again.bytes(3)[0], 77);
    EXPECT_EQ(again.descriptions(), parameters.descriptions());
}

TEST_F(Reads, the_values_of_some_parameters_only) {
    fake.make_parameters(40);
    for (const bool cached : {false, true}) {
        fake.heard.clear();
        Parameters some{device, &cache};
        some.read_named({"PAR_7", "PAR_30", "NONE"}, simulation.now);
        simulation.run(some);
        ASSERT_TRUE(some.end());
        EXPECT_EQ(some.end()->ending, Ending::done);
        EXPECT_EQ(some.from_cache(), cached);
        EXPECT_EQ(heard(0xE0, 2), 2u);
        EXPECT_TRUE(some.value(7));
        EXPECT_TRUE(some.value(30));
        EXPECT_FALSE(some.value(8));
    }
    fake.parameters[7].value.clear();
    Parameters some{device, &cache};
    some.read_named({"PAR_30", "PAR_7"}, simulation.now);
    simulation.run(some);
    EXPECT_EQ(some.end()->fault.text(), "parameter 7 was not received completely");
}

TEST_F(Reads, descriptions_again_if_the_device_has_changed_or_was_away) {
    fake.make_parameters(5);
    ASSERT_EQ(read(), Ending::done);
    const auto described_again = [&] {
        fake.heard.clear();
        Parameters again{device, &cache};
        again.read(Parameters::Values::none, simulation.now);
        simulation.run(again);
        EXPECT_EQ(again.end()->ending, Ending::done);
        return heard(0xE0, 3);
    };
    EXPECT_EQ(described_again(), 0u);
    fake.version = 101;
    EXPECT_EQ(described_again(), 5u);
    fake.make_parameters(1);
    EXPECT_EQ(described_again(), 6u);
    fake.name = "other";
    EXPECT_EQ(described_again(), 6u);
    simulation.pass(Device::away_after + std::chrono::seconds{1});
    EXPECT_EQ(described_again(), 6u) << "away";
}

TEST_F(Reads, descriptions_again_if_the_values_do_not_fit_the_cached_ones) {
    fake.make_parameters(5);
    ASSERT_EQ(read(), Ending::done);
    fake.parameters[4] = {0, "NEW", "", {9}};    // it had four bytes
    Parameters again{device, &cache};
    again.read_all(simulation.now);
    simulation.run(again);
    ASSERT_EQ(again.end()->ending, Ending::done);
    EXPECT_EQ(again.descriptions()[4].name, "NEW");
}

TEST_F(Reads, an_old_device_with_its_ranges) {
    fake.old = true;
    fake.parameters = {{0, "OLD_0", "x", {7, 0, 0, 0}}, {0, "OLD_1", "y", {0xFF, 0xFF, 0xFF, 0xFF}}};
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.descriptions()[0].name, "OLD_0");
    EXPECT_EQ(parameters.descriptions()[0].type, Type::i32);
    EXPECT_EQ(parameters.descriptions()[0].limits, (ParameterInfo::Limits{-10, 100}));
    EXPECT_EQ(parameters.value(1), AnyValue{std::int64_t{-1}});
}

TEST_F(Reads, and_times_out_soon_for_a_dead_device_and_reports_the_number_of_tries) {
    fake.deaf = true;
    EXPECT_EQ(read(), Ending::timeout);
    EXPECT_EQ(parameters.end()->evidence.sent, 30u);
    EXPECT_EQ(parameters.end()->fault.text(), "0xDC does not answer: device info, sent 30 times");
}

TEST_F(Reads, and_ends_within_its_time_limit_when_the_device_is_lost_in_the_middle) {
    fake.make_parameters(300);
    fake.instead = [&](FrameView) -> std::optional<std::vector<Bytes>> {
        if (fake.heard.size() > 100) return std::vector<Bytes>{};
        return std::nullopt;
    };
    parameters.read_all(simulation.now);
    const Duration took = simulation.run(parameters);
    ASSERT_TRUE(parameters.end());
    EXPECT_EQ(parameters.end()->ending, Ending::timeout);
    EXPECT_LT(took, std::chrono::seconds{12});
}

TEST_F(Reads, the_other_parameters_and_reports_one_without_an_answer) {
    fake.make_parameters(30);
    fake.instead = [](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 2 && f.data()[1] == 17) return std::vector<Bytes>{};
        return std::nullopt;
    };
    EXPECT_EQ(read(), Ending::incomplete);
    EXPECT_EQ(parameters.end()->fault.text(), "parameter 17 was not received completely");
    EXPECT_FALSE(parameters.value(17));
    EXPECT_TRUE(parameters.value(29));
}

TEST_F(Reads, within_a_minute_from_a_device_that_reports_a_wrong_count) {
    fake.make_parameters(10);
    fake.reported_count = 60'000;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] >= 2 && (f.data()[1] >= 10 || f.data()[2] > 0)) return std::vector<Bytes>{};
        return std::nullopt;
    };
    parameters.read_all(simulation.now);
    const Duration took = simulation.run(parameters);
    ASSERT_TRUE(parameters.end());
    EXPECT_NE(parameters.end()->ending, Ending::done);
    EXPECT_LT(took, std::chrono::minutes{1});
}

TEST_F(Reads, no_value_that_is_shorter_than_its_type) {
    fake.make_parameters(10);
    fake.parameters[5].value = {1, 2};
    EXPECT_EQ(read(), Ending::incomplete);
    EXPECT_FALSE(parameters.value(5));
}

TEST_F(Reads, again_from_the_start_when_the_count_changes_meanwhile) {
    fake.make_parameters(10);
    bool grown = false;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (!grown && f.id() == 0xE0 && f.data()[0] == 2 && f.data()[1] == 9) {
            fake.make_parameters(2);
            grown = true;
        }
        return std::nullopt;
    };
    EXPECT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.descriptions().size(), 12u);
}

TEST_F(Reads, no_removed_parameters_when_the_count_becomes_smaller_meanwhile) {
    fake.make_parameters(100);
    simulation.each_step = [&](TimePoint now) {
        if (simulation.frames_there < 40 || fake.parameters.size() < 100) return;
        fake.parameters.resize(50);
        const Bytes to_another_host = support::frame(0xDC, 0xD2, 0xE0, {1, 50, 0});
        device.take(FrameView{to_another_host}, now);
    };
    EXPECT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.descriptions().size(), 50u);
    EXPECT_FALSE(fake.crashed);
}

TEST_F(Reads, again_when_the_device_becomes_another_one_meanwhile) {
    fake.make_parameters(20);
    simulation.each_step = [&](TimePoint now) {
        if (simulation.frames_there < 30 || fake.version == 101) return;
        fake.version = 101;
        for (auto& p : fake.parameters) p.name += "_NEW";
        const Bytes info = support::frame(0xDC, 0xD2, 0xE3, {0xDC, 100, 0, 101, 0, 0, 0, 0x20, 3, 'f', 'a', 'k', 'e'});
        const Bytes count = support::frame(0xDC, 0xD2, 0xE0, {1, 20, 0});
        device.take(FrameView{info}, now);
        device.take(FrameView{count}, now);
    };
    EXPECT_EQ(read(), Ending::done);
    for (const ParameterInfo& one : parameters.descriptions()) EXPECT_EQ(one.name, "PAR_" + std::to_string(one.id) + "_NEW");
}

TEST_F(Reads, and_fails_when_the_count_never_stops_changing) {
    fake.make_parameters(30);
    std::uint16_t count = 10;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 1) fake.reported_count = ++count;
        return std::nullopt;
    };
    EXPECT_EQ(read(), Ending::failed);
    EXPECT_FALSE(fake.crashed);
}

TEST_F(Reads, two_parameters_with_one_name_and_finds_neither_by_that_name) {
    fake.parameters = {{0, "SAME", "", {1}}, {0, "SAME", "", {2}}};
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.find("SAME").parameter, nullptr);
    EXPECT_TRUE(parameters.find("SAME").several);
}

TEST_F(Reads, names_of_any_bytes_and_unknown_types) {
    fake.parameters = {{0, "\xB2\xCE\xFF\x01", "\xFE", {1}}, {99, "ODD", "", {1, 2, 3}}, {10, "EMPTY", "", {}}};
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(parameters.descriptions()[0].name, "\xB2\xCE\xFF\x01");
    EXPECT_FALSE(parameters.descriptions()[1].type);
    EXPECT_EQ(parameters.bytes(1).size(), 3u);
    EXPECT_FALSE(parameters.value(1));
    EXPECT_EQ(parameters.value(2), AnyValue{std::string{}});
}

TEST_F(Reads, answers_that_arrive_late_twice_and_in_any_order) {
    fake.make_parameters(100);
    simulation.back = {
        .delay = std::chrono::milliseconds{5}, .jitter = std::chrono::milliseconds{80}, .loss = 0.05, .duplicate = 0.3};
    ASSERT_EQ(read(), Ending::done);
    for (std::uint16_t id = 0; id < 100; ++id) {
        EXPECT_EQ(parameters.descriptions()[id].name, fake.parameters[id].name);
        EXPECT_EQ(Bytes(parameters.bytes(id).begin(), parameters.bytes(id).end()), fake.parameters[id].value);
    }
    EXPECT_GT(simulation.taken[Taken::doubled], 20);
    EXPECT_EQ(simulation.taken[Taken::unasked], 0);
}

// Nothing is lost: before a round trip is measured, a question is repeated before its answer can arrive.
TEST_F(Reads, several_parameters_at_a_time_over_a_line_with_long_round_trips) {
    fake.make_parameters(150);
    for (const int delay : {170, 200, 220, 250, 400}) {
        SCOPED_TRACE(delay);
        Device far{0xDC};
        Simulation line{far, fake, {.delay = std::chrono::milliseconds{delay}}};
        Parameters all{far};
        all.read_all(line.now);
        const Duration took = line.run(all);
        ASSERT_TRUE(all.end());
        EXPECT_EQ(all.end()->ending, Ending::done) << all.end()->fault.text();
        // 300 exchanges, eight at a time, in rounds of two delays.
        EXPECT_LT(took, std::chrono::milliseconds{2 * delay * 300 / 8 * 5 / 4 + 4000});
        EXPECT_EQ(far.window(), Window::max_size);
    }
}

TEST_F(Reads, without_using_answers_to_other_hosts) {
    fake.make_parameters(20);
    simulation.each_step = [&](TimePoint now) {
        const Bytes foreign = support::frame(0xDC, 0xD2, 0xE1, {3, 0, 99, 99, 99, 99});
        device.take(FrameView{foreign}, now);
        const Bytes other_device = support::frame(0xDD, 0xFE, 0xE1, {3, 0, 99, 99, 99, 99});
        device.take(FrameView{other_device}, now);
    };
    ASSERT_EQ(read(), Ending::done);
    EXPECT_EQ(Bytes(parameters.bytes(3).begin(), parameters.bytes(3).end()), fake.parameters[3].value);
}

TEST_F(Reads, nothing_more_when_cancelled) {
    fake.make_parameters(100);
    simulation.each_step = [&](TimePoint now) {
        if (simulation.frames_there > 20) parameters.cancel(now);
    };
    EXPECT_EQ(read(), Ending::cancelled);
    EXPECT_EQ(device.on_their_way(), 0u);
    EXPECT_FALSE(device.due());
}

}    // namespace
}    // namespace ano::host::parameters_tests
