// The commands of a device: reading them, and calling one once.
#include <host/commands.hpp>
#include <host/parameters.hpp>

#include <support/fake_device.hpp>

#include <gtest/gtest.h>

namespace ano::host::commands_tests {
namespace {

using support::Bytes;
using support::FakeDevice;
using support::Simulation;

struct CommandsOf : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = std::chrono::milliseconds{10}}};

    CommandsOf() {
        fake.commands = {{{0x10, 0, 1}, {}, "unlock", "motors on"},
                         {{0x10, 0, 5}, {3, 9}, "take off", "height speed"},
                         {{0x10, 0, 6}, {1, 2, 3, 4, 5, 6, 8, 10}, "many", ""},
                         {{0x10, 0, 7}, {7}, "seven", ""},
                         {{0x10, 0, 8}, {77}, "odd", ""}};
    }
    std::vector<CommandInfo> read(std::optional<ValueType7> seven = ValueType7::f32) {
        Commands commands{device, seven};
        commands.read(simulation.now);
        simulation.run(commands);
        EXPECT_TRUE(commands.end());
        EXPECT_EQ(commands.end()->ending, Ending::done);
        return commands.descriptions();
    }
    End call(const CommandInfo& command, std::vector<AnyValue> values, bool repeat = false) {
        fake.heard.clear();
        CommandCall task{device, command, std::move(values), repeat};
        task.start(simulation.now);
        took = simulation.run(task);
        return task.end().value_or(End{Ending::cancelled, {}, {}});
    }
    Duration took{};
};

TEST_F(CommandsOf, a_device_are_read_with_their_types) {
    const auto commands = read();
    ASSERT_EQ(commands.size(), 5u);
    EXPECT_EQ(commands[1].name, "take off");
    EXPECT_EQ(commands[1].info, "height speed");
    EXPECT_EQ(commands[1].cid, (std::array<std::uint8_t, 3>{0x10, 0, 5}));
    EXPECT_EQ(commands[1].types, (std::vector{Type::u16, Type::f32}));
    EXPECT_EQ(commands[3].types, std::vector{Type::f32});
    EXPECT_EQ(read(ValueType7::u64)[3].types, std::vector{Type::u64});
    EXPECT_TRUE(commands[4].has_unknown_type);
}

TEST_F(CommandsOf, a_device_with_a_type_above_7_use_u64_for_type_7) {
    const auto commands = read(std::nullopt);
    EXPECT_EQ(commands[3].types, std::vector{Type::u64});
    EXPECT_FALSE(commands[3].has_open_type);
    EXPECT_EQ(call(commands[3], {~std::uint64_t{}}).ending, Ending::done);
    EXPECT_EQ(fake.heard[0].size(), 8u + 3 + 8);
    EXPECT_EQ(std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xE0; }), 0);
}

TEST_F(CommandsOf, a_device_with_ranges_of_parameters_use_f32_for_type_7) {
    fake.commands = {{{0x10, 0, 7}, {7}, "seven", ""}};
    fake.make_parameters(1);
    fake.old = true;
    const auto commands = read(std::nullopt);
    EXPECT_EQ(commands[0].types, std::vector{Type::f32});
    EXPECT_EQ(call(commands[0], {0.5}).ending, Ending::done);
    EXPECT_EQ(Bytes(fake.heard[0].begin() + 9, fake.heard[0].end() - 2), (Bytes{0, 0, 0, 0x3F}));
}

TEST_F(CommandsOf, a_device_that_does_not_show_the_meaning_of_type_7_are_not_called_with_it) {
    fake.commands = {{{0x10, 0, 7}, {7}, "seven", ""}, {{0x10, 0, 1}, {1}, "one", ""}};
    for (const bool has_parameters : {false, true}) {
        if (has_parameters) fake.make_parameters(1);
        const auto commands = read(std::nullopt);
        EXPECT_TRUE(commands[0].has_open_type);
        const End end = call(commands[0], {0.5});
        EXPECT_EQ(end.ending, Ending::invalid);
        EXPECT_EQ(end.fault.text(),
                  "seven has a value of type 7, which is f32 in older devices and u64 in newer ones, and the device's "
                  "descriptions do "
                  "not show which: state it once (type7)");
        EXPECT_TRUE(fake.heard.empty());
        EXPECT_EQ(call(commands[1], {std::int64_t{1}}).ending, Ending::done);
        EXPECT_EQ(call(with_type_7(commands[0], ValueType7::u64), {std::int64_t{1}}).ending, Ending::done);
        EXPECT_EQ(fake.heard[0].size(), 8u + 3 + 8);
    }
}

TEST_F(CommandsOf, an_older_device_are_also_read) {
    fake.old = true;
    EXPECT_EQ(read().size(), 5u);
}

TEST_F(CommandsOf, a_dead_device_end_soon) {
    fake.deaf = true;
    Commands commands{device};
    commands.read(simulation.now);
    simulation.run(commands);
    ASSERT_TRUE(commands.end());
    EXPECT_EQ(commands.end()->ending, Ending::timeout);
}

TEST_F(CommandsOf, a_command_without_a_description_is_reported) {
    fake.instead = [](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xC1 && f.data()[0] == 1 && f.data()[1] == 4) return std::vector<Bytes>{};
        return std::nullopt;
    };
    Commands commands{device};
    commands.read(simulation.now);
    simulation.run(commands);
    ASSERT_TRUE(commands.end());
    EXPECT_EQ(commands.end()->ending, Ending::incomplete);
    EXPECT_EQ(commands.end()->fault.text(), "command 4 was not described");
    EXPECT_NE(commands.find("unlock"), nullptr);
    EXPECT_EQ(commands.find("odd"), nullptr);
}

// Losses for three seconds end both rounds of the questions; each question is repeated for a second when a round trip is known.
TEST_F(CommandsOf, a_description_that_is_lost_repeatedly_is_requested_once_more) {
    std::optional<TimePoint> first;
    int lost = 0;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xC1 || f.data()[0] != 1 || f.data()[1] != 3) return std::nullopt;
        if (!first) first = simulation.now;
        if (simulation.now - *first >= 3 * Patience::repeated_for) return std::nullopt;
        return ++lost, std::vector<Bytes>{};
    };
    EXPECT_EQ(read().size(), 5u);
    EXPECT_GT(lost, 5);
}

TEST_F(CommandsOf, a_call_packs_its_values) {
    const auto commands = read();
    EXPECT_EQ(call(commands[1], {std::int64_t{300}, 0.5}).ending, Ending::done);
    EXPECT_EQ(Bytes(fake.heard[0].begin() + 6, fake.heard[0].end() - 2), (Bytes{0x10, 0, 5, 0x2C, 1, 0, 0, 0, 0x3F}));
    EXPECT_EQ(call(commands[0], {}).ending, Ending::done);
    EXPECT_EQ(fake.heard[0].size(), 11u);
}

TEST_F(CommandsOf, values_are_checked_in_number_type_and_range) {
    const auto commands = read();
    EXPECT_EQ(call(commands[1], {std::int64_t{1}}).fault.text(), "take off needs 2 values, not 1");
    EXPECT_EQ(call(commands[1], {std::int64_t{70'000}, 0.5}).fault.text(), "take off: value 1, 70000, is out of range for u16");
    EXPECT_EQ(call(commands[1], {1.5, 0.5}).fault.text(), "take off: value 1, 1.5, is not whole for u16");
    EXPECT_EQ(call(commands[1], {std::string{"x"}, 0.5}).ending, Ending::invalid);
    EXPECT_EQ(call(commands[4], {std::int64_t{1}}).ending, Ending::unsupported);
    EXPECT_TRUE(fake.heard.empty());
}

TEST_F(CommandsOf, a_call_is_sent_once_and_has_an_unknown_result_without_an_answer) {
    const auto commands = read();
    fake.deaf = true;
    const End end = call(commands[0], {});
    EXPECT_EQ(end.ending, Ending::unknown);
    EXPECT_EQ(end.fault.text(), "no answer to unlock: it may have been carried out");
    EXPECT_EQ(fake.heard.size(), 1u);
    EXPECT_EQ(took, std::chrono::seconds{2});
}

TEST_F(CommandsOf, an_acknowledgement_with_wrong_check_bytes_ends_a_call_at_once) {
    const auto commands = read();
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        return std::vector<Bytes>{fake.to_host(f, 0x00, {f.id(), f.checks().sum, 0x77})};
    };
    const TimePoint begin = simulation.now;
    const End end = call(commands[0], {});
    EXPECT_LT(simulation.now - begin, std::chrono::milliseconds{100});
    EXPECT_EQ(end.ending, Ending::unknown);
    EXPECT_EQ(end.fault.text(), "0xDC acknowledged unlock with wrong check bytes (C0 59 77): it has probably been carried out");
    EXPECT_EQ(fake.heard.size(), 1u) << "it is never repeated by itself";
    const End repeated = call(commands[0], {}, true);
    EXPECT_EQ(repeated.ending, Ending::unknown);
    EXPECT_EQ(repeated.fault.text(), end.fault.text());
    EXPECT_LT(simulation.now - begin, std::chrono::milliseconds{300});
    EXPECT_EQ(fake.heard.size(), 1u) << "each send would run it again";
}

TEST_F(CommandsOf, an_acknowledgement_of_another_frame_does_not_end_a_call) {
    const auto commands = read();
    for (const std::uint8_t of : Bytes{0xE1, 0xC1}) {
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            return std::vector<Bytes>{fake.to_host(f, 0x00, {of, 1, 2}), fake.check(f)};
        };
        EXPECT_EQ(call(commands[0], {}).ending, Ending::done);
    }
}

TEST_F(CommandsOf, an_acknowledgement_from_a_port_of_the_device_ends_a_call_and_is_reported) {
    const auto commands = read();
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        return std::vector<Bytes>{support::frame(0x05, 0xFE, 0x00, {f.id(), f.checks().sum, f.checks().add})};
    };
    const End end = call(commands[0], {});
    EXPECT_EQ(end.ending, Ending::done);
    EXPECT_EQ(end.fault.text(), "acknowledged by 0x05, a port");
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        return std::vector<Bytes>{support::frame(0x05, 0xFE, 0x00, {f.id(), f.checks().sum, 0x77})};
    };
    EXPECT_EQ(call(commands[0], {}).fault.text(), "no answer to unlock: it may have been carried out")
        << "it may be of another device";
}

// Calls in which the test passes the frames itself.
struct HandCalls : CommandsOf {
    std::vector<CommandInfo> commands = read();
    TimePoint now = simulation.now;

    std::unique_ptr<CommandCall> call_now(std::size_t which) {
        auto task = std::make_unique<CommandCall>(device, commands[which], std::vector<AnyValue>{}, false);
        task->start(now);
        return task;
    }
    std::optional<Bytes> frame_now() {
        const auto frame = device.next_frame(now);
        return frame ? std::optional{Bytes(frame->bytes().begin(), frame->bytes().end())} : std::nullopt;
    }
    Bytes answer_to(const Bytes& sent) const {
        const Checks checks = FrameView{sent}.checks();
        return fake.to_host(FrameView{sent}, 0x00, {0xC0, checks.sum, checks.add});
    }
    static void expect_ambiguous(const CommandCall& call) {
        ASSERT_TRUE(call.end());
        EXPECT_EQ(call.end()->ending, Ending::unknown);
        EXPECT_EQ(call.end()->fault.text(),
                  "0xDC acknowledged unlock, which was sent more than once: the acknowledgement does not show "
                  "which of them was carried out");
    }
};

TEST_F(HandCalls, an_equal_call_is_sent_at_once_after_a_call_without_an_answer) {
    const auto first = call_now(0);
    const auto sent = frame_now();
    ASSERT_TRUE(sent);
    now = *device.due();
    EXPECT_FALSE(frame_now());
    ASSERT_TRUE(first->end());
    EXPECT_EQ(first->end()->ending, Ending::unknown);

    const auto second = call_now(0);
    EXPECT_EQ(frame_now(), sent);
    EXPECT_EQ(device.take(FrameView{answer_to(*sent)}, now), Taken::ended);
    expect_ambiguous(*second);    // it may be the late answer to the first

    now += Device::late_for;
    const auto third = call_now(0);
    EXPECT_EQ(frame_now(), sent);
    EXPECT_EQ(device.take(FrameView{answer_to(*sent)}, now), Taken::ended);
    EXPECT_EQ(third->end()->fault.text(), "") << "so late no answer to the first comes";
}

TEST_F(HandCalls, a_late_acknowledgement_of_the_first_call_is_not_taken_for_one_of_an_equal_call_that_was_lost) {
    const auto first = call_now(0);
    const auto sent = frame_now();
    ASSERT_TRUE(sent);
    now = *device.due();
    EXPECT_FALSE(frame_now());
    now += Device::late_for - std::chrono::milliseconds{100};
    const auto second = call_now(0);    // the device does not receive it
    EXPECT_EQ(frame_now(), sent);
    now += std::chrono::milliseconds{500};
    EXPECT_EQ(device.take(FrameView{answer_to(*sent)}, now), Taken::ended);
    expect_ambiguous(*second);
}

TEST_F(HandCalls, calls_in_flight_are_distinguished_if_their_bytes_differ) {
    const auto first = call_now(0);
    const auto sent = frame_now();
    CommandInfo other_bytes = commands[0];
    other_bytes.cid[2] ^= 1;
    CommandCall other{device, other_bytes, {}};
    other.start(now);
    const auto sent_other = frame_now();
    ASSERT_TRUE(sent && sent_other);
    EXPECT_EQ(device.take(FrameView{answer_to(*sent_other)}, now), Taken::ended);
    ASSERT_TRUE(other.end());
    EXPECT_EQ(other.end()->fault.text(), "");
    EXPECT_FALSE(first->end());

    const auto equal = call_now(0);
    EXPECT_EQ(frame_now(), sent);
    EXPECT_EQ(device.take(FrameView{answer_to(*sent)}, now), Taken::ended);
    expect_ambiguous(*first);
    EXPECT_FALSE(equal->end());
    EXPECT_EQ(device.take(FrameView{answer_to(*sent)}, now), Taken::ended);
    EXPECT_EQ(equal->end()->fault.text(), "") << "both were acknowledged";
}

TEST_F(CommandsOf, a_call_is_the_next_frame_while_a_long_list_is_read) {
    const auto commands = read();
    fake.make_parameters(100);
    simulation.back.loss = 0.3;
    Parameters parameters{device};
    parameters.read_all(simulation.now);
    simulation.run(parameters, std::chrono::milliseconds{200});
    ASSERT_FALSE(parameters.end());
    ASSERT_GT(device.waiting(), 0u);
    fake.heard.clear();
    CommandCall land{device, commands[0], {}};
    land.start(simulation.now);
    simulation.run(land);
    const auto at = std::find_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xC0; });
    EXPECT_LE(at - fake.heard.begin(), static_cast<std::ptrdiff_t>(Window::max_size)) << "only those that were on their way";
    EXPECT_EQ(std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xC0; }), 1);
}

TEST_F(CommandsOf, a_call_is_repeated_if_requested) {
    const auto commands = read();
    fake.deaf = true;
    EXPECT_EQ(call(commands[0], {}, true).ending, Ending::timeout);
    EXPECT_EQ(fake.heard.size(), 5u);
}

}    // namespace
}    // namespace ano::host::commands_tests
