#include <gtest/gtest.h>
#include <ano/wire.hpp>
#include <device/device.hpp>

#include <functional>
#include <stdexcept>
#include <string>
#include <tuple>

#include <support/vendor_frames.hpp>

#include "talk.hpp"

namespace commands_tests {
namespace {

using ano::Type;
using ano::device::Command;
using ano::device::Device;
using ano::device::Profile;
using ano::device::Value;
using namespace talk;
using support::operator+;

Bytes how_many_commands() { return ask(0xC1, {0, 0, 0}); }
Bytes describe_command(std::uint8_t n) { return ask(0xC1, {1, n, 0}); }
Bytes run(const Bytes& cid, const Bytes& values = {}) { return ask(0xC0, cid + values); }

template <class T>
Bytes packed(T v) {
    Bytes result(sizeof(T));
    ano::store(result.data(), v);
    return result;
}

TEST(Commands, are_counted_and_described) {
    Device device{{.id = self}};
    EXPECT_EQ(answer(device, how_many_commands()), expected_reply(0xC1, {0, 0, 0}));
    device.commands().add({1, 0x80, 1}, "USERCMD1", "UserDefCmd1", [](std::uint8_t, std::int16_t, float) {});
    device.commands().add({9, 9, 9}, "REBOOT", "", [] {});
    EXPECT_EQ(answer(device, how_many_commands()), expected_reply(0xC1, {0, 2, 0}));
    // Example 2 of the protocol text.
    EXPECT_EQ(answer(device, describe_command(0)), expected_reply(0xC2, Bytes{0, 0, 1, 0x80, 1, 1, 4, 9, 0, 0, 0, 0, 0} +
                                                                            bytes("USERCMD1", 20) + bytes("UserDefCmd1")));
    EXPECT_EQ(answer(device, describe_command(1)), expected_reply(0xC2, Bytes{1, 0, 9, 9, 9} + Bytes(8) + bytes("REBOOT", 20)));
    EXPECT_EQ(answer(device, describe_command(2)), silence);
    EXPECT_EQ(answer(device, ask(0xC1, {2, 0, 0})), silence);
    EXPECT_EQ(answer(device, ask(0xC1, {1, 0})), silence);
}

TEST(Commands, are_counted_for_another_device_only_if_the_response_differs_from_a_request) {
    Device device{{.id = self}};
    EXPECT_EQ(answer(device, support::frame(5, self, 0xC1, {0, 0, 0})), silence);
    device.commands().add({9, 9, 9}, "REBOOT", "", [] {});
    EXPECT_EQ(answer(device, support::frame(5, self, 0xC1, {0, 0, 0})), support::frame(self, 5, 0xC1, {0, 1, 0}));
    EXPECT_EQ(answer(device, support::frame(5, self, 0xC1, {0, 1, 0})), silence);
}

TEST(Commands, run_with_values_of_every_type) {
    Device device{{.id = self}};
    std::tuple<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, std::int64_t, double> got;
    device.commands().add({1, 2, 3}, "ALL", "",
                          [&](std::uint8_t a, std::int8_t b, std::uint16_t c, std::int16_t d, std::uint32_t e, std::int32_t f,
                              std::int64_t g, double h) { got = {a, b, c, d, e, f, g, h}; });
    EXPECT_EQ(answer(device, describe_command(0)),
              expected_reply(0xC2, Bytes{0, 0, 1, 2, 3, 1, 2, 3, 4, 5, 6, 8, 10} + bytes("ALL", 20)));
    const Bytes values = packed(std::uint8_t{200}) + packed(std::int8_t{-3}) + packed(std::uint16_t{60000}) +
                         packed(std::int16_t{-5}) + packed(4000000000u) + packed(-7) + packed(INT64_MIN) + packed(0.1);
    const Bytes command = run({1, 2, 3}, values);
    EXPECT_EQ(answer(device, command), acknowledges(command));
    EXPECT_EQ(got, std::tuple(200, -3, 60000, -5, 4000000000u, -7, INT64_MIN, 0.1));
    EXPECT_NE(answer(device, run({1, 2, 3}, Bytes(values.size()))), silence);
    EXPECT_EQ(got, std::tuple(0, 0, 0, 0, 0u, 0, 0, 0.0)) << "nothing stays of the values before";
}

TEST(Commands, interpret_type_7_according_to_the_profile) {
    Device text{{.id = self}};
    Device field{{.id = self}, {.value_type_7 = ano::ValueType7::u64}};
    EXPECT_THROW(text.commands().add({1, 0, 0}, "U64", "", [](std::uint64_t) {}), std::invalid_argument);
    std::uint64_t wide = 0;
    float narrow = 0;
    field.commands().add({1, 0, 0}, "BOTH", "", [&](std::uint64_t a, float b) { wide = a, narrow = b; });
    EXPECT_EQ(answer(field, describe_command(0)),
              expected_reply(0xC2, Bytes{0, 0, 1, 0, 0, 7, 9, 0, 0, 0, 0, 0, 0} + bytes("BOTH", 20)));
    EXPECT_NE(answer(field, run({1, 0, 0}, packed(UINT64_MAX) + packed(0.5f))), silence);
    EXPECT_EQ(wide, UINT64_MAX);
    EXPECT_EQ(narrow, 0.5f);
}

TEST(Commands, of_an_old_device_have_f32_as_type_7) {
    Device old{{.id = self}, {.old_layouts = true}};
    old.commands().add({1, 0, 0}, "F32", "", [](float) {});
    EXPECT_EQ(answer(old, describe_command(0)),
              expected_reply(0xC2, Bytes{0, 0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0} + bytes("F32", 20)));
    old.commands().add({1, 0, 1}, "I64", "", [](std::int64_t) {});
    EXPECT_EQ(answer(old, describe_command(0)),
              expected_reply(0xC2, Bytes{0, 0, 1, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0} + bytes("F32", 20)))
        << "hosts take a device with such a type for one of the newest";
}

TEST(Commands, run_each_time_they_are_requested) {
    Device device{{.id = self}};
    int runs = 0;
    device.commands().add({0, 1, 0}, "GO", "", [&] { ++runs; });
    const Bytes eleven = ask(0xC0, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(answer(device, eleven), acknowledges(eleven)) << "as a host of the vendor sends it";
    EXPECT_EQ(answer(device, eleven), acknowledges(eleven));
    EXPECT_EQ(runs, 2);
}

TEST(Commands, that_are_unknown_refused_or_too_short_get_no_response) {
    Device device{{.id = self}};
    int runs = 0;
    device.commands().add({0, 1, 0}, "GO", "", [&](std::uint16_t n) { return ++runs, n != 7; });
    EXPECT_EQ(answer(device, run({0, 1, 1}, {1, 0})), silence);
    EXPECT_EQ(answer(device, run({1, 1, 0}, {1, 0})), silence);
    EXPECT_EQ(answer(device, run({0, 0, 0}, {1, 0})), silence);
    EXPECT_EQ(device.counters().unknown, 3u);
    EXPECT_EQ(answer(device, run({0, 1, 0}, {1})), silence);
    EXPECT_EQ(answer(device, run({0, 1})), silence);
    EXPECT_EQ(device.counters().malformed, 2u);
    EXPECT_EQ(runs, 0);
    EXPECT_EQ(answer(device, run({0, 1, 0}, {7, 0})), silence);
    EXPECT_EQ(device.counters().refused, 1u);
    EXPECT_EQ(runs, 1);
}

TEST(Commands, that_are_invalid_are_rejected) {
    Device device{{.id = self}};
    auto& commands = device.commands();
    commands.add({1, 1, 1}, "ONE", "", [] {});
    const std::function<bool(std::span<const Value>)> nothing = [](std::span<const Value>) { return true; };
    EXPECT_THROW(commands.add({1, 1, 1}, "TWO", "", [] {}), std::invalid_argument);
    EXPECT_THROW(commands.add({1, 1, 2}, "", "", [] {}), std::invalid_argument);
    EXPECT_THROW(commands.add({1, 1, 2}, std::string(21, 'n'), "", [] {}), std::invalid_argument);
    EXPECT_THROW(commands.add(Command{.cid = {1, 1, 2}, .name = "X"}), std::invalid_argument);
    EXPECT_THROW(commands.add(Command{{1, 1, 2}, "X", "", {Type::text}, nothing}), std::invalid_argument);
    EXPECT_THROW(commands.add(Command{{1, 1, 2}, "X", "", std::vector(9, Type::u8), nothing}), std::invalid_argument);
    EXPECT_NO_THROW(commands.add(Command{{1, 1, 2}, "X", "", std::vector(8, Type::u8), nothing}));
    EXPECT_EQ(commands.count(), 2u);
}

TEST(Commands, have_descriptions_that_fit_into_a_frame) {
    Device device{{.id = self}};
    device.commands().add({1, 1, 1}, "ONE", std::string(300, 'i'), [] {});
    EXPECT_EQ(answer(device, describe_command(0)).size(), ano::overhead + 198);
}

}    // namespace
}    // namespace commands_tests
