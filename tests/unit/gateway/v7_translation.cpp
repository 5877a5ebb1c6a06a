#include <gateway/v7_translation.hpp>

#include <ano/wire.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

namespace v7_translation_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::hex;
using support::v7_frame;
using Frames = std::vector<Bytes>;

namespace {

const support::V7Vectors& vectors() {
    static const support::V7Vectors all = support::v7_vectors();
    return all;
}
const support::V7Vectors::Pair& pair(std::string_view meaning) {
    for (const auto& row : vectors().pairs)
        if (row.meaning.starts_with(meaning)) return row;
    throw std::out_of_range{std::string{meaning}};
}

Frames split_v7(std::span<const std::uint8_t> bytes) {
    Frames frames;
    while (const auto one = ano::v7::frame_at(bytes)) {
        frames.emplace_back(one->bytes().begin(), one->bytes().end());
        bytes = bytes.subspan(one->bytes().size());
    }
    EXPECT_TRUE(bytes.empty()) << "whole frames only";
    return frames;
}

struct Line {
    explicit Line(std::uint8_t address) : Line{v7_settings_for(address)} {}
    explicit Line(const V7Settings& settings) : translation{settings} {}

    V7Translation translation;
    ano::TimePoint now{1h};

    const V7Counters& counters() const { return translation.counters(); }
    Frames up(const Bytes& v7) {
        translation.receive(ano::v7::FrameView{v7}, now);
        return hosts();
    }
    Frames down(const Bytes& v8) {
        translation.send(ano::FrameView{v8}, now);
        return device();
    }
    Frames hosts() {
        const auto split = support::split(translation.to_hosts());
        EXPECT_TRUE(split.rest.empty());
        translation.clear_to_hosts();
        return split.frames;
    }
    Frames device() {
        const Frames frames = split_v7(translation.to_device());
        translation.clear_to_device();
        return frames;
    }
    Frames wait(ano::Duration time) {
        now += time;
        translation.repeat(now);
        return device();
    }
    // Anything, so that the device was heard.
    void hear() { up(v7_frame(0xAF, 0x06, {1, 0, 0, 0, 0})); }
};

Bytes v7_check(const Bytes& acknowledged) {
    const ano::v7::FrameView sent{acknowledged};
    return v7_frame(0xAF, 0x00, {sent.id(), sent.checks().sum, sent.checks().add});
}
Bytes v8_check(const Bytes& acknowledged, std::uint8_t from) {
    const ano::FrameView sent{acknowledged};
    return frame(from, sent.source(), 0x00, {sent.id(), sent.checks().sum, sent.checks().add});
}

// ---- The vectors: every pair

TEST(V7Pairs, commands_and_their_check_frames) {
    Line line{0xDC};
    for (const std::string_view meaning : {"unlock, C0 of 11 bytes", "unlock, C0 of 3 bytes"})
        EXPECT_EQ(line.down(pair(meaning).v8), Frames{pair(meaning).v7}) << meaning;
    EXPECT_EQ(line.up(pair("check frame of the unlock of 3").v7), Frames{v8_check(pair("unlock, C0 of 11 bytes").v8, 0xDC)})
        << "equal V7 frames: the first one first";
    EXPECT_EQ(line.up(pair("check frame of the unlock of 3").v7), Frames{pair("check frame of the unlock of 3").v8});

    const Bytes take_off = frame(0xFE, 0xDC, 0xC0, {0x10, 0x00, 0x05, 0x96, 0x00});
    EXPECT_EQ(line.down(take_off), Frames{vectors().frame(4)});
    EXPECT_EQ(line.up(vectors().pairs[2].v7), Frames{v8_check(take_off, 0xDC)}) << "0x00 of 3F 59";
}

TEST(V7Pairs, check_frame_vectors_are_those_of_the_frames_they_name) {
    // The V8 frames whose checks the vectors name: take-off of 11 bytes, write of parameter 11.
    Line line{0xDC};
    const Bytes take_off = frame(0xFE, 0xDC, 0xC0, {0x10, 0x00, 0x05, 0x96, 0x00, 0, 0, 0, 0, 0, 0});
    line.down(take_off);
    EXPECT_EQ(line.up(vectors().pairs[2].v7), Frames{v8_check(take_off, 0xDC)});
    V7Settings by_number = v7_settings_for(0xDC);
    by_number.parameters = {};
    Line plain{by_number};
    const Bytes write = frame(0xFE, 0xDC, 0xE1, {11, 0, 0xE8, 0x03, 0, 0});
    EXPECT_EQ(plain.down(write), Frames{vectors().frame(17)});
    EXPECT_EQ(plain.up(pair("its check frame").v7).size(), 0u) << "of another frame";
    EXPECT_EQ(plain.up(vectors().pairs[4].v7), Frames{vectors().pairs[4].v8});
}

TEST(V7Pairs, reading_a_parameter) {
    V7Settings by_number = v7_settings_for(0xDC);
    by_number.parameters = {};
    Line line{by_number};
    EXPECT_EQ(line.down(pair("read parameter 11").v8), Frames{pair("read parameter 11").v7});
    EXPECT_EQ(line.up(vectors().frame(16)), Frames{frame(0xDC, 0xFE, 0xE1, {11, 0, 0xE8, 0x03, 0, 0})});
    EXPECT_FALSE(line.translation.deadline());
}

TEST(V7Pairs, of_the_lx_imu) {
    Line line{0xDD};
    EXPECT_EQ(line.up(pair("01, v7_acc=lx").v7), Frames{pair("01, v7_acc=lx").v8});
    EXPECT_EQ(line.up(pair("02, v7_temp=100").v7), Frames{pair("02, v7_temp=100").v8});
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x08, {1, 0, 0, 0, 2, 0, 0, 0})), Frames{frame(0xDD, 0xFE, 0x08, {1, 0, 0, 0, 2, 0, 0, 0})})
        << "no 0x05 came yet";
    // "that 05": alt_fu 358 cm; alt_bar of the 0x02 above, -140419 + ... as sent
    const Bytes compass = pair("02, v7_temp=100").v7;
    const auto alt_bar = ano::load<std::int32_t>(&compass[10]);
    Bytes expected(13);
    ano::store(&expected[0], alt_bar);
    ano::store(&expected[8], std::int32_t{358});
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x05, {0x66, 1, 0, 0, 0, 0, 0, 0, 0})), Frames{frame(0xDD, 0xFE, 0x05, expected)});
    EXPECT_EQ(line.up(pair("08 after that 05").v7), Frames{pair("08 after that 05").v8});
}

TEST(V7Pairs, positions_values_and_flow) {
    Line line{0xDC};
    EXPECT_EQ(line.down(pair("32, host to device").v8), Frames{pair("32, host to device").v7});
    EXPECT_EQ(line.up(pair("A1 -5").v7), Frames{pair("A1 -5").v8});
    Line flow{0xDE};
    EXPECT_EQ(flow.up(pair("51 mode 1").v7), Frames{pair("51 mode 1").v8});
}

// ---- From the device

TEST(V7Up, what_is_the_same_passes_with_its_data) {
    Line line{0xDD};
    for (const int number : {22, 23, 25, 26, 28, 29, 31, 32, 34, 35, 52}) {
        const Bytes& v7 = vectors().frame(number);
        const ano::v7::FrameView view{v7};
        const std::uint8_t to = view.destination() == 0xAF ? 0xFE : 0xFF;
        EXPECT_EQ(line.up(v7), Frames{frame(0xDD, to, view.id(), {view.data().begin(), view.data().end()})}) << number;
    }
}

TEST(V7Up, addresses_have_their_counterparts) {
    Line line{0xDD};
    const std::map<int, int> known{{0xAF, 0xFE}, {0xFF, 0xFF}, {0x05, 0xDC}, {0x10, 0xE6}, {0x22, 0xDE},
                                   {0x60, 0xDD}, {0x61, 0xDB}, {0x66, 0xFE}, {0x30, 0x30}, {199, 199}};
    for (const auto& [v7, v8] : known)
        EXPECT_EQ(line.up(v7_frame(static_cast<std::uint8_t>(v7), 0x06, {1})),
                  Frames{frame(0xDD, static_cast<std::uint8_t>(v8), 0x06, {1})});
    for (const int nobody : {0, 200, 0xFE, 0xD2})
        EXPECT_EQ(line.up(v7_frame(static_cast<std::uint8_t>(nobody), 0x06, {1})), Frames{});
    EXPECT_EQ(line.counters().up_no_address, 4u);
}

TEST(V7Up, single_ids_come_from_other_devices) {
    V7Settings s = v7_settings_for(0xDD);
    s.sources[0xF6] = 0xDB;
    Line line{s};
    EXPECT_EQ(ano::FrameView{line.up(vectors().frame(32)).at(0)}.source(), 0xDB);
    EXPECT_EQ(ano::FrameView{line.up(vectors().frame(22)).at(0)}.source(), 0xDD);
    EXPECT_EQ(line.down(frame(0xFE, 0xDB, 0xC0, {0x10, 0, 1})).size(), 1u);
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{v8_check(frame(0xFE, 0xDB, 0xC0, {0x10, 0, 1}), 0xDB)})
        << "by the id that was asked";
}

TEST(V7Up, acceleration_and_gyroscope_are_scaled_and_saturate) {
    const auto inertial = [](std::int16_t acc, std::int16_t gyr) {
        Bytes data(13);
        ano::store(&data[0], acc);
        ano::store(&data[6], gyr);
        return data;
    };
    const auto result = [&](V7Acceleration acceleration, std::int16_t acc, std::int16_t gyr) {
        V7Settings s = v7_settings_for(0xDB);
        s.acceleration = acceleration;
        Line line{s};
        const Bytes v8 = line.up(v7_frame(0xAF, 0x01, inertial(acc, gyr))).at(0);
        return std::pair{ano::load<std::int16_t>(&v8[6]), ano::load<std::int16_t>(&v8[12])};
    };
    using Pair = std::pair<std::int16_t, std::int16_t>;
    EXPECT_EQ(result({}, 1355, -5), (Pair{1355, -5}));
    EXPECT_EQ(result(v7_acceleration_of_lx, 1355, -5), (Pair{973, -5}));
    EXPECT_EQ(result(v7_acceleration_of_flow, 2048, 7), (Pair{981, 7}));
    EXPECT_EQ(result({V7Acceleration::Unit::cmss, 0}, 981, 100), (Pair{981, 1638}));
    EXPECT_EQ(result({V7Acceleration::Unit::cmss, 0}, 981, -3000), (Pair{981, -32768}));
    EXPECT_EQ(result({V7Acceleration::Unit::per_g, 1}, 100, 0), (Pair{32767, 0}));
}

TEST(V7Up, altitude_of_an_old_compass_frame_is_not_used) {
    const Bytes altitude = v7_frame(0xAF, 0x05, {0x66, 1, 0, 0, 0, 0, 0, 0, 0});
    Line line{0xDD};
    EXPECT_EQ(line.up(altitude).at(0).size(), 8u + 9u) << "no 0x02 yet: V7's own layout";
    line.up(pair("02, v7_temp=100").v7);
    line.now += 999ms;
    EXPECT_EQ(line.up(altitude).at(0).size(), 8u + 13u);
    line.now += 1ms;
    EXPECT_EQ(line.up(altitude).at(0).size(), 8u + 9u);
}

TEST(V7Up, layouts_are_kept_where_that_is_set) {
    V7Settings s = v7_settings_for(0xDD);
    s.keeps_layout = true;
    Line line{s};
    EXPECT_EQ(line.up(pair("02, v7_temp=100").v7).at(0).size(), 8u + 14u);
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x05, Bytes(9))).at(0).size(), 8u + 9u);
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x08, Bytes(8))).at(0).size(), 8u + 8u);
    EXPECT_EQ(line.up(vectors().frame(40)).at(0).size(), 8u + 7u);
}

TEST(V7Up, positions_become_millimetres_and_saturate) {
    Line line{0xDD};
    EXPECT_EQ(line.up(vectors().frame(38)), Frames{frame(0xDD, 0xFF, 0x32, hex("B0040000 3EFEFFFF 00000080"))});
    Bytes far(12);
    ano::store(&far[0], std::int32_t{INT32_MAX});
    ano::store(&far[4], std::int32_t{INT32_MIN + 1});
    const Bytes v8 = line.up(v7_frame(0xFF, 0x32, far)).at(0);
    EXPECT_EQ(ano::load<std::int32_t>(&v8[6]), INT32_MAX);
    EXPECT_EQ(ano::load<std::int32_t>(&v8[10]), -INT32_MAX) << "INT32_MIN would mean: no data";
}

TEST(V7Up, distances_by_every_meaning_of_the_direction) {
    const auto type_of = [](V7Range range, std::uint8_t direction, std::uint16_t angle) {
        V7Settings s = v7_settings_for(0xDD);
        s.range = range;
        Line line{s};
        Bytes data(7);
        data[0] = direction;
        ano::store(&data[1], angle);
        ano::store(&data[3], 75u);
        const Frames frames = line.up(v7_frame(0xFF, 0x34, data));
        if (frames.empty()) return -1;
        const Bytes& v8 = frames[0];
        if (v8[6] == 100) {
            EXPECT_EQ(ano::load<std::uint16_t>(&v8[7]), angle * 100);
            EXPECT_EQ(ano::load<std::uint16_t>(&v8[9]), 75);
        } else {
            EXPECT_EQ(ano::load<std::int32_t>(&v8[7]), 750);
        }
        return int{v8[6]};
    };
    EXPECT_EQ(type_of(V7Range::lx, 0, 270), 6);
    EXPECT_EQ(type_of(V7Range::lx, 1, 270), 6);
    EXPECT_EQ(type_of(V7Range::lx, 1, 90), 5);
    EXPECT_EQ(type_of(V7Range::lx, 0, 0), 1);
    EXPECT_EQ(type_of(V7Range::lx, 0, 180), 2);
    EXPECT_EQ(type_of(V7Range::lx, 0, 90), 4);
    EXPECT_EQ(type_of(V7Range::lx, 0, 45), 100);
    EXPECT_EQ(type_of(V7Range::lx, 1, 45), -1);
    EXPECT_EQ(type_of(V7Range::lx, 0, 360), -1);
    EXPECT_EQ(type_of(V7Range::doc, 0, 270), 3);
    EXPECT_EQ(type_of(V7Range::doc, 1, 270), 6);
    for (const int direction : {0, 1, 2, 3, 4, 5})
        EXPECT_EQ(type_of(V7Range::flow, static_cast<std::uint8_t>(direction), 0),
                  (std::array{6, 5, 1, 2, 3, 4}[static_cast<std::size_t>(direction)]));
    EXPECT_EQ(type_of(V7Range::flow, 6, 0), -1);
}

TEST(V7Up, a_distance_that_is_not_valid_is_counted_only) {
    Line line{0xDD};
    EXPECT_EQ(line.up(vectors().frame(43)), Frames{});
    EXPECT_EQ(line.counters().up_no_distance, 1u);
}

TEST(V7Up, lengths_that_a_message_does_not_have_are_counted_only) {
    Line line{0xDD};
    for (const int id : {0x00, 0x01, 0x02, 0x05, 0x08, 0x32, 0x34, 0x60, 0x61, 0xA1, 0xE0, 0xE1, 0xE2})
        EXPECT_EQ(line.up(v7_frame(0xAF, static_cast<std::uint8_t>(id), {})), Frames{}) << id;
    EXPECT_EQ(line.counters().up_malformed, 13u);
}

TEST(V7Up, messages_that_v8_has_under_the_same_id_with_another_meaning_are_counted_only) {
    Line line{0xDD};
    for (const int id : {0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xC0, 0xC1, 0xC2, 0xE3, 0xF0, 0xFB})
        EXPECT_EQ(line.up(v7_frame(0xAF, static_cast<std::uint8_t>(id), Bytes(20))), Frames{}) << id;
    EXPECT_EQ(line.counters().up_no_counterpart, 11u);
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x11, {1, 2})), Frames{frame(0xDD, 0xFE, 0x11, {1, 2})}) << "private: passes";
}

TEST(V7Up, command_of_a_panel_and_its_acknowledgement) {
    Line line{0xDB};
    const Bytes command = frame(0xDB, 0xFF, 0xC0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(line.up(vectors().frame(1)), Frames{command});
    const ano::FrameView sent{command};
    EXPECT_EQ(line.down(frame(0xDC, 0xDB, 0x00, {0xC0, sent.checks().sum, sent.checks().add})),
              Frames{v7_frame(0xFF, 0x00, {0xE0, 0xA5, 0x85})});
    EXPECT_EQ(line.up(v7_frame(0x05, 0xE1, {7, 0})), Frames{frame(0xDB, 0xDC, 0xE0, {2, 7, 0})});
}

// ---- To the device

TEST(V7Down, only_what_is_for_a_device_of_the_link) {
    V7Settings s = v7_settings_for(0xDD);
    s.port = 7;
    Line line{s};
    for (const int to : {0xDD, 0xFF, 7})
        EXPECT_EQ(line.down(frame(0xFE, static_cast<std::uint8_t>(to), 0xC0, {0x10, 0, 1})).size(), 1u);
    for (const int to : {0xDC, 0xFE, 8, 0})
        EXPECT_EQ(line.down(frame(0xFE, static_cast<std::uint8_t>(to), 0xC0, {0x10, 0, 1})), Frames{});
    EXPECT_EQ(line.counters().down_not_ours, 4u);
}

TEST(V7Down, receivers_of_parameters_are_named_and_others_not) {
    const std::map<int, int> receivers{{0xDC, 0x05}, {0xDD, 0x60}, {0xDB, 0x61}, {0xDE, 0x22}, {0xE6, 0x10}, {48, 0xFF}};
    for (const auto& [v8, v7] : receivers) {
        V7Settings s = v7_settings_for(static_cast<std::uint8_t>(v8));
        s.parameters = {};
        Line line{s};
        EXPECT_EQ(line.down(frame(0xFE, s.address, 0xE0, {2, 10, 0})),
                  Frames{v7_frame(static_cast<std::uint8_t>(v7), 0xE1, {10, 0})});
        EXPECT_EQ(line.down(frame(0xFE, s.address, 0x40, Bytes(20, 1))), Frames{v7_frame(0xFF, 0x40, Bytes(20, 1))});
        s.destination = 0x61;
        Line set{s};
        EXPECT_EQ(set.down(frame(0xFE, s.address, 0xE0, {2, 10, 0})), Frames{v7_frame(0x61, 0xE1, {10, 0})});
    }
}

TEST(V7Down, what_v7_cannot_say_is_counted_by_cause) {
    Line line{0xDD};
    for (const int id : {0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xE2, 0xE3, 0xF0, 0xFB})
        EXPECT_EQ(line.down(frame(0xFE, 0xDD, static_cast<std::uint8_t>(id), Bytes(9))), Frames{}) << id;
    EXPECT_EQ(line.counters().down_no_counterpart, 9u);
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xF1, {})), Frames{});
    EXPECT_EQ(line.counters().down_no_counterpart, 10u) << "devices refuse LEN 0";
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xF1, Bytes(45))), Frames{});
    EXPECT_EQ(line.counters().down_too_long, 1u);
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xF1, Bytes(44))).size(), 1u);
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0x11, {1})), Frames{});
    EXPECT_EQ(line.counters().down_not_allowed, 1u);
}

TEST(V7Down, distances_and_scans) {
    Line lx{0xDD};
    const auto one = [](std::uint8_t type) { return frame(0xFE, 0xDD, 0x34, {type, 0xEE, 2, 0, 0}); };    // 750 mm
    EXPECT_EQ(lx.down(one(6)), Frames{vectors().frame(40)});
    EXPECT_EQ(lx.down(one(0)), Frames{vectors().frame(40)});
    EXPECT_EQ(lx.down(one(3)), Frames{}) << "the LX code takes {0, 270} for down";
    EXPECT_EQ(lx.down(frame(0xFE, 0xDD, 0x34, hex("64 2823 4B00 7869 4B00 9411 4B00"))),
              (Frames{v7_frame(0xFF, 0x34, hex("00 5A00 4B000000")), v7_frame(0xFF, 0x34, hex("00 2D00 4B000000"))}))
        << "90.00, 270.00 and 45.00 degrees: 270 would be down";
    V7Settings s = v7_settings_for(0xDD);
    s.range = V7Range::doc;
    Line doc{s};
    EXPECT_EQ(doc.down(one(6)), Frames{vectors().frame(41)});
    EXPECT_EQ(doc.down(one(3)), Frames{vectors().frame(40)});
    EXPECT_EQ(doc.down(frame(0xFE, 0xDD, 0x34, {6, 0xFF, 0xFF, 0xFF, 0xFF})), Frames{}) << "negative";
}

TEST(V7Down, numbers_with_text_are_rounded_and_must_fit) {
    V7Settings s = v7_settings_for(0xDC);
    s.down.set(0xA1);
    Line line{s};
    Bytes data = hex("00000000 657272");
    ano::store(&data[0], -4.6f);
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xA1, data)), Frames{v7_frame(0xFF, 0xA1, hex("FBFFFFFF 657272"))});
    for (const float value : {3e9f, -3e9f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        ano::store(&data[0], value);
        EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xA1, data)), Frames{});
    }
}

// ---- The laws

TEST(V7Law, nothing_of_the_devices_own_sensors_is_sent_to_it) {
    V7Settings s = v7_settings_for(0xDD);
    s.down.set();    // whatever v7_down says
    Line line{s};
    for (unsigned id = 0; id < 256; ++id) {
        for (std::size_t size = 0; size < 45; ++size) {
            line.now += 10s;
            for (const Bytes& sent : line.down(frame(0xFE, 0xDD, static_cast<std::uint8_t>(id), Bytes(size, 1)))) {
                EXPECT_FALSE(v7_is_own_sensor(ano::v7::FrameView{sent}.id())) << id;
                EXPECT_NE(ano::v7::FrameView{sent}.data().size(), 0u);
            }
            line.wait(1s);
        }
    }
}

TEST(V7Law, the_command_that_erases_the_firmware_is_never_sent) {
    Line line{0xDD};
    for (unsigned last = 0; last < 9; ++last) {
        EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xC0, {0x01, 0x20, 0xAA, static_cast<std::uint8_t>(last)})), Frames{});
        EXPECT_EQ(line.down(frame(0xFE, 0xFF, 0xC0, {0x01, 0x20, 0xAA, static_cast<std::uint8_t>(last), 0, 0, 0, 0, 0, 0, 0})),
                  Frames{});
    }
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xC0, {0x01, 0x20, 0xAA})), Frames{});
    EXPECT_EQ(line.counters().down_refused, 19u);
}

TEST(V7Law, a_command_or_write_is_sent_exactly_as_often_as_the_host_sent_it) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        support::Random random{seed};
        V7Settings s = v7_settings_for(0xDC);
        s.parameters = {};
        Line line{s};
        std::map<Bytes, int> wanted, sent;
        const auto note = [&](const Frames& frames) {
            for (const Bytes& bytes : frames) {
                const auto id = ano::v7::FrameView{bytes}.id();
                if (id != 0xE1 && id != 0x60) ++sent[bytes];
                if (random.one_in(3)) line.up(v7_check(bytes));
            }
        };
        for (int i = 0; i < 60; ++i) {
            const auto value = random.below(std::uint8_t{3});
            switch (random.below(4)) {
            case 0:
                ++wanted[v7_frame(0xFF, 0xE0, {0x10, 0, value, 0, 0, 0, 0, 0, 0, 0, 0})];
                note(line.down(frame(0xFE, 0xDC, 0xC0, {0x10, 0, value})));
                break;
            case 1:
                ++wanted[v7_frame(0x05, 0xE2, {value, 0, 1, 2, 3, 4})];
                note(line.down(frame(0xFE, 0xDC, 0xE1, {value, 0, 1, 2, 3, 4})));
                break;
            case 2:
                ++wanted[v7_frame(0xFF, 0x61, Bytes(22, value))];
                note(line.down(frame(0xFE, 0xDC, 0x61, Bytes(22, value))));
                break;
            default: note(line.down(frame(0xFE, 0xDC, 0xE0, {2, value, 0}))); break;
            }
            note(line.wait(random.of<ano::Duration>({0ms, 10ms, 200ms, 900ms})));
        }
        for (int i = 0; i < 100; ++i) note(line.wait(200ms));
        EXPECT_EQ(sent, wanted) << "seed " << seed;
    }
}

TEST(V7Law, an_emergency_stop_does_not_wait_behind_questions) {
    Line line{0xDC};
    for (std::uint8_t i = 0; i < 17; ++i) line.down(frame(0xFE, 0xDC, 0xE0, {2, i, 0}));
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xC0, {0x10, 0, 2})), Frames{vectors().frame(2)});
}

// ---- Acknowledgements

TEST(V7Acknowledgement, goes_to_the_host_that_asked_and_only_once) {
    Line line{0xDC};
    const Bytes one = frame(0xFE, 0xDC, 0xC0, {0x10, 0, 1}), other = frame(0xD2, 0xFF, 0xC0, {0x10, 0, 1});
    line.down(one);
    line.down(other);
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{v8_check(one, 0xDC)});
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{v8_check(other, 0xDC)}) << "asked by broadcast: from the device";
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{});
    EXPECT_EQ(line.counters().up_unmatched_check, 1u);
}

TEST(V7Acknowledgement, is_not_passed_on_after_a_second) {
    Line line{0xDC};
    line.down(frame(0xFE, 0xDC, 0xC0, {0x10, 0, 1}));
    line.now += 1001ms;
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{});
}

TEST(V7Acknowledgement, comes_from_the_gateway_where_that_is_set) {
    V7Settings s = v7_settings_for(0xDB);
    s.acknowledges_sent = true;
    Line line{s};
    const Bytes command = frame(0xFE, 0xDB, 0xC0, {0x10, 0, 1});
    EXPECT_EQ(line.down(command), Frames{vectors().frame(1)});
    EXPECT_EQ(line.hosts(), Frames{v8_check(command, 0xDB)});
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{}) << "no second one";
    line.down(frame(0xFE, 0xDB, 0xC0, {1, 0x20, 0xAA}));
    EXPECT_EQ(line.hosts(), Frames{}) << "of what was not sent, none";
}

// ---- Questions for values

TEST(V7Questions, are_repeated_twice_and_one_is_under_way) {
    Line line{0xDC};    // with the table: row 0 is number 1
    const auto read = [](std::uint8_t number) { return Frames{v7_frame(0x05, 0xE1, {number, 0})}; };
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xE0, {2, 0, 0})), read(1));
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xE0, {2, 1, 0})), Frames{});
    EXPECT_EQ(line.wait(199ms), Frames{});
    EXPECT_EQ(line.wait(1ms), read(1));
    EXPECT_EQ(line.wait(200ms), read(1));
    EXPECT_EQ(line.wait(200ms), read(2)) << "the first one is given up";
    EXPECT_EQ(line.up(v7_frame(0xAF, 0xE2, {2, 0, 9, 0, 0, 0})), Frames{frame(0xDC, 0xFE, 0xE1, {1, 0, 9, 0, 0, 0})});
    EXPECT_FALSE(line.translation.deadline());
    EXPECT_EQ(line.counters().unanswered, 1u);
}

TEST(V7Questions, of_two_hosts_each_get_an_answer_in_turn) {
    Line line{0xDC};
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xE0, {2, 0, 0})).size(), 1u);
    EXPECT_EQ(line.down(frame(0xD2, 0xDC, 0xE0, {2, 0, 0})).size(), 0u);
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0xE0, {2, 0, 0})).size(), 0u) << "asked already";
    const Bytes answer = v7_frame(0xAF, 0xE2, {1, 0, 5, 0, 0, 0});
    EXPECT_EQ(line.up(answer), Frames{frame(0xDC, 0xFE, 0xE1, {0, 0, 5, 0, 0, 0})});
    EXPECT_EQ(line.device().size(), 1u) << "now the other one";
    EXPECT_EQ(line.up(answer), Frames{frame(0xDC, 0xD2, 0xE1, {0, 0, 5, 0, 0, 0})});
    EXPECT_EQ(line.counters().down_asked_already, 1u);
}

TEST(V7Questions, above_sixteen_that_wait_are_dropped) {
    Line line{0xDC};
    for (std::uint8_t i = 0; i < 20; ++i) line.down(frame(0xFE, 0xDC, 0xE0, {2, i, 0}));
    EXPECT_EQ(line.counters().down_busy, 3u);
}

TEST(V7Questions, about_waypoints) {
    Line line{0xDC};
    EXPECT_EQ(line.down(frame(0xFE, 0xDC, 0x60, {0xFF})), Frames{v7_frame(0xFF, 0x60, {0xFF})});
    EXPECT_EQ(line.up(vectors().frame(50)), Frames{frame(0xDC, 0xFE, 0x60, {5})});
    EXPECT_EQ(line.down(frame(0xD2, 0xDC, 0x60, {3})), Frames{v7_frame(0xFF, 0x60, {3})});
    Bytes point(22);
    point[0] = 3;
    EXPECT_EQ(line.up(v7_frame(0xAF, 0x61, point)), Frames{frame(0xDC, 0xD2, 0x61, point)});
    EXPECT_FALSE(line.translation.deadline());
    const Bytes write = frame(0xFE, 0xDC, 0x61, point);
    const Frames sent = line.down(write);
    ASSERT_EQ(sent.size(), 1u);
    EXPECT_EQ(line.up(v7_check(sent[0])), Frames{v8_check(write, 0xDC)});
}

TEST(V7Questions, a_value_that_nobody_asked_for_goes_to_the_hosts) {
    Line line{0xDC};
    EXPECT_EQ(line.up(vectors().frame(16)), Frames{frame(0xDC, 0xFE, 0xE1, {4, 0, 0xE8, 3, 0, 0})}) << "number 11 is row 4";
    EXPECT_EQ(line.up(v7_frame(0xAF, 0xE2, {0x30, 0x75, 0, 0, 0, 0})), Frames{});
    EXPECT_EQ(line.counters().up_unknown_parameter, 1u);
}

// ---- What the gateway answers

TEST(V7Answers, come_only_while_the_device_is_heard) {
    Line line{0xDD};
    line.down(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_EQ(line.hosts(), Frames{});
    line.hear();
    line.now += 5s;
    line.down(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_EQ(line.hosts().size(), 1u);
    line.now += 1ms;
    line.down(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    EXPECT_EQ(line.hosts(), Frames{});
    EXPECT_EQ(line.counters().down_not_answered, 2u);
}

TEST(V7Answers, device_info_has_the_versions_that_were_heard) {
    Line line{0xDD};
    line.up(v7_frame(0xAF, 0xE2, {3, 0, 0x2A, 0, 0, 0}));
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xE0, {0, 0, 0})), Frames{}) << "nothing is sent";
    Bytes info{0xDD, 0, 0, 0x2A, 0, 0, 0, 0xBC, 0x02};
    for (const char c : std::string_view{"LX IMU (V7)"}) info.push_back(static_cast<std::uint8_t>(c));
    EXPECT_EQ(line.hosts(), Frames{frame(0xDD, 0xFE, 0xE3, info)});
}

TEST(V7Answers, parameters_are_described_by_the_table) {
    for (const std::uint8_t address : {std::uint8_t{0xDC}, std::uint8_t{0xDD}}) {
        Line line{address};
        line.hear();
        const auto table = line.translation.settings().parameters;
        line.down(frame(0xFE, address, 0xE0, {1, 0, 0}));
        EXPECT_EQ(line.hosts(), Frames{frame(address, 0xFE, 0xE0, {1, static_cast<std::uint8_t>(table.size()), 0})});
        for (std::size_t i = 0; i < table.size(); ++i) {
            EXPECT_LE(table[i].name.size(), 20u);
            if (i > 0) {
                EXPECT_LT(table[i - 1].number, table[i].number) << "no number twice";
            }
            line.down(frame(0xFE, address, 0xE0, {3, static_cast<std::uint8_t>(i), 0}));
            const Frames answer = line.hosts();
            ASSERT_EQ(answer.size(), 1u);
            EXPECT_EQ(answer[0][8], table[i].is_real ? 8 : 5);
        }
        line.down(frame(0xFE, address, 0xE0, {3, static_cast<std::uint8_t>(table.size()), 0}));
        EXPECT_EQ(line.hosts(), Frames{});
    }
    EXPECT_EQ(v7_parameters_of_lx().size(), 4u + 15u + 22u + 21u);
    EXPECT_EQ(v7_parameters_of_tkz().size(), 4u + 54u + 4u + 29u + 21u);
}

TEST(V7Answers, calibration_is_read_and_written_as_real_numbers) {
    Line line{0xDD};
    const auto table = line.translation.settings().parameters;
    const auto row = std::find_if(table.begin(), table.end(), [](const V7Parameter& p) { return p.number == 1003; });
    const auto index = static_cast<std::uint8_t>(row - table.begin());
    EXPECT_EQ(line.up(v7_frame(0xAF, 0xE2, hex("EB03 DC050000"))), Frames{frame(0xDD, 0xFE, 0xE1, {index, 0, 0, 0, 0xC0, 0x3F})})
        << "1.5";
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xE1, {index, 0, 0, 0, 0xC0, 0x3F})),
              Frames{v7_frame(0x60, 0xE2, hex("EB03 DC050000"))});
}

TEST(V7Answers, actions_on_all_parameters) {
    Line line{0xDD};
    line.hear();
    const auto command = [](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
        return Frames{v7_frame(0xFF, 0xE0, {a, b, c, 0, 0, 0, 0, 0, 0, 0, 0})};
    };
    const Bytes restore = frame(0xFE, 0xDD, 0xE0, {0x10, 0xAA, 0});
    const Frames sent = line.down(restore);
    EXPECT_EQ(sent, command(0x01, 0x00, 0xAC));
    EXPECT_EQ(line.up(v7_check(sent[0])), Frames{v8_check(restore, 0xDD)});
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xE0, {0x10, 0x20, 0})), command(0x01, 0x30, 0x01));
    EXPECT_EQ(line.down(frame(0xFE, 0xDD, 0xE0, {0x10, 0x30, 0})), command(0x01, 0x30, 0x02));
    line.hosts();
    for (const int action : {0xAB, 0x21, 0x31}) {
        const Bytes asked = frame(0xFE, 0xDD, 0xE0, {0x10, static_cast<std::uint8_t>(action), 0});
        EXPECT_EQ(line.down(asked), Frames{});
        EXPECT_EQ(line.hosts(), Frames{v8_check(asked, 0xDD)});
    }
}

TEST(V7Answers, commands_are_listed_without_the_one_that_erases) {
    for (const std::uint8_t address : {std::uint8_t{0xDC}, std::uint8_t{0xDE}}) {
        Line line{address};
        line.hear();
        line.down(frame(0xFE, address, 0xC1, {0, 0, 0}));
        const Bytes count = line.hosts().at(0);
        EXPECT_EQ(count[3], 0xC1);
        EXPECT_EQ(count[7], address == 0xDC ? 32 : 3);
        for (std::uint8_t i = 0; i < count[7]; ++i) {
            line.down(frame(0xFE, address, 0xC1, {1, i, 0}));
            const Bytes info = line.hosts().at(0);
            EXPECT_EQ(info[3], 0xC2);
            EXPECT_EQ(info[6], i);
            EXPECT_FALSE(info[8] == 0x01 && info[9] == 0x20);
            EXPECT_EQ(line.down(frame(0xFE, address, 0xC0, {info[8], info[9], info[10]})).size(), 1u) << "each can be run";
        }
    }
}

TEST(V7Translation, forgets_when_the_connection_is_gone) {
    Line line{0xDC};
    line.down(frame(0xFE, 0xDC, 0xC0, {0x10, 0, 1}));
    line.down(frame(0xFE, 0xDC, 0xE0, {2, 0, 0}));
    line.translation.forget();
    EXPECT_FALSE(line.translation.deadline());
    EXPECT_EQ(line.up(vectors().frame(13)), Frames{});
}

}    // namespace
}    // namespace v7_translation_tests
