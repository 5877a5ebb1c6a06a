// The commands of a device: reading them, and calling one once.
#include <host/commands.hpp>

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
    std::vector<CommandInfo> read(ValueType7 seven = ValueType7::f32) {
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
        return task.end().value_or(End{Ending::cancelled, "", {}});
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

TEST_F(CommandsOf, an_older_device_are_read_as_well) {
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

TEST_F(CommandsOf, one_that_is_not_described_is_told) {
    fake.instead = [](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xC1 && f.data()[0] == 1 && f.data()[1] == 4) return std::vector<Bytes>{};
        return std::nullopt;
    };
    Commands commands{device};
    commands.read(simulation.now);
    simulation.run(commands);
    ASSERT_TRUE(commands.end());
    EXPECT_EQ(commands.end()->ending, Ending::incomplete);
    EXPECT_EQ(commands.end()->what, "command 4 was not described");
    EXPECT_NE(commands.find("unlock"), nullptr);
    EXPECT_EQ(commands.find("odd"), nullptr);
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
    EXPECT_EQ(call(commands[1], {std::int64_t{1}}).what, "take off takes 2 values, not 1");
    EXPECT_EQ(call(commands[1], {std::int64_t{70'000}, 0.5}).what, "take off: value 1, 70000, is out of range for u16");
    EXPECT_EQ(call(commands[1], {1.5, 0.5}).what, "take off: value 1, 1.5, is not whole for u16");
    EXPECT_EQ(call(commands[1], {std::string{"x"}, 0.5}).ending, Ending::invalid);
    EXPECT_EQ(call(commands[4], {std::int64_t{1}}).ending, Ending::unsupported);
    EXPECT_TRUE(fake.heard.empty());
}

TEST_F(CommandsOf, a_call_is_sent_once_and_silence_is_unknown) {
    const auto commands = read();
    fake.deaf = true;
    const End end = call(commands[0], {});
    EXPECT_EQ(end.ending, Ending::unknown);
    EXPECT_EQ(end.what, "no answer to unlock: it may have been carried out");
    EXPECT_EQ(fake.heard.size(), 1u);
    EXPECT_EQ(took, std::chrono::seconds{2});
}

TEST_F(CommandsOf, a_late_answer_to_a_call_does_not_answer_an_equal_one) {
    const auto commands = read();
    TimePoint now = simulation.now;
    const auto call_now = [&](std::size_t which) {
        auto task = std::make_unique<CommandCall>(device, commands[which], std::vector<AnyValue>{}, false);
        task->start(now);
        return task;
    };
    const auto frame_now = [&]() -> std::optional<Bytes> {
        const auto frame = device.next_frame(now);
        return frame ? std::optional{Bytes(frame->bytes().begin(), frame->bytes().end())} : std::nullopt;
    };
    const auto first = call_now(0);
    const auto sent = frame_now();
    ASSERT_TRUE(sent);
    const Bytes answer = fake.to_host(FrameView{*sent}, 0x00,
                                      {0xC0, FrameView{*sent}.checks().sum, FrameView{*sent}.checks().add});
    now = *device.due();
    EXPECT_FALSE(frame_now());
    ASSERT_TRUE(first->end());
    EXPECT_EQ(first->end()->ending, Ending::unknown);

    const auto second = call_now(0);
    EXPECT_FALSE(frame_now()) << "the answer to the first may still come";
    ASSERT_TRUE(device.due());
    EXPECT_EQ(*device.due() - now, Device::late_for);
    const TimePoint may_go = *device.due();
    now = may_go - Duration{1};
    EXPECT_FALSE(frame_now());
    now = may_go;
    EXPECT_EQ(frame_now(), sent);
    second->cancel(now);

    const auto third = call_now(0);
    EXPECT_FALSE(frame_now()) << "nor is the answer to a cancelled one known not to come";
    EXPECT_EQ(device.take(FrameView{answer}, now), Taken::late);
    EXPECT_FALSE(third->end());
    EXPECT_EQ(frame_now(), sent) << "it came: nothing is waited for any more";
    EXPECT_EQ(device.take(FrameView{answer}, now), Taken::ended);
    EXPECT_EQ(third->end()->ending, Ending::done);
}

TEST_F(CommandsOf, a_call_is_repeated_when_asked_to) {
    const auto commands = read();
    fake.deaf = true;
    EXPECT_EQ(call(commands[0], {}, true).ending, Ending::timeout);
    EXPECT_EQ(fake.heard.size(), 5u);
}

}    // namespace
}    // namespace ano::host::commands_tests
