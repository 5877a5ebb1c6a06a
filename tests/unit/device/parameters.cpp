#include <gtest/gtest.h>
#include <ano/wire.hpp>
#include <device/device.hpp>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string>

#include "talk.hpp"

namespace parameters_tests {
namespace {

using ano::Type;
using ano::device::Action;
using ano::device::Device;
using ano::device::Parameter;
using ano::device::Value;
using namespace talk;
using support::operator+;

Bytes number(std::uint16_t n) { return {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}; }
Bytes how_many() { return ask(0xE0, {1, 0, 0}); }
Bytes read(std::uint16_t id) { return ask(0xE0, Bytes{2} + number(id)); }
Bytes describe(std::uint16_t id) { return ask(0xE0, Bytes{3} + number(id)); }
Bytes act(std::uint16_t action) { return ask(0xE0, Bytes{0x10} + number(action)); }
Bytes write(std::uint16_t id, const Bytes& value) { return ask(0xE1, number(id) + value); }
Bytes value(std::uint16_t id, const Bytes& bytes) { return expected_reply(0xE1, number(id) + bytes); }
Bytes info(std::uint16_t id, std::uint8_t type, std::string_view name, std::string_view text) {
    return expected_reply(0xE2, number(id) + Bytes{type} + bytes(name, 20) + bytes(text));
}

template <class T>
Bytes wire(T v) {
    Bytes result(sizeof(T));
    ano::store(result.data(), v);
    return result;
}

struct Bench {
    Device device{{.id = self, .name = "bench"}};
    ano::device::Parameters& parameters = device.parameters();
};

TEST(Parameters, are_counted_for_a_host) {
    Bench bench;
    float a = 0, b = 0;
    EXPECT_EQ(answer(bench.device, how_many()), expected_reply(0xE0, {1, 0, 0})) << "none";
    bench.parameters.add("A", a);
    EXPECT_EQ(bench.parameters.add("B", b), 1);
    EXPECT_EQ(answer(bench.device, how_many()), expected_reply(0xE0, {1, 2, 0}));
    EXPECT_EQ(answer(bench.device, ask(0xE0, {1, 9, 9})), expected_reply(0xE0, {1, 2, 0})) << "val has no meaning";
}

// The answer to 0xE0 {1, 0} has the same form as the question.
TEST(Parameters, are_counted_for_another_device_only_if_the_response_differs_from_a_request) {
    Bench bench;
    float a = 0;
    EXPECT_EQ(answer(bench.device, support::frame(5, self, 0xE0, {1, 0, 0})), silence);
    bench.parameters.add("A", a);
    EXPECT_EQ(answer(bench.device, support::frame(5, self, 0xE0, {1, 0, 0})), support::frame(self, 5, 0xE0, {1, 1, 0}));
    EXPECT_EQ(answer(bench.device, support::frame(5, self, 0xE0, {1, 1, 0})), silence) << "an answer";
}

template <class T>
void is_told_and_written(std::uint8_t par_type, T first, T second) {
    Bench bench;
    T variable = first;
    bench.parameters.add("NAME", variable, {.info = "what it is"});
    EXPECT_EQ(answer(bench.device, describe(0)), info(0, par_type, "NAME", "what it is"));
    EXPECT_EQ(answer(bench.device, read(0)), value(0, wire(first)));
    const Bytes written = write(0, wire(second));
    EXPECT_EQ(answer(bench.device, written), acknowledges(written));
    EXPECT_EQ(variable, second);
    EXPECT_EQ(answer(bench.device, read(0)), value(0, wire(second)));

    Bytes too_short = wire(T{});
    too_short.pop_back();
    EXPECT_EQ(answer(bench.device, write(0, too_short)), silence);
    EXPECT_EQ(variable, second) << "nothing of a value that is not whole";
    EXPECT_EQ(bench.device.counters().malformed, 1u);
    const Bytes longer = write(0, wire(first) + Bytes{1, 2, 3});
    EXPECT_EQ(answer(bench.device, longer), acknowledges(longer)) << "longer is legal";
    EXPECT_EQ(variable, first);
}

TEST(Parameters, of_every_number_type_are_read_and_written) {
    is_told_and_written<std::uint8_t>(0, 7, 255);
    is_told_and_written<std::int8_t>(1, -7, -128);
    is_told_and_written<std::uint16_t>(2, 7, 65535);
    is_told_and_written<std::int16_t>(3, -7, -32768);
    is_told_and_written<std::uint32_t>(4, 7, UINT32_MAX);
    is_told_and_written<std::int32_t>(5, -7, INT32_MIN);
    is_told_and_written<std::uint64_t>(6, 7, UINT64_MAX);
    is_told_and_written<std::int64_t>(7, -7, INT64_MIN);
    is_told_and_written<float>(8, 0.1f, -1e30f);
    is_told_and_written<double>(9, 0.1, -1e300);
}

TEST(Parameters, may_be_text) {
    Bench bench;
    std::string place = "roof";
    bench.parameters.add("PLACE", place, {.info = "where", .max_size = 6});
    EXPECT_EQ(answer(bench.device, describe(0)), info(0, 10, "PLACE", "where"));
    EXPECT_EQ(answer(bench.device, read(0)), value(0, bytes("roof")));
    const Bytes longer = write(0, bytes("basement"));
    EXPECT_EQ(answer(bench.device, longer), acknowledges(longer));
    EXPECT_EQ(place, "baseme") << "cut to its size";
    answer(bench.device, write(0, bytes("wc", 10)));
    EXPECT_EQ(place, "wc") << "up to its NUL";
    EXPECT_EQ(answer(bench.device, write(0, {})), silence) << "no bytes are no value";
    EXPECT_EQ(place, "wc");
    answer(bench.device, write(0, {0}));
    EXPECT_EQ(answer(bench.device, read(0)), value(0, {0})) << "empty";
}

TEST(Parameters, of_text_fit_into_a_frame_that_every_device_accepts) {
    Bench bench;
    std::string text(196, 'x');
    bench.parameters.add("LONG", text, {.info = std::string(500, 'i')});
    EXPECT_EQ(answer(bench.device, read(0)).size(), ano::overhead + 198);
    EXPECT_EQ(answer(bench.device, describe(0)).size(), ano::overhead + 198);
    answer(bench.device, write(0, Bytes(400, 'y')));
    EXPECT_EQ(text, std::string(196, 'y'));
}

TEST(Parameters, stay_within_their_limits) {
    Bench bench;
    float gain = 1;
    std::int8_t trim = 0;
    std::uint64_t big = 50;
    bench.parameters.add("GAIN", gain, {.min = -2, .max = 3});
    bench.parameters.add("TRIM", trim, {.min = -10});
    bench.parameters.add("BIG", big, {.max = 100});
    for (const auto& frame : {write(0, wire(9.0f)), write(1, wire(std::int8_t{-100})), write(2, wire(UINT64_MAX))})
        EXPECT_EQ(answer(bench.device, frame), acknowledges(frame)) << "clamped is acknowledged: reading it tells";
    EXPECT_EQ(gain, 3);
    EXPECT_EQ(trim, -10);
    EXPECT_EQ(big, 100u);
    answer(bench.device, write(0, wire(-std::numeric_limits<float>::infinity())));
    EXPECT_EQ(gain, -2);
    EXPECT_EQ(answer(bench.device, write(0, wire(std::nanf("")))), silence) << "nothing is nearest to what is no number";
    EXPECT_EQ(gain, -2);
    EXPECT_EQ(bench.device.counters().refused, 1u);
    answer(bench.device, write(1, wire(std::int8_t{127})));
    EXPECT_EQ(trim, 127) << "no limit but that of the type";
}

TEST(Parameters, at_or_beyond_the_count_get_no_response) {
    Bench bench;
    std::uint8_t one = 1;
    bench.parameters.add("ONE", one);
    for (const std::uint16_t id : std::initializer_list<std::uint16_t>{1, 2, 255, 256, 65535})
        for (const auto& frame : {read(id), describe(id), write(id, {5})}) EXPECT_EQ(answer(bench.device, frame), silence) << id;
    EXPECT_EQ(bench.device.counters().unknown, 15u);
    EXPECT_EQ(one, 1);
    EXPECT_FALSE(bench.device.crashed());
}

TEST(Parameters, may_be_functions_that_reject_values) {
    Bench bench;
    std::int64_t even = 2;
    Parameter row{.name = "EVEN", .type = Type::i32, .get = [&] { return Value{even}; }, .initial = std::int64_t{2}};
    row.set = [&](const Value& v) {
        if (std::get<std::int64_t>(v) % 2 != 0) return false;
        even = std::get<std::int64_t>(v);
        return true;
    };
    bench.parameters.add(row);
    EXPECT_EQ(answer(bench.device, write(0, wire(std::int32_t{5}))), silence);
    EXPECT_EQ(even, 2);
    EXPECT_NE(answer(bench.device, write(0, wire(std::int32_t{6}))), silence);
    EXPECT_EQ(even, 6);

    row.name = "SERIAL";
    row.set = {};
    bench.parameters.add(row);
    EXPECT_EQ(answer(bench.device, write(1, wire(std::int32_t{8}))), silence) << "it can't be written";
    EXPECT_EQ(even, 6);
    EXPECT_TRUE(bench.parameters.restore_defaults()) << "nor is it restored";
}

TEST(Parameters, whose_function_returns_a_value_of_another_type_are_not_sent) {
    Bench bench;
    Value now = std::int64_t{1};
    bench.parameters.add({.name = "ODD", .type = Type::u8, .get = [&] { return now; }, .initial = std::int64_t{0}});
    EXPECT_EQ(answer(bench.device, read(0)), value(0, {1}));
    now = 1.5;
    EXPECT_EQ(answer(bench.device, read(0)), silence);
    EXPECT_EQ(bench.device.counters().refused, 1u);
}

TEST(Parameters, are_restored_to_their_initial_values) {
    Bench bench;
    EXPECT_EQ(answer(bench.device, act(0xAA)), silence) << "there is nothing to restore";
    float gain = 0.5f;
    std::string name = "a";
    bench.parameters.add("GAIN", gain);
    bench.parameters.add("NAME", name);
    gain = 7;
    name = "b";
    EXPECT_EQ(answer(bench.device, act(0xAA)), acknowledges(act(0xAA)));
    EXPECT_EQ(gain, 0.5f);
    EXPECT_EQ(name, "a");
}

TEST(Parameters, are_saved_by_the_user) {
    Bench bench;
    EXPECT_EQ(answer(bench.device, act(0xAB)), silence) << "there is nowhere to save to";
    EXPECT_EQ(bench.device.counters().unknown, 1u);
    int saved = 0;
    bool works = true;
    bench.parameters.on_save([&] { return ++saved, works; });
    EXPECT_EQ(answer(bench.device, act(0xAB)), acknowledges(act(0xAB)));
    works = false;
    EXPECT_EQ(answer(bench.device, act(0xAB)), silence) << "not saved, not acknowledged";
    EXPECT_EQ(saved, 2);
    EXPECT_EQ(bench.device.counters().refused, 1u);
}

TEST(Parameters, have_actions_of_the_user) {
    Bench bench;
    int done = 0;
    EXPECT_EQ(answer(bench.device, act(0x4321)), silence);
    bench.parameters.on(0x4321, [&] { return ++done, true; });
    bench.parameters.on(Action::restore_defaults, [&] { return ++done, true; });
    EXPECT_NE(answer(bench.device, act(0x4321)), silence);
    EXPECT_NE(answer(bench.device, act(0xAA)), silence);
    EXPECT_EQ(done, 2);
}

TEST(Parameters, of_the_calibration_have_the_names_that_hosts_expect) {
    Bench bench;
    std::array<float, 15> accelerometer{};
    std::array<float, 6> compass{};
    for (const std::uint16_t action : std::initializer_list<std::uint16_t>{0x20, 0x21, 0x30, 0x31})
        EXPECT_EQ(answer(bench.device, act(action)), silence) << "none";
    bench.parameters.add_accelerometer_calibration(accelerometer);
    bench.parameters.add_compass_calibration(compass);
    const char* const names[]{"CAL_AOFF_X", "CAL_AOFF_Y", "CAL_AOFF_Z", "CAL_ASEN_X", "CAL_ASEN_Y", "CAL_ASEN_Z", "CAL_AEM1_X",
                              "CAL_AEM1_Y", "CAL_AEM1_Z", "CAL_AEM2_X", "CAL_AEM2_Y", "CAL_AEM2_Z", "CAL_AEM3_X", "CAL_AEM3_Y",
                              "CAL_AEM3_Z", "CAL_MOFF_X", "CAL_MOFF_Y", "CAL_MOFF_Z", "CAL_MSEN_X", "CAL_MSEN_Y", "CAL_MSEN_Z"};
    ASSERT_EQ(bench.parameters.count(), std::size(names));
    for (std::uint16_t id = 0; id < std::size(names); ++id)
        EXPECT_EQ(answer(bench.device, describe(id)), info(id, 8, names[id], ""));
    EXPECT_EQ(accelerometer, (std::array<float, 15>{0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1}));

    accelerometer.fill(2);
    compass.fill(2);
    EXPECT_EQ(answer(bench.device, act(0x20)), acknowledges(act(0x20)));
    EXPECT_EQ(accelerometer[3], 1) << "raw values are sent";
    EXPECT_EQ(compass[0], 2);
    EXPECT_EQ(answer(bench.device, act(0x30)), acknowledges(act(0x30)));
    EXPECT_EQ(compass, (std::array<float, 6>{0, 0, 0, 1, 1, 1}));
    EXPECT_EQ(answer(bench.device, act(0x21)), silence) << "not stored";
    int saved = 0;
    bench.parameters.on_save([&] { return ++saved, true; });
    EXPECT_EQ(answer(bench.device, act(0x21)), acknowledges(act(0x21)));
    EXPECT_EQ(answer(bench.device, act(0x31)), acknowledges(act(0x31)));
    EXPECT_EQ(saved, 2);
}

TEST(Parameters, can_also_be_written_by_their_program) {
    Bench bench;
    float gain = 1;
    bench.parameters.add("GAIN", gain, {.max = 3});
    EXPECT_TRUE(bench.parameters.write("GAIN", 2.5));
    EXPECT_EQ(gain, 2.5f);
    EXPECT_TRUE(bench.parameters.write("GAIN", 9.0));
    EXPECT_EQ(gain, 3);
    EXPECT_FALSE(bench.parameters.write("GAIN", std::int64_t{2}));
    EXPECT_FALSE(bench.parameters.write("GAIN", std::string{"2"}));
    EXPECT_FALSE(bench.parameters.write("PAIN", 2.0));
    EXPECT_EQ(gain, 3);
}

TEST(Parameters, that_are_invalid_are_rejected) {
    Bench bench;
    float f = 1;
    double d = 1;
    bench.parameters.add("F", f);
    EXPECT_THROW(bench.parameters.add("F", d), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add("", d), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add(std::string(21, 'n'), d), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add("CAL_AOFF_X", d), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add("D", d, {.min = 2, .max = 1}), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add("D", d, {.min = 2}), std::invalid_argument) << "its default is beyond its limits";
    EXPECT_THROW(bench.parameters.add("D", d, {.max = std::nan("")}), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add({.name = "G", .type = Type::f32, .initial = 0.0}), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add({.name = "G", .type = Type::ip, .get = [] { return Value{}; }}), std::invalid_argument);
    EXPECT_THROW(bench.parameters.add({.name = "G", .type = Type::u8, .get = [] { return Value{}; }, .initial = 1.0}),
                 std::invalid_argument);
    EXPECT_EQ(bench.parameters.count(), 1u);
}

}    // namespace
}    // namespace parameters_tests
