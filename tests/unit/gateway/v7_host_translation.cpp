// The translation between V8 and a link with a V7 host program, which sees one V8 device (protocol-v7.md, section 8).
#include <gateway/v7_host_translation.hpp>

#include <ano/wire.hpp>
#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace v7_host_translation_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::operator+;
using support::v7_frame;
namespace v7 = ano::v7;

namespace {

using Frames = std::vector<Bytes>;
constexpr std::uint8_t fc = 0xDC, imu = 0xDD, host = 0xFE, everybody = 0xFF;
constexpr std::uint8_t u8_type = 0, i16_type = 3, i32_type = 5, f32_type = 8, string_type = 10;

struct HostLink final : V7Output {
    explicit HostLink(V7Settings settings) : translation{std::move(settings)} {}
    explicit HostLink(std::uint8_t address) : HostLink{V7Settings{.address = address, .max_data = 255}} {}

    V7HostTranslation translation;
    ano::TimePoint now{1h};
    Frames to_program, to_gateway;

    void to_device(v7::FrameView f) override {
        EXPECT_TRUE(v7::frame_at(f.bytes()));
        to_program.emplace_back(f.bytes().begin(), f.bytes().end());
    }
    void from_device(ano::FrameView f) override {
        EXPECT_TRUE(ano::frame_at(f.bytes()));
        to_gateway.emplace_back(f.bytes().begin(), f.bytes().end());
    }
    void forget() {
        to_program.clear();
        to_gateway.clear();
    }

    std::uint8_t device() const { return translation.settings().address; }
    /// What a frame of the host program becomes.
    Frames up(const Bytes& bytes) {
        forget();
        translation.up(v7::FrameView{bytes}, now, *this);
        return to_gateway;
    }
    Frames up(std::uint8_t id, const Bytes& data) { return up(v7_frame(0xFF, id, data)); }
    /// What the host program receives for a frame.
    Frames down(const Bytes& bytes) {
        forget();
        translation.down(ano::FrameView{bytes}, now, *this);
        return to_program;
    }
    Frames down(std::uint8_t id, const Bytes& data) { return down(frame(device(), host, id, data)); }
    /// What is sent to the device meanwhile.
    Frames pass(ano::Duration time) {
        forget();
        now += time;
        translation.expire(now, *this);
        return to_gateway;
    }
    /// The device describes a parameter.
    Frames describe(std::uint16_t index, std::uint8_t type) {
        Bytes data(23);
        ano::store(data.data(), index);
        data[2] = type;
        down(0xE2, data);
        return to_gateway;
    }
    const V7Counters& counted() const { return translation.counters(); }
};

std::uint64_t drops(const V7Counters& counters) {
    std::uint64_t n = 0;
    for (const auto& row : v7_counters)
        if (row.is_drop) n += counters.*row.value;
    return n;
}

template <class T>
Bytes wire(T value) {
    Bytes bytes(sizeof value);
    ano::store(bytes.data(), value);
    return bytes;
}
template <class... T>
Bytes pack(T... values) {
    return (Bytes{} + ... + wire(values));
}
Bytes u16(unsigned value) { return wire(static_cast<std::uint16_t>(value)); }
Bytes question(std::uint8_t command, unsigned value) { return Bytes{command} + u16(value); }
Bytes written(unsigned number, std::int32_t value) { return u16(number) + wire(value); }
Bytes check_of_v7(const Bytes& v7) { return {v7[2], v7[v7.size() - 2], v7[v7.size() - 1]}; }
Bytes check_of_v8(const Bytes& v8) { return {v8[3], v8[v8.size() - 2], v8[v8.size() - 1]}; }

// --- Vectors

TEST(V7HostTranslation, gives_the_pairs_of_the_vectors_in_the_opposite_direction) {
    std::size_t up = 0, down = 0;
    for (const auto& pair : support::v7_vectors("pair")) {
        const bool is_to_device = pair.v8[1] == host;
        HostLink link{is_to_device ? pair.v8[2] : pair.v8[1]};
        const std::uint8_t id = pair.v7[2];
        if (is_to_device && id != 0xE1) {
            if (id == 0xE0 && pair.v8[4] != 11) continue;    // V7 has no shorter command
            ++up;
            EXPECT_EQ(link.up(pair.v7), Frames{pair.v8}) << pair.meaning;
        } else if (is_to_device) {
            ++up;
            EXPECT_EQ(link.up(pair.v7), Frames{frame(host, fc, 0xE0, question(3, 11))}) << pair.meaning;
            EXPECT_EQ(link.describe(11, i32_type), Frames{pair.v8}) << pair.meaning;
        } else if (id != 0x00) {
            if (id == 0x02) link.down(0x05, pack(std::int32_t{28285}, std::int32_t{0}, std::int32_t{0}, std::uint8_t{0}));
            Bytes expected = pair.v7;
            if (id == 0x01) {    // the rounding of cm/s²
                ano::store(expected.data() + 6, std::int16_t{26});
                ano::store(expected.data() + 8, std::int16_t{1355});
                ano::seal(expected);
            }
            if (id == 0x02) {
                ano::store(expected.data() + 14, std::int16_t{4410});
                ano::seal(expected);
            }
            ++down;
            EXPECT_EQ(link.down(pair.v8), Frames{expected}) << pair.meaning;
        }
    }
    EXPECT_GE(up, 3u);
    EXPECT_GE(down, 5u);
}

TEST(V7HostTranslation, keeps_the_data_of_messages_that_are_the_same) {
    std::size_t n = 0;
    for (const auto& vector : support::v7_vectors("valid")) {
        const auto f = v7::frame_at(vector.v7);
        if (!v7::is_same_in_v8(f->id()) || f->id() == 0x00 || f->id() == 0x60 || f->data().empty()) continue;
        const Bytes data{f->data().begin(), f->data().end()};
        HostLink link{imu};
        const std::uint8_t to = f->destination() == 0xAF ? host : everybody;
        EXPECT_EQ(link.down(frame(imu, to, f->id(), data)), Frames{vector.v7}) << vector.meaning;
        ++n;
        if (V7LinkTranslation::is_of_own_sensor(f->id())) continue;
        EXPECT_EQ(HostLink{imu}.up(f->id(), data), Frames{frame(host, imu, f->id(), data)}) << vector.meaning;
    }
    EXPECT_GE(n, 10u);
}

// --- Telemetry

TEST(V7HostTranslation, only_the_chosen_device_is_seen) {
    HostLink link{imu};
    const Bytes attitude = pack(std::int16_t{1}, std::int16_t{2}, std::int16_t{3}, std::uint8_t{0});
    EXPECT_TRUE(link.down(frame(fc, host, 0x03, attitude)).empty());
    EXPECT_EQ(link.counted().down_other_device, 1u);
    EXPECT_EQ(link.down(frame(imu, host, 0x03, attitude)), Frames{v7_frame(0xAF, 0x03, attitude)});
    EXPECT_EQ(link.down(frame(imu, everybody, 0x03, attitude)), Frames{v7_frame(0xFF, 0x03, attitude)});
    EXPECT_EQ(link.down(frame(imu, 0xD2, 0x03, attitude)), Frames{v7_frame(0xAF, 0x03, attitude)});
    HostLink mcu{V7Settings{.address = imu, .v7_address = 0x61}};
    EXPECT_EQ(mcu.down(frame(imu, host, 0x03, attitude)), Frames{v7_frame(0x61, 0x03, attitude)});
}

TEST(V7HostTranslation, acceleration_and_temperature_get_the_unit_of_the_device) {
    const Bytes g = pack(std::int16_t{981}, std::int16_t{0}, std::int16_t{0}, std::int16_t{16384}, std::int16_t{0},
                         std::int16_t{0}, std::uint8_t{1});
    HostLink lx{imu};
    EXPECT_EQ(lx.down(0x01, g), Frames{v7_frame(0xAF, 0x01,
                                                pack(std::int16_t{1366}, std::int16_t{0}, std::int16_t{0}, std::int16_t{16384},
                                                     std::int16_t{0}, std::int16_t{0}, std::uint8_t{1}))});
    HostLink tkz{fc};
    EXPECT_EQ(tkz.down(0x01, g), Frames{v7_frame(0xAF, 0x01,
                                                 pack(std::int16_t{981}, std::int16_t{0}, std::int16_t{0}, std::int16_t{1000},
                                                      std::int16_t{0}, std::int16_t{0}, std::uint8_t{1}))});
    const Bytes compass = pack(std::int16_t{1}, std::int16_t{2}, std::int16_t{3}, std::int16_t{441}, std::uint8_t{7});
    HostLink tens{V7Settings{.address = imu, .temp = 10}};
    const auto compass_in_v7 = [](std::int32_t altitude, int temperature) {
        return v7_frame(0xAF, 0x02,
                        pack(std::int16_t{1}, std::int16_t{2}, std::int16_t{3}, altitude, static_cast<std::int16_t>(temperature),
                             std::uint8_t{0}, std::uint8_t{7}));
    };
    EXPECT_EQ(lx.down(0x02, compass), Frames{compass_in_v7(0, 4410)});
    EXPECT_EQ(tens.down(0x02, compass), Frames{compass_in_v7(0, 441)});
    lx.down(0x05, pack(std::int32_t{5000}, std::int32_t{0}, std::int32_t{0}, std::uint8_t{0}));
    EXPECT_EQ(lx.down(0x02, compass), Frames{compass_in_v7(5000, 4410)});
    lx.now += 1s;
    EXPECT_EQ(lx.down(0x02, compass), Frames{compass_in_v7(0, 4410)}) << "an altitude of a second ago";
}

TEST(V7HostTranslation, layouts_become_those_of_v7_unless_they_are_already) {
    HostLink link{imu};
    EXPECT_EQ(link.down(0x05, pack(std::int32_t{1}, std::int32_t{2}, std::int32_t{3}, std::uint8_t{4})),
              Frames{v7_frame(0xAF, 0x05, pack(std::int32_t{3}, std::int32_t{2}, std::uint8_t{4}))});
    EXPECT_EQ(link.down(0x08, pack(std::int32_t{1}, std::int32_t{2}, std::int32_t{3})),
              Frames{v7_frame(0xAF, 0x08, pack(std::int32_t{1}, std::int32_t{2}))});
    EXPECT_EQ(link.down(0x06, {2, 2, 1, 2, 3}), Frames{v7_frame(0xAF, 0x06, {2, 1, 1, 2, 3})}) << "airborne is unlocked";
    EXPECT_EQ(link.down(0x34, Bytes{6} + wire(std::int32_t{750})),
              Frames{v7_frame(0xAF, 0x34, pack(std::uint8_t{0}, std::uint16_t{270}, std::uint32_t{75}))});
    EXPECT_EQ(link.down(0x34, Bytes{100} + pack(std::uint16_t{4500}, std::uint16_t{30}, std::uint16_t{9000}, std::uint16_t{40})),
              (Frames{v7_frame(0xAF, 0x34, pack(std::uint8_t{0}, std::uint16_t{45}, std::uint32_t{30})),
                      v7_frame(0xAF, 0x34, pack(std::uint8_t{0}, std::uint16_t{90}, std::uint32_t{40}))}));
    for (const auto& [id, size] : {std::pair{0x02, 14}, {0x05, 9}, {0x08, 8}, {0x34, 7}}) {
        const Bytes data(static_cast<std::size_t>(size), 9);
        EXPECT_EQ(link.down(static_cast<std::uint8_t>(id), data), Frames{v7_frame(0xAF, static_cast<std::uint8_t>(id), data)});
    }
    EXPECT_EQ(drops(link.counted()), 0u);
}

TEST(V7HostTranslation, drops_and_counts_what_v7_does_not_have) {
    HostLink link{imu};
    for (const std::uint8_t id : Bytes{0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xC0, 0xC1, 0xC2, 0xE0, 0xF0, 0xFB})
        EXPECT_TRUE(link.down(id, Bytes(12)).empty()) << unsigned{id};
    EXPECT_EQ(link.counted().down_no_counterpart, 11u);
    for (const std::uint8_t id : Bytes{0x01, 0x02, 0x05, 0x06, 0x08, 0x32, 0x34, 0xA1}) EXPECT_TRUE(link.down(id, {1}).empty());
    EXPECT_TRUE(link.down(0x03, {}).empty());
    EXPECT_EQ(link.counted().down_malformed, 9u);
    EXPECT_TRUE(link.down(0xA0, Bytes(256)).empty());
    EXPECT_EQ(link.counted().down_too_big, 1u);
    EXPECT_TRUE(link.down(0xA1, wire(3e9F)).empty());
    EXPECT_EQ(link.counted().down_unrepresentable, 1u);
    for (const std::uint8_t id : Bytes{0x00, 0x60, 0x61, 0xE1, 0xE2, 0xE3}) EXPECT_TRUE(link.down(id, Bytes(30)).empty());
    EXPECT_EQ(link.counted().down_unmatched, 6u) << "answers to other hosts";
    EXPECT_EQ(drops(link.counted()), link.translation.dropped());
    EXPECT_EQ(link.translation.dropped(), 28u);
}

// --- Frames of the host program

TEST(V7HostTranslation, frames_of_the_program_go_to_the_device_from_the_id_of_hosts) {
    HostLink link{imu};
    const Bytes sticks(20, 5);
    EXPECT_EQ(link.up(v7_frame(0xFF, 0x40, sticks)), Frames{frame(host, imu, 0x40, sticks)});
    EXPECT_EQ(link.up(v7_frame(0x60, 0x40, sticks)), Frames{frame(host, imu, 0x40, sticks)});
    EXPECT_EQ(link.up(0x32, pack(std::int32_t{12}, std::int32_t{-3}, INT32_MIN)),
              Frames{frame(host, imu, 0x32, pack(std::int32_t{120}, std::int32_t{-30}, INT32_MIN))});
    HostLink mcu{V7Settings{.address = imu, .sources = {{0x40, 0x41, 0xDB}}}};
    EXPECT_EQ(mcu.up(0x40, sticks), Frames{frame(0xDB, imu, 0x40, sticks)});
    EXPECT_EQ(mcu.up(0x33, sticks), Frames{frame(host, imu, 0x33, sticks)});
}

TEST(V7HostTranslation, drops_and_counts_what_a_host_may_not_send) {
    HostLink link{imu};
    for (unsigned id = 1; id < 256; ++id)
        if (V7LinkTranslation::is_of_own_sensor(static_cast<std::uint8_t>(id))) {
            EXPECT_TRUE(link.up(static_cast<std::uint8_t>(id), Bytes(14)).empty());
        }
    EXPECT_EQ(link.counted().up_own_sensor, 17u);
    EXPECT_TRUE(link.up(0xE0, {0x01, 0x20, 0xAA, 1, 0, 0, 0, 0, 0, 0, 0}).empty());
    EXPECT_EQ(link.counted().up_erase, 1u);
    EXPECT_TRUE(link.up(v7_frame(0xAF, 0x40, Bytes(20))).empty()) << "to a host";
    EXPECT_EQ(link.counted().up_no_address, 1u);
    EXPECT_TRUE(link.up(0x00, {1, 2, 3}).empty());
    EXPECT_EQ(link.counted().up_unmatched, 1u);
    for (const std::uint8_t id : Bytes{0x31, 0xC0, 0xE3, 0xF0, 0xFB}) EXPECT_TRUE(link.up(id, Bytes(12)).empty());
    EXPECT_EQ(link.counted().up_no_counterpart, 5u);
    for (const std::uint8_t id : Bytes{0x32, 0x34, 0xA1, 0xE0, 0xE1, 0xE2}) EXPECT_TRUE(link.up(id, {1}).empty());
    EXPECT_TRUE(link.up(0x40, {}).empty());
    EXPECT_TRUE(link.up(0xE0, Bytes(12)).empty());
    EXPECT_EQ(link.counted().up_malformed, 8u);
    EXPECT_TRUE(link.up(0x34, pack(std::uint8_t{0}, std::uint16_t{0}, UINT32_MAX)).empty());
    EXPECT_EQ(link.counted().up_unrepresentable, 1u);
    EXPECT_EQ(drops(link.counted()), link.translation.dropped());
}

TEST(V7HostTranslation, a_command_is_sent_as_often_as_the_program_sends_it_and_acknowledged_as_often) {
    HostLink link{imu};
    const Bytes unlock = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    const Bytes unlock_in_v8 = frame(host, imu, 0xC0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(link.up(unlock), Frames{unlock_in_v8});
    EXPECT_EQ(link.up(unlock), Frames{unlock_in_v8});
    EXPECT_TRUE(link.pass(500ms).empty());
    const Bytes check = v7_frame(0xAF, 0x00, check_of_v7(unlock));
    EXPECT_EQ(link.down(0x00, check_of_v8(unlock_in_v8)), Frames{check});
    EXPECT_EQ(link.down(0x00, check_of_v8(unlock_in_v8)), Frames{check});
    EXPECT_TRUE(link.down(0x00, check_of_v8(unlock_in_v8)).empty());
    link.up(unlock);
    link.now += 1s;
    EXPECT_TRUE(link.down(0x00, check_of_v8(unlock_in_v8)).empty()) << "a second later";
    EXPECT_EQ(link.counted().down_unmatched, 2u);
}

// --- Parameters

TEST(V7HostTranslation, a_parameter_is_read_after_its_type) {
    HostLink link{fc};
    EXPECT_EQ(link.up(0xE1, u16(11)), Frames{frame(host, fc, 0xE0, question(3, 11))});
    EXPECT_TRUE(link.describe(12, i16_type).empty()) << "another one";
    EXPECT_EQ(link.describe(11, i16_type), Frames{frame(host, fc, 0xE0, question(2, 11))});
    EXPECT_TRUE(link.down(0xE1, u16(12) + wire(std::int16_t{-5})).empty());
    EXPECT_EQ(link.down(0xE1, u16(11) + wire(std::int16_t{-5})), Frames{v7_frame(0xAF, 0xE2, written(11, -5))});
    EXPECT_EQ(link.up(0xE1, u16(11)), Frames{frame(host, fc, 0xE0, question(2, 11))}) << "the type is known";
    EXPECT_TRUE(link.down(0xE1, u16(11)).empty()) << "without a value";
    EXPECT_EQ(link.down(0xE1, u16(11) + wire(std::int16_t{6})), Frames{v7_frame(0xAF, 0xE2, written(11, 6))});
    EXPECT_TRUE(link.down(0xE1, u16(11) + wire(std::int16_t{6})).empty()) << "the answer to another host";
}

TEST(V7HostTranslation, requests_for_data_are_repeated_and_given_up) {
    HostLink link{fc};
    const Frames describe{frame(host, fc, 0xE0, question(3, 11))};
    EXPECT_EQ(link.up(0xE1, u16(11)), describe);
    EXPECT_TRUE(link.up(0xE1, u16(11)).empty()) << "its repetition";
    EXPECT_EQ(link.counted().merged, 1u);
    EXPECT_TRUE(link.up(0x60, {0xFF}).empty()) << "it waits";
    EXPECT_TRUE(link.pass(199ms).empty());
    EXPECT_EQ(link.pass(1ms), describe);
    EXPECT_EQ(link.pass(200ms), describe);
    EXPECT_EQ(link.pass(200ms), Frames{frame(host, fc, 0x60, {0xFF})});
    EXPECT_EQ(link.counted().unanswered, 1u);
    EXPECT_EQ(link.down(0x60, {5}), Frames{v7_frame(0xAF, 0x60, {5})});
    EXPECT_EQ(link.translation.deadline(), std::nullopt);
}

TEST(V7HostTranslation, a_write_has_the_type_of_the_parameter_and_is_sent_once) {
    HostLink link{fc};
    const Bytes write = v7_frame(0x05, 0xE2, written(11, -5));
    EXPECT_EQ(link.up(write), Frames{frame(host, fc, 0xE0, question(3, 11))});
    EXPECT_TRUE(link.up(write).empty()) << "its repetition while it waits";
    const Bytes write_in_v8 = frame(host, fc, 0xE1, u16(11) + wire(std::int16_t{-5}));
    EXPECT_EQ(link.describe(11, i16_type), Frames{write_in_v8});
    EXPECT_EQ(link.up(write), Frames{write_in_v8}) << "its repetition: the first may be lost";
    EXPECT_EQ(link.down(0x00, check_of_v8(write_in_v8)), Frames{v7_frame(0xAF, 0x00, check_of_v7(write))});
    EXPECT_EQ(link.translation.deadline(), std::nullopt);
    EXPECT_EQ(link.up(write), Frames{write_in_v8});
    EXPECT_TRUE(link.pass(200ms).empty()) << "not repeated by the gateway";
    EXPECT_EQ(link.counted().unanswered, 1u);
}

TEST(V7HostTranslation, writes_of_one_parameter_end_with_the_value_of_the_last) {
    HostLink link{fc};
    Frames sent;
    for (const std::int32_t value : {5, 6, 6, 5}) link.up(v7_frame(0x05, 0xE2, written(11, value)));
    link.up(v7_frame(0x05, 0xE1, u16(11)));
    EXPECT_EQ(link.counted().merged, 1u);
    link.describe(11, i16_type);
    for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(link.to_gateway.size(), 1u);
        sent.push_back(link.to_gateway[0]);
        link.down(0x00, check_of_v8(sent.back()));
    }
    const auto write = [](std::int16_t value) { return frame(host, fc, 0xE1, u16(11) + wire(value)); };
    EXPECT_EQ(sent, (Frames{write(5), write(6), write(5)}));
    EXPECT_EQ(link.to_gateway, Frames{frame(host, fc, 0xE0, question(2, 11))});
}

// Some program repeats what it receives, or the line echoes.
TEST(V7HostTranslation, what_was_sent_to_the_host_program_is_neither_a_write_nor_a_measurement) {
    HostLink link{{.address = fc, .v7_address = 0xFF, .max_data = 255}};
    link.up(0xE1, u16(11));
    link.describe(11, i16_type);
    const Frames answer = link.down(0xE1, u16(11) + wire(std::int16_t{6}));
    ASSERT_EQ(answer.size(), 1u);
    EXPECT_TRUE(link.up(answer[0]).empty());
    const Frames flow = link.down(0x51, {0, 1, 0, 0, 200});
    ASSERT_EQ(flow.size(), 1u);
    EXPECT_TRUE(link.up(flow[0]).empty());
    EXPECT_EQ(link.counted().up_echo, 2u);
}

/// A link with a device and one with a host program, of one gateway. What their wires are connected with is up to the test.
struct BothLinks final : V7Output {
    explicit BothLinks(std::uint32_t number = 7) : line{number} {}
    V7Settings settings() {
        V7Settings made{.address = imu};
        made.line = line;
        made.lines = &lines;
        return made;
    }
    void to_device(v7::FrameView f) override { sent.emplace_back(f.bytes().begin(), f.bytes().end()); }
    void from_device(ano::FrameView) override {}

    /// Another host sends a frame; what is sent on the wire of the device.
    Frames host_sends(const Bytes& v8) {
        sent.clear();
        device.down(ano::FrameView{v8}, now(), *this);
        return sent;
    }
    Frames command(const Bytes& data) { return host_sends(frame(host, imu, 0xC0, data)); }
    /// A frame arrives at the link with the host program; what is sent on the wire of the device then.
    Frames arrives(const Bytes& v7) {
        Frames all;
        for (const Bytes& v8 : program.up(v7))
            for (Bytes& f : host_sends(v8)) all.push_back(std::move(f));
        return all;
    }
    ano::TimePoint& now() { return program.now; }

    std::uint32_t line;
    V7Lines lines;
    V7Translation device{settings()};
    HostLink program{settings()};
    Frames sent;
};
const Bytes unlock_in_v7 = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
const Bytes lock_in_v7 = v7_frame(0xFF, 0xE0, {0x10, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0});
bool is_probe(const Bytes& v7) { return v7[2] == 0xFB; }

/// The wires are connected: how many frames besides probes are sent until none is under way, at most `most`. `loses`: probes.
unsigned circulate(BothLinks& links, Frames under_way, unsigned most, unsigned loses = 0) {
    unsigned all = 0;
    while (!under_way.empty() && all < most) {
        links.now() += 2ms;
        const Bytes first = under_way.front();
        under_way.erase(under_way.begin());
        if (is_probe(first) && loses > 0) {
            --loses;
            continue;
        }
        all += !is_probe(first);
        for (Bytes& next : links.arrives(first)) under_way.push_back(std::move(next));
    }
    return all;
}

TEST(V7HostTranslation, nothing_circulates_through_wires_connected_with_those_of_a_device) {
    constexpr unsigned endless = 1000;
    const std::vector<Bytes> frames{frame(host, imu, 0xC0, {0x10, 0, 1}),       frame(host, imu, 0xC0, {0x10, 0, 2}),
                                    frame(host, imu, 0x40, Bytes(20, 5)),       frame(host, imu, 0x30, Bytes(23)),
                                    frame(host, imu, 0xE1, {3, 0, 1, 0, 0, 0}), frame(host, imu, 0xE0, {2, 3, 0})};
    for (const Bytes& v8 : frames) {
        BothLinks links;
        EXPECT_EQ(circulate(links, links.host_sends(v8), endless), 1u) << int{v8[3]};
        EXPECT_EQ(links.program.counted().up_loop, 2u) << "the probe, and the frame";
        EXPECT_EQ(circulate(links, {unlock_in_v7}, endless), 1u) << "of whoever else is on the wire";
    }
    BothLinks slow;
    const Frames held = slow.command({0x10, 0, 1});
    slow.now() += 1h;
    EXPECT_EQ(circulate(slow, held, endless), 1u);
    BothLinks of_the_program;
    EXPECT_EQ(circulate(of_the_program, {unlock_in_v7}, endless), 2u) << "its own, and what is sent for it";
}

TEST(V7HostTranslation, a_command_circulates_only_while_the_probes_ahead_of_it_are_lost) {
    for (const unsigned lost : {1u, 3u}) {
        BothLinks links;
        EXPECT_EQ(circulate(links, links.command({0x10, 0, 1}), 1000, lost), 1 + lost);
    }
}

TEST(V7HostTranslation, the_program_is_heard_again_15_s_after_the_last_probe) {
    BothLinks links;
    circulate(links, links.command({0x10, 0, 1}), 1000);
    links.now() += 14s;
    EXPECT_TRUE(links.arrives(unlock_in_v7).empty());
    links.now() += 1s;
    EXPECT_FALSE(links.arrives(unlock_in_v7).empty());
}

// The wire of one gateway's device leads to the other gateway's link with a host program, and the other way round.
TEST(V7HostTranslation, nothing_circulates_through_another_gateway) {
    BothLinks a{7}, b{8};
    Frames at_b = a.command({0x10, 0, 1});
    unsigned commands = 1;
    for (int round = 0; round < 100 && !at_b.empty(); ++round) {
        Frames at_a;
        for (const Bytes& v7 : std::exchange(at_b, {}))
            for (Bytes& f : b.arrives(v7)) at_a.push_back(std::move(f));
        for (const Bytes& v7 : at_a)
            for (Bytes& f : a.arrives(v7)) at_b.push_back(std::move(f));
        commands += static_cast<unsigned>(std::count_if(at_a.begin(), at_a.end(), std::not_fn(is_probe)) +
                                          std::count_if(at_b.begin(), at_b.end(), std::not_fn(is_probe)));
    }
    EXPECT_EQ(commands, 2u) << "one on each wire";
}

TEST(V7HostTranslation, every_frame_of_the_program_is_sent_whatever_it_and_other_hosts_repeat) {
    BothLinks links;
    unsigned wrong = 0;
    for (int n = 0; n < 3000; ++n, links.now() += 20ms) {
        const Bytes& v7 = n % 2 == 0 ? lock_in_v7 : v7_frame(0xFF, 0x40, Bytes(20, 5));
        const Frames sent = links.arrives(v7);
        wrong += sent.empty() || sent.back() != v7;
        if (n % 3 == 0) links.command({0x10, 0, 2});
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_EQ(links.program.counted().up_loop, 0u);
}

TEST(V7HostTranslation, values_that_one_side_cannot_represent_are_refused) {
    HostLink link{fc};
    link.up(0xE2, written(11, 256));
    EXPECT_TRUE(link.describe(11, u8_type).empty());
    EXPECT_EQ(link.counted().up_unrepresentable, 1u);
    EXPECT_TRUE(link.up(0xE2, written(11, -1)).empty());
    EXPECT_EQ(link.counted().up_unrepresentable, 2u);
    EXPECT_EQ(link.translation.deadline(), std::nullopt);
    link.up(0xE1, u16(12));
    link.describe(12, f32_type);
    EXPECT_TRUE(link.down(0xE1, u16(12) + wire(1.25F)).empty()) << "the host program would write 1 back";
    EXPECT_EQ(link.counted().down_unrepresentable, 1u);
    link.up(0xE1, u16(12));
    EXPECT_EQ(link.down(0xE1, u16(12) + wire(3.0F)), Frames{v7_frame(0xAF, 0xE2, written(12, 3))});
    link.up(0xE1, u16(13));
    EXPECT_TRUE(link.describe(13, string_type).empty());
    EXPECT_EQ(link.counted().down_unrepresentable, 2u);
    EXPECT_EQ(link.translation.deadline(), std::nullopt);
}

TEST(V7HostTranslation, a_table_maps_numbers_to_rows_and_scales_real_numbers) {
    V7Settings settings{.address = fc};
    settings.parameters = {{11, "P", 1000}, {82, "HEIGHT"}};
    HostLink link{settings};
    EXPECT_EQ(link.up(0xE1, u16(11)), Frames{frame(host, fc, 0xE0, question(3, 0))});
    EXPECT_EQ(link.describe(0, f32_type), Frames{frame(host, fc, 0xE0, question(2, 0))});
    EXPECT_EQ(link.down(0xE1, u16(0) + wire(1.1F)), Frames{v7_frame(0xAF, 0xE2, written(11, 1100))});
    EXPECT_EQ(link.up(0xE2, written(11, 1250)), Frames{frame(host, fc, 0xE1, u16(0) + wire(1.25F))});
    link.pass(200ms);
    EXPECT_EQ(link.up(0xE1, u16(82)), Frames{frame(host, fc, 0xE0, question(3, 1))});
    link.pass(10s);
    link.pass(10s);
    link.pass(10s);
    EXPECT_TRUE(link.up(0xE1, u16(90)).empty());
    EXPECT_EQ(link.to_program, Frames{v7_frame(0xAF, 0xE2, written(90, INT32_MIN))}) << "no such parameter";
    EXPECT_TRUE(link.up(0xE2, written(90, 1)).empty());
    EXPECT_EQ(link.counted().up_no_counterpart, 1u);
}

TEST(V7HostTranslation, an_older_device_has_i32_for_every_parameter) {
    HostLink link{fc};
    link.up(0xE2, written(11, 70000));
    Bytes name(20);
    name[0] = 'P';
    link.down(0xE2, u16(11) + pack(std::int32_t{-100000}, std::int32_t{100000}) + name + Bytes{'g', 'a', 'i', 'n'});
    EXPECT_EQ(link.to_gateway, Frames{frame(host, fc, 0xE1, u16(11) + wire(std::int32_t{70000}))});
}

TEST(V7HostTranslation, the_device_information_answers_the_numbers_from_1_to_4) {
    HostLink link{imu};
    const Bytes info = Bytes{imu} + u16(100) + u16(101) + u16(0) + u16(800) + Bytes{'L', 'X'};
    const std::int32_t expected[]{0x60, 100, 101, 0};
    for (unsigned number = 1; number <= 4; ++number) {
        EXPECT_EQ(link.up(0xE1, u16(number)), Frames{frame(host, imu, 0xE0, question(0, 0))});
        EXPECT_EQ(link.down(0xE3, info), Frames{v7_frame(0xAF, 0xE2, written(number, expected[number - 1]))});
        EXPECT_TRUE(link.up(0xE2, written(number, 1)).empty());
    }
    EXPECT_EQ(link.counted().up_no_counterpart, 4u);
}

TEST(V7HostTranslation, waypoints_are_asked_for_and_written) {
    HostLink link{imu};
    Bytes point(22);
    point[0] = 3;
    EXPECT_EQ(link.up(0x60, {3}), Frames{frame(host, imu, 0x60, {3})});
    EXPECT_EQ(link.down(0x61, point), Frames{v7_frame(0xAF, 0x61, point)});
    EXPECT_TRUE(link.down(0x61, point).empty()) << "the answer to another host";
    const Bytes write = v7_frame(0x60, 0x61, point);
    const Bytes write_in_v8 = frame(host, imu, 0x61, point);
    EXPECT_EQ(link.up(write), Frames{write_in_v8});
    EXPECT_EQ(link.down(0x00, check_of_v8(write_in_v8)), Frames{v7_frame(0xAF, 0x00, check_of_v7(write))});
}

TEST(V7HostTranslation, at_most_16_requests_wait_and_a_lost_connection_drops_them) {
    HostLink link{imu};
    for (unsigned i = 0; i < 17; ++i) link.up(0xE1, u16(100 + i));
    EXPECT_EQ(link.counted().up_queue_full, 0u);
    link.up(0xE1, u16(200));
    EXPECT_EQ(link.counted().up_queue_full, 1u);
    link.translation.reset();
    EXPECT_EQ(link.translation.deadline(), std::nullopt);
    EXPECT_EQ(link.up(0xE1, u16(100)), Frames{frame(host, imu, 0xE0, question(3, 100))});
}

TEST(V7HostTranslation, random_frames_never_erase_nor_multiply_and_are_all_counted) {
    support::Random random{7};
    HostLink link{imu};
    std::uint64_t commands = 0, commands_sent = 0, writes = 0, writes_sent = 0;
    const auto count_sent = [&](const Frames& frames) {
        for (const Bytes& f : frames) {
            commands_sent += f[3] == 0xC0;
            writes_sent += f[3] == 0xE1;
            EXPECT_FALSE(f[3] == 0xC0 && f[6] == 0x01 && f[7] == 0x20 && f[8] == 0xAA);
            EXPECT_EQ(f[2], imu);
        }
    };
    constexpr std::uint8_t ids[]{0x00, 0x32, 0x34, 0x60, 0x61, 0xA1, 0xE0, 0xE0, 0xE1, 0xE2, 0xE2, 0xE3};
    for (int i = 0; i < 20'000; ++i) {
        const std::uint8_t id = random.below(4u) != 0 ? ids[random.below(std::size(ids))]
                                                      : static_cast<std::uint8_t>(random.below(256u));
        Bytes data(random.below(16u));
        for (auto& byte : data) byte = static_cast<std::uint8_t>(random.below(4u) == 0 ? random.below(256u) : random.below(3u));
        if (id == 0xE0 && data.size() > 2 && random.below(3u) == 0) data[0] = 0x01, data[1] = 0x20, data[2] = 0xAA;
        if (id == 0xE2) data.resize(6);
        if (random.below(2u) != 0) {
            commands += id == 0xE0;
            writes += id == 0xE2;
            count_sent(link.up(id, data));
        } else {
            if (id == 0xE2) data.resize(23), data[2] = i32_type;
            link.down(id, data);
            count_sent(link.to_gateway);
        }
        if (random.below(4u) == 0) count_sent(link.pass(std::chrono::milliseconds{random.below(300u)}));
    }
    EXPECT_LE(commands_sent, commands);
    EXPECT_GT(commands_sent, 100u);
    EXPECT_LE(writes_sent, writes);
    EXPECT_GT(writes_sent, 10u);
    EXPECT_EQ(drops(link.counted()), link.translation.dropped());
}

TEST(V7HostTranslation, allocates_only_at_construction) {
    V7HostTranslation translation{V7Settings{.address = imu}};
    struct Count final : V7Output {
        void to_device(v7::FrameView) override { ++n; }
        void from_device(ano::FrameView) override { ++n; }
        unsigned n = 0;
    } output;
    Frames v7, v8;
    for (unsigned id = 0; id < 256; ++id)
        for (const std::uint8_t first : Bytes{0, 1, 2, 3, 0x10}) {
            v7.push_back(v7_frame(0xFF, static_cast<std::uint8_t>(id), {first, 0, 0, 0, 0, 0}));
            v8.push_back(frame(imu, host, static_cast<std::uint8_t>(id), {first, 0, 0, 0, 0, 0}));
        }
    ano::TimePoint now{1h};
    const auto before = support::allocations;
    for (std::size_t i = 0; i < v7.size(); ++i) {
        translation.up(v7::FrameView{v7[i]}, now, output);
        translation.down(ano::FrameView{v8[i]}, now, output);
        translation.expire(now += 50ms, output);
    }
    EXPECT_EQ(support::allocations, before);
    EXPECT_GT(output.n, 100u);
}

}    // namespace
}    // namespace v7_host_translation_tests
