// The translation between V8 and a link with V7 devices (protocol-v7.md, section 8).
#include <gateway/v7_host_translation.hpp>
#include <gateway/v7_translation.hpp>

#include <ano/conversation.hpp>
#include <ano/reading.hpp>
#include <ano/wire.hpp>
#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace v7_translation_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::hex;
using support::operator+;
using support::v7_frame;
namespace v7 = ano::v7;

namespace {

using Frames = std::vector<Bytes>;
constexpr std::uint8_t fc = 0xDC, imu = 0xDD, flow = 0xDE, host = 0xFE, everybody = 0xFF;

struct V7Link final : V7Output {
    explicit V7Link(V7Settings settings) : translation{std::move(settings)} {}
    explicit V7Link(std::uint8_t address) : V7Link{V7Settings{.address = address}} {}

    V7Translation translation;
    ano::TimePoint now{1h};
    Frames sent;        // to the device
    Frames probes;      // the same, of the gateway itself
    Frames received;    // from the device, as the gateway sees it

    void to_device(v7::FrameView f) override {
        EXPECT_TRUE(v7::frame_at(f.bytes()));
        (f.id() == 0xFB ? probes : sent).emplace_back(f.bytes().begin(), f.bytes().end());
    }
    void from_device(ano::FrameView f) override {
        EXPECT_TRUE(ano::frame_at(f.bytes()));
        received.emplace_back(f.bytes().begin(), f.bytes().end());
    }

    /// What a frame of the device becomes.
    Frames up(const Bytes& bytes) {
        received.clear();
        translation.up(v7::FrameView{bytes}, now, *this);
        return received;
    }
    /// What is sent to the device for a frame.
    Frames down(const Bytes& bytes) {
        sent.clear();
        received.clear();
        translation.down(ano::FrameView{bytes}, now, *this);
        return sent;
    }
    Frames down(std::uint8_t id, const Bytes& data) { return down(frame(host, translation.settings().address, id, data)); }
    Frames up(std::uint8_t id, const Bytes& data) { return up(v7_frame(0xAF, id, data)); }
    void pass(ano::Duration time) {
        sent.clear();
        received.clear();
        now += time;
        translation.expire(now, *this);
    }
    const V7Counters& counted() const { return translation.counters(); }
};

std::uint64_t drops(const V7Counters& counters) {
    std::uint64_t n = 0;
    for (const auto& row : v7_counters)
        if (row.is_drop) n += counters.*row.value;
    return n;
}

Bytes one(const Frames& frames) { return frames.size() == 1 ? frames.front() : Bytes{}; }
Bytes data_of(const Bytes& v8) {
    const auto f = ano::frame_at(v8);
    return f ? Bytes{f->data().begin(), f->data().end()} : Bytes{};
}
Bytes check_of(const Bytes& v7) { return {v7[2], v7[v7.size() - 2], v7[v7.size() - 1]}; }
Bytes check_of_v8(const Bytes& v8) { return {v8[3], v8[v8.size() - 2], v8[v8.size() - 1]}; }

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

// --- Vectors

TEST(V7Translation, gives_the_pairs_of_the_vectors_in_their_direction) {
    std::size_t up = 0, down = 0;
    for (const auto& pair : support::v7_vectors("pair")) {
        const bool to_device = pair.v8[1] == host;
        V7Link link{to_device ? pair.v8[2] : pair.v8[1]};
        if (to_device) {
            ++down;
            EXPECT_EQ(link.down(pair.v8), Frames{pair.v7}) << pair.meaning;
            continue;
        }
        ++up;
        // What the meaning presupposes: the command, or the altitude before.
        if (pair.v7[2] == 0x00) {
            for (const Bytes& request :
                 {frame(host, fc, 0xC0, {0x10, 0, 5, 0x96, 0}), frame(host, fc, 0xC0, {0x10, 0, 1}),
                  frame(host, fc, 0xC0, {0x10, 0, 5, 0x96, 0, 0, 0, 0, 0, 0, 0}), frame(host, fc, 0xE1, {11, 0, 0xE8, 3, 0, 0})})
                if (check_of_v8(request) == data_of(pair.v8)) link.down(request);
        } else if (pair.v7[2] == 0x08) {
            link.up(v7_frame(0xAF, 0x05, pack(std::int32_t{358}, std::int32_t{0}, std::uint8_t{0})));
        }
        EXPECT_EQ(link.up(pair.v7), Frames{pair.v8}) << pair.meaning;
    }
    EXPECT_GE(up, 7u);
    EXPECT_GE(down, 4u);
}

TEST(V7Translation, keeps_the_data_of_messages_that_are_the_same) {
    for (const auto& vector : support::v7_vectors("valid")) {
        const auto f = v7::frame_at(vector.v7);
        if (!v7::is_same_in_v8(f->id()) || f->id() == 0x00 || f->id() == 0x60 || f->data().empty()) continue;
        V7Link link{imu};
        const bool is_for_hosts = f->destination() == 0xAF || f->id() == 0x40 || f->id() == 0x41;
        const std::uint8_t to = is_for_hosts ? host : everybody;
        EXPECT_EQ(link.up(vector.v7), Frames{frame(imu, to, f->id(), {f->data().begin(), f->data().end()})}) << vector.meaning;
    }
}

// --- Up

TEST(V7Translation, destinations_become_those_of_v8) {
    V7Link link{imu};
    const struct {
        std::uint8_t v7, v8;
    } expected[]{{0xAF, 0xFE}, {0x66, 0xFE}, {0xFF, 0xFF}, {0x05, 0xDC}, {0x10, 0xE6}, {0x22, 0xDE},
                 {0x60, 0xDD}, {0x61, 0xDB}, {0x30, 0x30}, {1, 1},       {199, 199}};
    for (const auto& [in_v7, in_v8] : expected)
        EXPECT_EQ(link.up(v7_frame(in_v7, 0x0D, {1, 2, 3, 4})), Frames{frame(imu, in_v8, 0x0D, {1, 2, 3, 4})}) << int{in_v7};
    for (const std::uint8_t none : Bytes{0, 200, 0xDC, 0xFE}) EXPECT_TRUE(link.up(v7_frame(none, 0x0D, {1, 2, 3, 4})).empty());
    EXPECT_EQ(link.counted().up_no_address, 4u);
}

TEST(V7Translation, single_ids_come_from_other_devices_of_the_line) {
    V7Link link{{.address = imu, .sources = {{0x51, 0x51, flow}, {0x34, 0x34, flow}, {0xF1, 0xFA, 0xDB}}}};
    EXPECT_EQ(one(link.up(0x51, {0, 1, 3, 0xFE, 200}))[1], flow);
    EXPECT_EQ(one(link.up(0xF1, {1}))[1], 0xDB);
    EXPECT_EQ(one(link.up(0xFA, {1}))[1], 0xDB);
    EXPECT_EQ(one(link.up(0x07, {1, 2, 3, 4, 5, 6}))[1], imu);
}

TEST(V7Translation, acceleration_has_the_unit_of_the_device) {
    const Bytes v7 = pack(std::int16_t{1000}, std::int16_t{-2048}, std::int16_t{32767}, std::int16_t{100}, std::int16_t{-3000},
                          std::int16_t{0}, std::uint8_t{1});
    const auto of = [&](std::uint8_t address, std::optional<V7Acceleration> acc = {}) {
        return data_of(one(V7Link{{.address = address, .acc = acc}}.up(v7_frame(0xAF, 0x01, v7))));
    };
    EXPECT_EQ(of(imu), pack(std::int16_t{718}, std::int16_t{-1471}, std::int16_t{23535}, std::int16_t{100}, std::int16_t{-3000},
                            std::int16_t{0}, std::uint8_t{1}));
    EXPECT_EQ(of(flow), pack(std::int16_t{479}, std::int16_t{-981}, std::int16_t{15690}, std::int16_t{100}, std::int16_t{-3000},
                             std::int16_t{0}, std::uint8_t{1}));
    EXPECT_EQ(of(fc), pack(std::int16_t{1000}, std::int16_t{-2048}, std::int16_t{32767}, std::int16_t{1638}, std::int16_t{-32768},
                           std::int16_t{0}, std::uint8_t{1}));
    EXPECT_EQ(of(50), v7);
    EXPECT_EQ(of(imu, V7Acceleration{}), v7);
    EXPECT_EQ(of(50, V7Acceleration{V7Acceleration::Unit::per_g, 98.0665}),
              pack(std::int16_t{10000}, std::int16_t{-20480}, std::int16_t{32767}, std::int16_t{100}, std::int16_t{-3000},
                   std::int16_t{0}, std::uint8_t{1}));
}

Bytes compass(std::int32_t alt_bar, std::int16_t tmp) {
    return pack(std::int16_t{1}, std::int16_t{2}, std::int16_t{3}, alt_bar, tmp, std::uint8_t{7}, std::uint8_t{8});
}
Bytes altitude(std::int32_t fused, std::int32_t additional) { return pack(fused, additional, std::uint8_t{9}); }

TEST(V7Translation, temperature_is_rounded_to_tenths) {
    V7Link link{imu};
    EXPECT_EQ(data_of(one(link.up(0x02, compass(5, 4415)))),
              pack(std::int16_t{1}, std::int16_t{2}, std::int16_t{3}, std::int16_t{442}, std::uint8_t{8}));
    EXPECT_EQ(ano::load<std::int16_t>(data_of(one(link.up(0x02, compass(5, -4415)))).data() + 6), -442);
    V7Link tenths{{.address = imu, .temp = 10}};
    EXPECT_EQ(ano::load<std::int16_t>(data_of(one(tenths.up(0x02, compass(5, 441)))).data() + 6), 441);
}

TEST(V7Translation, altitude_is_completed_by_the_last_barometer_of_one_second) {
    V7Link link{imu};
    EXPECT_EQ(data_of(one(link.up(0x05, altitude(300, 200)))), altitude(300, 200)) << "no barometer yet";
    link.up(0x02, compass(100, 0));
    link.now += 999ms;
    EXPECT_EQ(data_of(one(link.up(0x05, altitude(300, 200)))),
              pack(std::int32_t{100}, std::int32_t{200}, std::int32_t{300}, std::uint8_t{9}));
    link.now += 1ms;
    EXPECT_EQ(data_of(one(link.up(0x05, altitude(300, 200)))), altitude(300, 200)) << "too old";
}

TEST(V7Translation, position_gets_the_last_altitude) {
    V7Link link{imu};
    const Bytes position = pack(std::int32_t{-42}, std::int32_t{-328});
    EXPECT_EQ(data_of(one(link.up(0x08, position))), position);
    link.up(0x05, altitude(358, 0));
    EXPECT_EQ(data_of(one(link.up(0x08, position))), position + wire(std::int32_t{358}));
    link.translation.reset();
    EXPECT_EQ(data_of(one(link.up(0x08, position))), position);
}

TEST(V7Translation, layout_keep_hands_on_the_data_of_v7) {
    V7Link link{{.address = imu, .layout = V7Layout::keep}};
    for (const auto& [id, data] : {std::pair{0x02, compass(5, 4415)},
                                   {0x05, altitude(1, 2)},
                                   {0x08, pack(std::int32_t{1}, std::int32_t{2})},
                                   {0x34, hex("000E014B000000")}})
        EXPECT_EQ(data_of(one(link.up(static_cast<std::uint8_t>(id), data))), data) << id;
}

TEST(V7Translation, positions_become_millimetres) {
    V7Link link{imu};
    EXPECT_EQ(data_of(one(link.up(0x32, pack(INT32_MIN, std::int32_t{-45}, INT32_MAX)))),
              pack(INT32_MIN, std::int32_t{-450}, INT32_MAX));
    EXPECT_EQ(data_of(one(link.up(0x32, pack(INT32_MIN + 1, std::int32_t{0}, std::int32_t{1})))),
              pack(INT32_MIN + 1, std::int32_t{0}, std::int32_t{10}));
    EXPECT_EQ(link.down(0x32, pack(INT32_MIN, std::int32_t{-459}, std::int32_t{459})),
              Frames{v7_frame(0xFF, 0x32, pack(INT32_MIN, std::int32_t{-45}, std::int32_t{45}))});
}

Bytes range(std::uint8_t direction, std::uint16_t angle, std::uint32_t cm) { return pack(direction, angle, cm); }
Bytes distance(std::uint8_t type, std::int32_t mm) { return pack(type, mm); }

TEST(V7Translation, distances_up_have_the_type_of_their_direction) {
    const struct {
        V7Range range;
        std::uint8_t direction;
        std::uint16_t angle;
        std::uint8_t type;
    } expected[]{{V7Range::lx, 0, 270, 6}, {V7Range::lx, 1, 270, 6}, {V7Range::lx, 1, 90, 5},   {V7Range::lx, 0, 0, 1},
                 {V7Range::lx, 0, 180, 2}, {V7Range::lx, 0, 90, 4},  {V7Range::doc, 0, 270, 3}, {V7Range::doc, 1, 270, 6},
                 {V7Range::doc, 1, 90, 5}, {V7Range::doc, 0, 0, 1},  {V7Range::flow, 0, 0, 6},  {V7Range::flow, 1, 5, 5},
                 {V7Range::flow, 2, 0, 1}, {V7Range::flow, 3, 0, 2}, {V7Range::flow, 4, 9, 3},  {V7Range::flow, 5, 0, 4}};
    for (const auto& e : expected) {
        V7Link link{{.address = imu, .range = e.range}};
        EXPECT_EQ(data_of(one(link.up(0x34, range(e.direction, e.angle, 75)))), distance(e.type, 750))
            << int{e.direction} << ' ' << e.angle;
    }
    V7Link link{imu};
    EXPECT_EQ(data_of(one(link.up(0x34, range(0, 45, 75)))), pack(std::uint8_t{100}, std::uint16_t{4500}, std::uint16_t{75}));
    EXPECT_EQ(drops(link.counted()), 0u);
    for (const Bytes& none : {range(0, 0, UINT32_MAX), range(0, 0, INT32_MAX / 10 + 1), range(1, 45, 75), range(2, 0, 75),
                              range(0, 360, 75), range(0, 45, 65536)})
        EXPECT_TRUE(link.up(0x34, none).empty());
    EXPECT_EQ(link.counted().up_unrepresentable, 6u);
}

TEST(V7Translation, distances_down_have_the_direction_of_their_type) {
    const struct {
        V7Range range;
        std::uint8_t type, direction;
        std::uint16_t angle;
    } expected[]{{V7Range::lx, 0, 0, 270},  {V7Range::lx, 1, 0, 0},    {V7Range::lx, 2, 0, 180},
                 {V7Range::lx, 4, 0, 90},   {V7Range::lx, 5, 1, 90},   {V7Range::lx, 6, 0, 270},
                 {V7Range::doc, 0, 1, 270}, {V7Range::doc, 3, 0, 270}, {V7Range::doc, 6, 1, 270}};
    for (const auto& e : expected) {
        V7Link link{{.address = imu, .range = e.range}};
        EXPECT_EQ(link.down(0x34, distance(e.type, 759)), Frames{v7_frame(0xFF, 0x34, range(e.direction, e.angle, 75))})
            << int{e.type};
    }
    V7Link link{imu};
    for (const Bytes& none : {distance(3, 759), distance(7, 759), distance(1, -1)}) EXPECT_TRUE(link.down(0x34, none).empty());
    EXPECT_EQ(link.counted().down_unrepresentable, 3u);
    const Bytes scan = pack(std::uint8_t{100}, std::uint16_t{4549}, std::uint16_t{75}, std::uint16_t{27000}, std::uint16_t{80},
                            std::uint16_t{35960}, std::uint16_t{90});
    EXPECT_EQ(link.down(0x34, scan), (Frames{v7_frame(0xFF, 0x34, range(0, 45, 75)), v7_frame(0xFF, 0x34, range(0, 0, 90))}));
    EXPECT_EQ(link.counted().down_unrepresentable, 4u) << "at 270° an LX MCU has its distance to the ground";
}

TEST(V7Translation, drops_and_counts_messages_without_a_counterpart_in_v8) {
    V7Link link{imu};
    for (const std::uint8_t id : Bytes{0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xC0, 0xC1, 0xC2, 0xE3, 0xF0, 0xFB})
        EXPECT_TRUE(link.up(id, {1, 2, 3}).empty()) << int{id};
    EXPECT_EQ(link.counted().up_no_counterpart, 11u);
    for (const auto& [id, size] : {std::pair{0x01, 18u},
                                   {0x02, 9u},
                                   {0x05, 13u},
                                   {0x08, 12u},
                                   {0x32, 13u},
                                   {0x34, 4u},
                                   {0xA1, 3u},
                                   {0xE2, 5u},
                                   {0x00, 2u},
                                   {0x07, 0u}})
        EXPECT_TRUE(link.up(static_cast<std::uint8_t>(id), Bytes(size)).empty()) << id;
    EXPECT_EQ(link.counted().up_malformed, 10u);
    EXPECT_EQ(link.up(0x11, {1, 2}), Frames{frame(imu, host, 0x11, {1, 2})}) << "an unknown id passes";
    EXPECT_EQ(drops(link.counted()), 21u);
}

// --- Commands and acknowledgements

TEST(V7Translation, a_command_is_acknowledged_to_its_host_with_the_checks_of_its_frame) {
    V7Link link{fc};
    const Bytes first = frame(host, fc, 0xC0, {0x10, 0, 1}), second = frame(0xD2, fc, 0xC0, {0x10, 0, 1, 0, 0});
    const Bytes sent = one(link.down(first));
    EXPECT_EQ(link.down(second), Frames{sent}) << "another host, the same command";
    const Bytes ack = v7_frame(0xAF, 0x00, check_of(sent));
    EXPECT_EQ(link.up(ack), Frames{frame(fc, host, 0x00, check_of_v8(first))});
    EXPECT_EQ(link.up(ack), Frames{frame(fc, 0xD2, 0x00, check_of_v8(second))});
    EXPECT_TRUE(link.up(ack).empty());
    EXPECT_EQ(link.counted().up_unmatched, 1u);
}

TEST(V7Translation, an_acknowledgement_after_one_second_is_dropped) {
    V7Link link{fc};
    const Bytes sent = one(link.down(0xC0, {0x10, 0, 1}));
    link.now += 1s;
    EXPECT_TRUE(link.up(0x00, check_of(sent)).empty());
    EXPECT_EQ(link.counted().up_unmatched, 1u);
}

// The router sends frames for an unknown address everywhere.
TEST(V7Translation, a_command_for_another_device_is_not_sent) {
    V7Link link{{.address = imu, .port_id = 3}};
    for (std::uint8_t to = 0; to < 0xFF; ++to) {
        if (to == imu || to == 3) continue;
        EXPECT_TRUE(link.down(frame(host, to, 0xC0, {0x10, 0, 1})).empty()) << +to;
    }
    EXPECT_EQ(link.counted().down_other_device, 253u);
    EXPECT_EQ(link.down(frame(host, 3, 0xC0, {0x10, 0, 1})).size(), 1u) << "the port id of its link";
}

TEST(V7Translation, what_would_reach_another_device_of_the_line_is_not_sent) {
    const auto writes = [](std::uint8_t to) { return frame(host, to, 0xE1, {151, 0, 5, 0, 0, 0}); };
    V7Link link{{.address = imu, .sources = {{0x51, 0x51, flow}, {0xF1, 0xF1, 77}}}};
    EXPECT_EQ(one(link.down(writes(flow)))[1], 0x22) << "it has a V7 address of its own";
    EXPECT_TRUE(link.down(frame(host, flow, 0xC0, {0x10, 0, 1})).empty()) << "V7 sends commands to all";
    EXPECT_TRUE(link.down(frame(host, flow, 0xE0, {0x10, 0x20, 0})).empty());
    EXPECT_TRUE(link.down(frame(host, flow, 0x40, Bytes(20))).empty());
    EXPECT_TRUE(link.down(frame(host, flow, 0x61, Bytes(22))).empty());
    EXPECT_TRUE(link.down(writes(77)).empty());
    EXPECT_EQ(link.counted().down_other_device, 5u);
    V7Link addressed{{.address = imu, .sources = {{0x51, 0x51, flow}}, .v7_address = 0x60}};
    EXPECT_TRUE(addressed.down(writes(flow)).empty());
    EXPECT_EQ(addressed.counted().down_other_device, 1u);
    EXPECT_EQ(addressed.down(writes(imu)).size(), 1u);
}

TEST(V7Translation, a_command_to_everybody_is_acknowledged_by_the_address) {
    V7Link link{imu};
    const Bytes command = frame(host, everybody, 0xC0, {0x10, 0, 6});
    const Bytes sent = one(link.down(command));
    EXPECT_EQ(sent[1], 0xFF);
    EXPECT_EQ(link.up(0x00, check_of(sent)), Frames{frame(imu, host, 0x00, check_of_v8(command))});
}

TEST(V7Translation, a_command_is_sent_as_often_as_its_host_sends_it) {
    V7Link link{fc};
    for (int i = 0; i < 3; ++i) EXPECT_EQ(link.down(0xC0, {0x10, 0, 5, 150, 0}).size(), 1u);
    for (int i = 0; i < 100; ++i) {
        link.pass(100ms);
        EXPECT_TRUE(link.sent.empty());
    }
}

TEST(V7Translation, an_emergency_stop_does_not_wait_for_requests) {
    V7Link link{fc};
    for (std::uint8_t n = 0; n < 30; ++n) link.down(0xE0, {2, n, 0});
    EXPECT_GT(link.counted().down_queue_full, 0u);
    EXPECT_EQ(link.down(0xC0, {0x10, 0, 2}), Frames{v7_frame(0xFF, 0xE0, {0x10, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0})});
}

// A tapped line between an MCU and an IMU has their commands, with any receiver.
TEST(V7Translation, no_frame_of_a_device_commands_or_asks_another) {
    V7Link link{imu};
    const Bytes waypoint(22, 7);
    for (const std::uint8_t to : Bytes{0xFF, 0x05, 0x60, 0x61, 50, 0xAF})
        for (const auto& [id, data] : {std::pair{0xE0, Bytes{0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0}}, {0xE1, Bytes{11, 0}}})
            EXPECT_TRUE(link.up(v7_frame(to, static_cast<std::uint8_t>(id), data)).empty()) << int{to} << ' ' << id;
    EXPECT_EQ(link.counted().up_command, 12u);
    for (const std::uint8_t to : Bytes{0xFF, 0x05, 0x60, 0x61, 50}) {
        EXPECT_TRUE(link.up(v7_frame(to, 0x60, {1})).empty());
        EXPECT_TRUE(link.up(v7_frame(to, 0x61, waypoint)).empty());
        for (const std::uint8_t sticks : Bytes{0x40, 0x41})
            EXPECT_EQ(link.up(v7_frame(to, sticks, Bytes(20))), Frames{frame(imu, host, sticks, Bytes(20))}) << "to hosts only";
    }
    EXPECT_EQ(link.counted().up_command, 22u);
    for (unsigned id = 0; id < 256; ++id)
        for (unsigned to = 0; to < 256; ++to)
            for (const std::size_t size : {2u, 3u, 6u, 7u, 11u, 22u})
                for (const Bytes& v8 :
                     link.up(v7_frame(static_cast<std::uint8_t>(to), static_cast<std::uint8_t>(id), Bytes(size))))
                    ASSERT_EQ(ano::intent_of(ano::FrameView{v8}), ano::Intent::informs) << id << ' ' << to;
}

TEST(V7Translation, a_gateway_that_acknowledges_itself_does_so_when_it_sent) {
    V7Link link{{.address = 0xDB, .ack = V7Ack::sent}};
    const Bytes command = frame(host, 0xDB, 0xC0, {0x10, 0, 1}), write = frame(host, 0xDB, 0xE1, {5, 0, 1, 0, 0, 0});
    EXPECT_EQ(link.down(command).size(), 1u);
    EXPECT_EQ(link.received, Frames{frame(0xDB, host, 0x00, check_of_v8(command))});
    EXPECT_EQ(link.down(write), Frames{v7_frame(0x61, 0xE2, {5, 0, 1, 0, 0, 0})});
    EXPECT_EQ(link.received, Frames{frame(0xDB, host, 0x00, check_of_v8(write))});
    EXPECT_FALSE(link.translation.deadline());
}

TEST(V7Translation, commands_are_described_by_the_gateway) {
    V7Link link{imu};
    EXPECT_TRUE(link.down(0xC1, {0, 0, 0}).empty());
    const Bytes count = data_of(one(link.received));
    ASSERT_EQ(count.size(), 3u);
    ASSERT_GE(count[1], 38);
    bool takes_off = false;
    for (std::uint8_t n = 0; n < count[1]; ++n) {
        link.down(0xC1, {1, n, 0});
        const Bytes info = data_of(one(link.received));
        ASSERT_GE(info.size(), 33u) << int{n};
        EXPECT_EQ(info[0], n);
        EXPECT_FALSE(info[2] == 0x01 && info[3] == 0x20);
        if (Bytes{info.begin() + 2, info.begin() + 6} == Bytes{0x10, 0, 5, 3})
            takes_off = std::string(info.begin() + 13, info.begin() + 21) == std::string{"TAKE_OFF"};
    }
    EXPECT_TRUE(takes_off);
    EXPECT_TRUE(link.down(0xC1, {1, count[1], 0}).empty());
    EXPECT_TRUE(link.received.empty());
    EXPECT_EQ(link.counted().answered, count[1] + 1u);
}

// --- Requests

TEST(V7Translation, a_parameter_is_read_by_its_number_and_repeated_three_times) {
    V7Link link{fc};
    const Bytes question = frame(host, fc, 0xE0, {2, 11, 0});
    const Bytes asked = v7_frame(0x05, 0xE1, {11, 0});
    EXPECT_EQ(link.down(question), Frames{asked});
    EXPECT_EQ(link.translation.deadline(), link.now + 200ms);
    EXPECT_TRUE(link.down(question).empty()) << "its host repeats it";
    EXPECT_EQ(link.counted().merged, 1u);
    link.pass(199ms);
    EXPECT_TRUE(link.sent.empty());
    link.pass(1ms);
    EXPECT_EQ(link.sent, Frames{asked});
    EXPECT_TRUE(link.up(0xE2, {12, 0, 1, 0, 0, 0}).size() == 1) << "another parameter is no answer";
    EXPECT_TRUE(link.translation.deadline());
    EXPECT_EQ(link.up(0xE2, {11, 0, 0xE8, 3, 0, 0}), Frames{frame(fc, host, 0xE1, {11, 0, 0xE8, 3, 0, 0})});
    EXPECT_FALSE(link.translation.deadline());

    link.down(question);
    for (int i = 0; i < 2; ++i) {
        link.pass(200ms);
        EXPECT_EQ(link.sent, Frames{asked});
    }
    link.pass(200ms);
    EXPECT_TRUE(link.sent.empty());
    EXPECT_FALSE(link.translation.deadline());
    EXPECT_EQ(link.counted().unanswered, 1u);
}

TEST(V7Translation, one_request_is_in_flight_and_the_others_wait_in_their_order) {
    V7Link link{fc};
    EXPECT_EQ(link.down(0xE0, {2, 0, 0}).size(), 1u);
    for (std::uint8_t n = 1; n <= 16; ++n) EXPECT_TRUE(link.down(0xE0, {2, n, 0}).empty());
    EXPECT_EQ(link.counted().down_queue_full, 0u);
    EXPECT_TRUE(link.down(0xE0, {2, 17, 0}).empty());
    EXPECT_EQ(link.counted().down_queue_full, 1u);
    for (std::uint8_t n = 0; n <= 16; ++n) {
        link.sent.clear();
        EXPECT_EQ(link.up(0xE2, {n, 0, 1, 2, 3, 4}), Frames{frame(fc, host, 0xE1, {n, 0, 1, 2, 3, 4})});
        EXPECT_EQ(link.sent, n < 16 ? Frames{v7_frame(0x05, 0xE1, {static_cast<std::uint8_t>(n + 1), 0})} : Frames{});
    }
}

TEST(V7Translation, two_hosts_that_ask_the_same_are_answered_in_turn) {
    V7Link link{fc};
    EXPECT_EQ(link.down(frame(host, fc, 0xE0, {2, 1, 0})).size(), 1u);
    EXPECT_EQ(link.down(frame(0xD2, fc, 0xE0, {2, 1, 0})).size(), 0u);
    EXPECT_EQ(one(link.up(0xE2, {1, 0, 7, 0, 0, 0}))[2], host);
    EXPECT_EQ(one(link.up(0xE2, {1, 0, 7, 0, 0, 0}))[2], 0xD2);
}

TEST(V7Translation, a_write_is_sent_once_and_acknowledged_by_the_device) {
    V7Link link{fc};
    const Bytes write = frame(host, fc, 0xE1, {11, 0, 0xE8, 3, 0, 0});
    const Bytes sent = one(link.down(write));
    EXPECT_EQ(sent, hex("AA05E2060B00E80300008DF6"));
    EXPECT_TRUE(link.down(0xE0, {2, 11, 0}).empty()) << "waits for the acknowledgement";
    link.sent.clear();
    EXPECT_EQ(link.up(0x00, check_of(sent)), Frames{frame(fc, host, 0x00, check_of_v8(write))});
    EXPECT_EQ(link.sent, Frames{v7_frame(0x05, 0xE1, {11, 0})});

    V7Link silent{fc};
    silent.down(write);
    silent.pass(200ms);
    EXPECT_TRUE(silent.sent.empty());
    EXPECT_EQ(silent.counted().unanswered, 1u);
    EXPECT_EQ(silent.up(0x00, check_of(sent)).size(), 1u) << "late, but within a second";
}

TEST(V7Translation, values_that_were_not_requested_are_sent_to_the_host) {
    V7Link link{fc};
    EXPECT_EQ(link.up(v7_frame(0xAF, 0xE2, {11, 0, 1, 0, 0, 0})), Frames{frame(fc, host, 0xE1, {11, 0, 1, 0, 0, 0})});
}

// A tapped line, on which another computer writes to the device.
TEST(V7Translation, a_write_to_the_device_is_not_taken_for_a_value_of_it) {
    V7Link link{imu};
    for (const std::uint8_t to : Bytes{0x60, 0x61, 0xFF}) EXPECT_TRUE(link.up(v7_frame(to, 0xE2, {11, 0, 1, 0, 0, 0})).empty());
    EXPECT_EQ(link.counted().up_command, 2u);
    EXPECT_EQ(link.counted().up_unmatched, 1u) << "to all: may also be a late answer";
    link.down(0xE0, {2, 11, 0});
    EXPECT_TRUE(link.up(v7_frame(0x60, 0xE2, {11, 0, 1, 0, 0, 0})).empty());
    EXPECT_EQ(link.up(v7_frame(0xFF, 0xE2, {11, 0, 2, 0, 0, 0})).size(), 1u) << "some devices answer to all";
    EXPECT_TRUE(link.up(v7_frame(0xFF, 0xE2, {11, 0, 2, 0, 0, 0})).empty());
    EXPECT_EQ(link.counted().up_unmatched, 2u) << "to a question that was repeated";
}

TEST(V7Translation, probes_contain_no_second_head) {
    for (std::uint32_t line = 1; line < 3000; ++line) {
        V7EchoWatch watch{line * 0x01010105};
        const auto probe = watch.probe(ano::TimePoint{1h});
        ASSERT_TRUE(probe && v7::frame_at(probe->bytes()));
        EXPECT_EQ(std::count(probe->bytes().begin(), probe->bytes().end(), 0xAA), 1) << line;
    }
}

TEST(V7Translation, acknowledgements_pass_when_the_line_returns_probes_of_another_gateway) {
    V7Link link{imu};
    EXPECT_TRUE(link.up(v7_frame(0x00, 0xFB, {'R', 'i', 'n', 'g', 1, 2, 3, 4})).empty());
    EXPECT_EQ(link.counted().up_loop, 1u);
    for (int i = 0; i < 20; ++i) {
        const Bytes sent = one(link.down(0xC0, {0x10, 0, 1}));
        EXPECT_EQ(link.up(0x00, check_of(sent)).size(), 1u);
    }
}

TEST(V7Translation, the_receiver_of_parameters_is_the_device_and_can_be_set) {
    for (const auto& [v8, v7] : {std::pair{0xDC, 0x05}, {0xDD, 0x60}, {0xDB, 0x61}, {0xDE, 0x22}, {0xE6, 0x10}, {50, 0xFF}}) {
        V7Link link{static_cast<std::uint8_t>(v8)};
        EXPECT_EQ(one(link.down(0xE0, {2, 1, 0}))[1], v7) << v8;
        EXPECT_EQ(one(link.down(0xC0, {1, 0, 1}))[1], 0xFF) << v8;
    }
    V7Link link{{.address = fc, .v7_address = 0x61}};
    EXPECT_EQ(one(link.down(0xE0, {2, 1, 0}))[1], 0x61);
    EXPECT_EQ(one(link.down(0xC0, {1, 0, 1}))[1], 0x61);
    V7Link line{{.address = imu, .sources = {{0x51, 0x51, flow}}}};
    EXPECT_EQ(one(line.down(frame(host, flow, 0xE0, {2, 1, 0})))[1], 0x22);
    EXPECT_EQ(one(line.up(0xE2, {1, 0, 9, 0, 0, 0}))[1], flow);
}

TEST(V7Translation, waypoints_are_asked_for_and_written) {
    V7Link link{fc};
    EXPECT_EQ(link.down(0x60, {0xFF}), Frames{v7_frame(0xFF, 0x60, {0xFF})});
    EXPECT_EQ(link.up(0x60, {5}), Frames{frame(fc, host, 0x60, {5})});
    EXPECT_EQ(link.down(0x60, {3}).size(), 1u);
    Bytes waypoint(22, 7);
    EXPECT_EQ(link.up(0x61, waypoint).size(), 1u);
    EXPECT_TRUE(link.translation.deadline()) << "waypoint 7 does not answer the question for 3";
    waypoint[0] = 3;
    EXPECT_EQ(link.up(0x61, waypoint), Frames{frame(fc, host, 0x61, waypoint)});
    EXPECT_FALSE(link.translation.deadline());
    const Bytes write = frame(host, fc, 0x61, waypoint);
    const Bytes sent = one(link.down(write));
    EXPECT_EQ(sent, v7_frame(0xFF, 0x61, waypoint));
    EXPECT_EQ(link.up(0x00, check_of(sent)), Frames{frame(fc, host, 0x00, check_of_v8(write))});
}

// --- Descriptions

TEST(V7Translation, a_table_describes_parameters_by_their_rows) {
    V7Link link{{.address = fc, .parameters = {{11, "PID1_P", 1000}, {1000, "CAL_AOFF_X", 1000, true}}}};
    link.down(0xE0, {1, 0, 0});
    EXPECT_EQ(link.received, Frames{frame(fc, host, 0xE0, {1, 2, 0})});
    link.down(0xE0, {3, 0, 0});
    const Bytes info = data_of(one(link.received));
    EXPECT_EQ((Bytes{info.begin(), info.begin() + 9}), (Bytes{0, 0, 5, 'P', 'I', 'D', '1', '_', 'P'}));
    EXPECT_EQ(std::string(info.begin() + 23, info.end()), "number 11, value x 1000");
    link.down(0xE0, {3, 1, 0});
    EXPECT_EQ(data_of(one(link.received))[2], 8) << "calibration is f32";
    EXPECT_EQ(link.down(0xE0, {2, 1, 0}), Frames{v7_frame(0x05, 0xE1, {0xE8, 3})});
    EXPECT_EQ(data_of(one(link.up(0xE2, pack(std::uint16_t{1000}, std::int32_t{-1500})))), pack(std::uint16_t{1}, -1.5f));
    EXPECT_EQ(link.down(0xE1, pack(std::uint16_t{1}, 0.0014f)),
              Frames{v7_frame(0x05, 0xE2, pack(std::uint16_t{1000}, std::int32_t{1}))});
    EXPECT_TRUE(link.down(0xE0, {3, 2, 0}).empty());
    EXPECT_TRUE(link.received.empty());
    EXPECT_TRUE(link.down(0xE0, {2, 2, 0}).empty());
    EXPECT_TRUE(link.down(0xE1, pack(std::uint16_t{2}, 1.0f)).empty());
    EXPECT_EQ(link.counted().down_no_counterpart, 3u);
    EXPECT_TRUE(link.down(0xE1, pack(std::uint16_t{1}, std::nanf(""))).empty());
    EXPECT_EQ(link.counted().down_unrepresentable, 1u);
}

TEST(V7Translation, the_tables_of_known_devices_fit_v8) {
    for (const auto& table : {v7_lx_parameters(), v7_tkz_parameters()}) {
        ASSERT_GT(table.size(), 50u);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < table.size(); ++i) {
            EXPECT_LE(table[i].name.size(), 20u);
            EXPECT_GT(table[i].scale, 0u);
            EXPECT_TRUE(i == 0 || table[i].number > table[i - 1].number) << table[i].name;
            names.push_back(table[i].name);
        }
        const auto first = std::find(names.begin(), names.end(), "CAL_AOFF_X");
        ASSERT_EQ(names.end() - first, 21);
        EXPECT_EQ(first[14], "CAL_AEM3_Z");
        EXPECT_EQ(first[20], "CAL_MSEN_Z");
    }
    EXPECT_EQ(v7_lx_parameters()[4].number, 151);
    EXPECT_EQ(v7_tkz_parameters()[4].name, "PID1_P");
}

TEST(V7Translation, device_information_has_the_versions_that_the_device_states) {
    V7Link link{{.address = imu, .name = "LX"}};
    EXPECT_EQ(link.down(frame(host, everybody, 0xE0, {0, 0, 0})), Frames{v7_frame(0x60, 0xE1, {2, 0})});
    EXPECT_TRUE(link.up(0xE2, pack(std::uint16_t{2}, std::int32_t{17})).empty());
    EXPECT_TRUE(link.up(0xE2, pack(std::uint16_t{3}, std::int32_t{205})).empty());
    EXPECT_EQ(
        link.up(0xE2, pack(std::uint16_t{4}, INT32_MIN)),
        Frames{frame(imu, host, 0xE3,
                     pack(imu, std::uint16_t{17}, std::uint16_t{205}, std::uint16_t{0}, std::uint16_t{800}) + Bytes{'L', 'X'})});
    link.down(0xE0, {0, 0, 0});
    EXPECT_TRUE(link.sent.empty());
    EXPECT_EQ(link.received.size(), 1u) << "known now";
}

TEST(V7Translation, a_device_that_is_absent_is_not_described) {
    V7Link link{imu};
    link.down(0xE0, {0, 0, 0});
    for (int i = 0; i < 3; ++i) {
        link.pass(200ms);
        EXPECT_TRUE(link.received.empty());
    }
    EXPECT_FALSE(link.translation.deadline());
    link.up(0x07, Bytes(6));
    link.down(0xE0, {0, 0, 0});
    for (int i = 0; i < 3; ++i) link.pass(200ms);
    EXPECT_EQ(data_of(one(link.received)).size(), 9 + std::string{"V7 IMU"}.size()) << "it sends, but states no versions";
    link.down(0xE0, {0, 0, 0});
    EXPECT_EQ(link.received.size(), 1u);
    link.now += 3s;
    EXPECT_EQ(link.down(0xE0, {0, 0, 0}).size(), 1u) << "it may be another device now";
    EXPECT_TRUE(link.received.empty());
}

TEST(V7Translation, versions_are_never_stated_in_part) {
    V7Link link{imu};
    link.down(0xE0, {0, 0, 0});
    link.up(0xE2, pack(std::uint16_t{2}, std::int32_t{17}));
    for (int i = 0; i < 3; ++i) link.pass(200ms);
    EXPECT_TRUE(link.received.empty()) << "a host would take it for another device when the rest is known";
    EXPECT_FALSE(link.translation.deadline());
    EXPECT_EQ(link.down(0xE0, {0, 0, 0}), Frames{v7_frame(0x60, 0xE1, {3, 0})}) << "only for the unknown ones";
    link.up(0xE2, pack(std::uint16_t{3}, std::int32_t{18}));
    EXPECT_EQ(ano::load<std::uint16_t>(data_of(one(link.up(0xE2, pack(std::uint16_t{4}, std::int32_t{19})))).data() + 1), 17);
}

TEST(V7Translation, actions_on_all_parameters_become_commands) {
    V7Link link{imu};
    link.up(0x07, Bytes(6));
    const auto command = [](std::uint8_t cmd0, std::uint8_t cmd1) {
        return Frames{v7_frame(0xFF, 0xE0, {1, cmd0, cmd1, 0, 0, 0, 0, 0, 0, 0, 0})};
    };
    EXPECT_EQ(link.down(0xE0, {0x10, 0xAA, 0}), command(0, 0xAC));
    EXPECT_EQ(link.down(0xE0, {0x10, 0x30, 0}), command(0x30, 2));
    const Bytes action = frame(host, imu, 0xE0, {0x10, 0x20, 0});
    const Bytes sent = one(link.down(action));
    EXPECT_EQ(Frames{sent}, command(0x30, 1));
    EXPECT_EQ(link.up(0x00, check_of(sent)), Frames{frame(imu, host, 0x00, check_of_v8(action))});
    for (const std::uint8_t own : Bytes{0xAB, 0x21, 0x31}) {
        const Bytes save = frame(host, imu, 0xE0, {0x10, own, 0});
        EXPECT_TRUE(link.down(save).empty());
        EXPECT_EQ(link.received, Frames{frame(imu, host, 0x00, check_of_v8(save))});
    }
    link.now += 3s;
    link.down(0xE0, {0x10, 0xAB, 0});
    EXPECT_TRUE(link.received.empty()) << "nothing is confirmed in the name of a device that is silent";
}

// --- Writes in their order

TEST(V7Translation, writes_of_one_parameter_end_with_the_value_of_the_last) {
    V7Link link{fc};
    const auto write = [](std::uint8_t value, std::uint8_t from = host) {
        return frame(from, fc, 0xE1, {11, 0, value, 0, 0, 0});
    };
    Frames sent = link.down(write(5));
    link.pass(60ms);
    for (const Bytes& next : {write(6), write(6), write(5), write(5), write(7, 0xD2), write(5)})
        for (const Bytes& now : link.down(next)) sent.push_back(now);
    EXPECT_EQ(link.counted().merged, 2u);
    while (link.translation.deadline()) {
        link.sent.clear();
        link.up(0x00, check_of(sent.back()));
        sent.insert(sent.end(), link.sent.begin(), link.sent.end());
    }
    Bytes values;
    for (const Bytes& v7 : sent) values.push_back(v7[6]);
    EXPECT_EQ(values, (Bytes{5, 6, 5, 7, 5}));
}

TEST(V7Translation, a_value_read_after_a_write_is_not_that_of_before) {
    V7Link link{fc};
    const Bytes read = frame(host, fc, 0xE0, {2, 11, 0}), write = frame(host, fc, 0xE1, {11, 0, 5, 0, 0, 0});
    link.down(read);
    link.down(write);
    EXPECT_TRUE(link.down(read).empty());
    EXPECT_TRUE(link.down(frame(0xD2, fc, 0xE0, {2, 11, 0})).empty());
    EXPECT_TRUE(link.down(read).empty());
    EXPECT_EQ(link.counted().merged, 1u) << "the last two reads of one host";
    link.up(0xE2, {11, 0, 4, 0, 0, 0});
    link.up(0x00, check_of(one(link.sent)));
    EXPECT_EQ(link.up(0xE2, {11, 0, 5, 0, 0, 0}), Frames{frame(fc, host, 0xE1, {11, 0, 5, 0, 0, 0})});
}

TEST(V7Translation, acknowledgements_that_are_forgotten_are_counted) {
    V7Link link{fc};
    Frames sent;
    for (std::uint8_t n = 0; n < 33; ++n) sent.push_back(one(link.down(0xC0, {0x10, 0, 5, n, 0})));
    EXPECT_EQ(link.counted().forgotten, 1u);
    EXPECT_TRUE(link.up(0x00, check_of(sent[0])).empty());
    for (std::size_t n = 1; n < 33; ++n) EXPECT_EQ(link.up(0x00, check_of(sent[n])).size(), 1u);
    link.now += 1s;
    for (std::uint8_t n = 0; n < 32; ++n) link.down(0xC0, {0x10, 0, 5, n, 0});
    EXPECT_EQ(link.counted().forgotten, 1u);
    link.now += 1s;
    link.down(0xC0, {0x10, 0, 1});
    EXPECT_EQ(link.counted().forgotten, 1u) << "the others were no longer expected";
}

// --- Lines that return what is sent

TEST(V7Echo, of_a_question_or_a_write_is_no_answer) {
    V7Link link{{.address = fc, .v7_address = 0xFF}};
    EXPECT_TRUE(link.up(one(link.down(0xC0, {0x10, 0, 1}))).empty());
    EXPECT_TRUE(link.up(one(link.down(0x40, Bytes(20)))).empty());
    EXPECT_TRUE(link.up(one(link.down(0x60, {3}))).empty());
    EXPECT_TRUE(link.translation.deadline()) << "3 is not the number of waypoints";
    EXPECT_EQ(link.up(0x60, {3}).size(), 1u);
    const Bytes write = one(link.down(0xE1, {11, 0, 5, 0, 0, 0}));
    EXPECT_TRUE(link.up(write).empty()) << "not the value of the device";
    EXPECT_EQ(link.counted().up_echo, 4u);
    EXPECT_EQ(link.counted().up_command, 0u);
    link.up(0x00, check_of(write));
    link.down(0xE0, {2, 11, 0});
    EXPECT_EQ(link.up(write), Frames{frame(fc, host, 0xE1, {11, 0, 5, 0, 0, 0})}) << "the answer of the device is equal";
}

TEST(V7Echo, is_no_sign_of_the_device) {
    V7Link link{imu};
    link.up(one(link.down(0xC0, {0x10, 0, 1})));
    link.down(0xE0, {0x10, 0xAB, 0});
    EXPECT_TRUE(link.received.empty());
}

TEST(V7Echo, of_a_write_that_was_acknowledged_is_the_answer_of_the_device) {
    V7Link link{{.address = fc, .v7_address = 0xFF}};
    const Bytes write = one(link.down(0xE1, {11, 0, 5, 0, 0, 0}));
    link.up(0x00, check_of(write));
    EXPECT_EQ(link.down(0xE0, {2, 11, 0}).size(), 1u);
    EXPECT_EQ(link.up(write), Frames{frame(fc, host, 0xE1, {11, 0, 5, 0, 0, 0})});
}

const Bytes flow_at_rest = v7_frame(0xFF, 0x51, {0, 1, 0, 0, 200});

TEST(V7Echo, telemetry_of_two_devices_may_be_equal) {
    V7Link link{{.address = imu, .line = 7}};
    for (int i = 0; i < 1000; ++i) {
        link.down(frame(flow, everybody, 0x51, {0, 1, 0, 0, 200}));
        EXPECT_EQ(link.up(flow_at_rest).size(), 1u);
        link.pass(20ms);
    }
    EXPECT_EQ(link.probes.size(), 4u) << "one in 5 s";
    for (const Bytes& probe : link.probes) EXPECT_EQ(probe[1], 0) << "no device has this address";
    EXPECT_EQ(drops(link.counted()), 0u);
}

TEST(V7Echo, of_telemetry_is_dropped_on_a_line_that_returns_the_probes) {
    V7Link link{{.address = imu, .line = 7}};
    const auto echo = [&] {
        for (const Bytes& v7 : std::exchange(link.probes, {})) EXPECT_TRUE(link.up(v7).empty());
        for (const Bytes& v7 : std::exchange(link.sent, {})) EXPECT_TRUE(link.up(v7).empty());
    };
    for (int i = 0; i < 1000; ++i) {
        link.down(frame(flow, everybody, 0x51, {0, 1, 0, 0, static_cast<std::uint8_t>(i)}));
        echo();
        EXPECT_EQ(link.up(flow_at_rest).size(), 1u) << "of the device";
        link.pass(20ms);
    }
    EXPECT_EQ(link.counted().up_echo, 1004u);
}

// Two links of one gateway, connected with each other.
TEST(V7Echo, no_telemetry_circulates_in_a_loop) {
    V7Link a{{.address = imu, .line = 7}}, b{{.address = fc, .line = 8}};
    std::size_t passes = 0, rounds = 0;
    a.down(frame(flow, everybody, 0xF1, {1, 2, 3}));
    while (!a.sent.empty() && ++rounds < 100) {
        for (const Bytes& probe : std::exchange(a.probes, {})) EXPECT_TRUE(b.up(probe).empty());
        const Frames onward = b.up(one(a.sent));
        a.sent.clear();
        passes += onward.size();
        for (const Bytes& v8 : onward) a.down(v8);
    }
    EXPECT_LE(passes, 2u);
    EXPECT_GT(b.counted().up_loop, 0u);
}

TEST(V7Echo, commands_have_a_probe_ahead_only_if_the_gateway_has_a_link_with_a_host_program) {
    V7Lines lines;
    V7Link link{{.address = imu, .line = 7, .lines = &lines}};
    link.down(0xC0, {0x10, 0, 1});
    EXPECT_TRUE(link.probes.empty());
    {
        const V7HostTranslation program{{.address = imu, .lines = &lines}};
        for (int i = 0; i < 2; ++i) {
            link.down(0xC0, {0x10, 0, 1});
            EXPECT_EQ(std::exchange(link.probes, {}).size(), 1u);
        }
        link.down(0x40, Bytes(20));
        EXPECT_TRUE(link.probes.empty()) << "not for 5 s";
    }
    link.down(0xC0, {0x10, 0, 1});
    EXPECT_TRUE(link.probes.empty());
}

// --- Laws

TEST(V7Translation, drops_and_counts_messages_without_a_counterpart_in_v7) {
    V7Settings settings{.address = imu};
    settings.down.set();
    V7Link link{settings};
    for (const std::uint8_t id : Bytes{0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xC2, 0xE2, 0xE3, 0xF0, 0xFB})
        EXPECT_TRUE(link.down(id, Bytes(23, 1)).empty()) << int{id};
    EXPECT_EQ(link.counted().down_no_counterpart, 10u);
    EXPECT_TRUE(link.down(0xF1, {}).empty());
    EXPECT_TRUE(link.down(0xF1, Bytes(45)).empty());
    EXPECT_EQ(link.translation.last_drop(), &V7Counters::down_too_big);
    EXPECT_TRUE(link.down(0xA1, pack(3e9f)).empty());
    EXPECT_EQ(link.down(0xA1, pack(-4.6f) + Bytes{'x'}), Frames{v7_frame(0xFF, 0xA1, pack(std::int32_t{-5}) + Bytes{'x'})});
    EXPECT_EQ(link.counted().down_malformed, 1u);
    EXPECT_EQ(link.counted().down_too_big, 1u);
    EXPECT_EQ(link.counted().down_unrepresentable, 1u);
    V7Link usual{imu};
    for (const std::uint8_t id : Bytes{0x11, 0xA1, 0xC5}) EXPECT_TRUE(usual.down(id, {1, 2, 3, 4}).empty()) << int{id};
    EXPECT_EQ(usual.counted().down_not_allowed, 3u);
}

TEST(V7Translation, no_command_is_longer_than_v7_max) {
    V7Settings settings{.address = imu};
    settings.max_data = 10;
    V7Link link{settings};
    EXPECT_TRUE(link.down(0xC0, {0x10, 0, 2}).empty());
    EXPECT_EQ(link.counted().down_too_big, 1u);
    settings.max_data = 11;
    EXPECT_EQ(V7Link{settings}.down(0xC0, {0x10, 0, 2}).size(), 1u);
}

TEST(V7Translation, nothing_reaches_a_device_that_it_would_take_for_its_own_sensors_nor_erases_it) {
    V7Settings settings{.address = imu, .sources = {{0x51, 0x51, flow}}};
    settings.down.set();    // whatever is allowed
    settings.parameters = v7_lx_parameters();
    settings.max_data = 255;
    V7Link link{settings};
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        support::Random random{seed};
        for (int i = 0; i < 300; ++i) {
            Bytes data(random.below(30u));
            for (auto& byte : data) byte = random.of<std::uint8_t>({0, 1, 2, 0x10, 0x20, 0xAA, random.byte()});
            if (random.one_in(4)) data.insert(data.begin(), {0x01, 0x20, 0xAA, random.byte()});
            const auto id = random.of<std::uint8_t>({0xC0, 0xE0, 0xE1, 0x61, random.byte()});
            if (random.one_in(3)) link.up(v7_frame(random.of<std::uint8_t>({0xAF, 0xFF, random.byte()}), id, data));
            else link.down(frame(host, random.of<std::uint8_t>({imu, flow, everybody}), id, data));
            for (const Bytes& sent : link.sent) {
                ASSERT_FALSE((sent[2] >= 0x01 && sent[2] <= 0x0F) || sent[2] == 0x20 || sent[2] == 0x21);
                ASSERT_FALSE(sent[2] == 0xE0 && sent[4] == 0x01 && sent[5] == 0x20 && sent[6] == 0xAA);
            }
            link.pass(random.of<ano::Duration>({0ms, 50ms, 200ms}));
        }
    }
    EXPECT_GT(link.counted().down_own_sensor, 100u);
    EXPECT_GT(link.counted().down_erase, 100u);
    EXPECT_GT(link.counted().down, 1000u);
}

// A device that has lost the header of the outer frame finds the inner one.
TEST(V7Translation, no_frame_contains_one_that_a_device_must_not_get) {
    V7Link link{{.address = imu, .max_data = 255}};
    const Bytes measurement = v7_frame(0xFF, 0x03, Bytes(7)), erase = v7_frame(0xFF, 0xE0, {0x01, 0x20, 0xAA, 1}),
                unlock = v7_frame(0xFF, 0xE0, {0x10, 0, 1});
    EXPECT_TRUE(link.down(0xF1, Bytes{1, 0xAA} + measurement + Bytes{2}).empty());
    EXPECT_EQ(link.counted().down_own_sensor, 1u);
    EXPECT_TRUE(link.down(0xA0, Bytes{0} + erase).empty());
    EXPECT_EQ(link.counted().down_erase, 1u);
    EXPECT_EQ(link.down(0xF1, unlock).size(), 1u);
    Bytes damaged = measurement;
    ++damaged.back();
    EXPECT_EQ(link.down(0xF1, damaged).size(), 1u);
    EXPECT_EQ(drops(link.counted()), 2u);
}

/// Whether a device that searches for a frame at every byte of `stream` finds one that it must not get.
bool has_forbidden_frame(const Bytes& stream) {
    for (auto at = stream.begin(); at != stream.end(); ++at)
        if (const auto f = v7::frame_at({at, stream.end()}); f && V7Translation::is_of_own_sensor(f->id())) return true;
        else if (f && f->id() == 0xE0 && f->data().size() >= 3 && f->data()[0] == 1 && f->data()[1] == 0x20 &&
                 f->data()[2] == 0xAA)
            return true;
    return false;
}

/// DATA of the last of several frames, with which the frame that began in the first ends. `begun`: what was sent since its header;
/// `before`: bytes of DATA ahead of its checks.
Bytes end_of_frame(const Bytes& begun, std::size_t before) {
    const Bytes last = v7_frame(0xFF, 0xF1, Bytes(before + 2));
    Bytes all = begun + Bytes(last.begin(), last.end() - 2);
    ano::seal(all);
    EXPECT_TRUE(v7::frame_at(all));
    return {all.end() - static_cast<std::ptrdiff_t>(before + 2), all.end()};
}

// A device that lost the header of the first would search in both.
TEST(V7Translation, no_frame_is_formed_of_the_end_of_one_and_the_beginning_of_the_next) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        support::Random random{seed};
        V7Link link{{.address = imu, .line = random.one_in(2) ? 7u : 0u}};
        const std::size_t before = random.below(10u), more = random.below(3u);
        const bool erases = random.one_in(2);
        const std::uint8_t id = random.of<std::uint8_t>({0x01, 0x0F, 0x20, 0x21});
        Bytes header = erases ? Bytes{0xAA, 0xFF, 0xE0, 0, 0x01, 0x20, 0xAA} : Bytes{0xAA, 0xFF, id, 0};
        header[3] = static_cast<std::uint8_t>(header.size() - 4 + 2 + more * (v7::overhead + 3) + 4 + before);
        Bytes stream = one(link.down(0xF1, Bytes(random.below(5u), 0x55) + header));
        for (std::size_t i = 0; i < more; ++i) stream = stream + one(link.down(0xF2, {1, 2, 3}));
        link.probes.clear();
        const auto begins = std::search(stream.begin(), stream.end(), header.begin(), header.end());
        const Bytes data = end_of_frame({begins, stream.end()}, before);
        const Bytes last = v7_frame(0xFF, 0xF1, data);
        ASSERT_TRUE(has_forbidden_frame(stream + last)) << "the host forms one";
        const Frames end = link.down(0xF1, data);
        if (link.translation.settings().line == 0) {
            EXPECT_TRUE(end.empty());
            EXPECT_EQ(erases ? link.counted().down_erase : link.counted().down_own_sensor, 1u);
            EXPECT_EQ(drops(link.counted()), 1u);
            EXPECT_TRUE(link.down(0xF1, data).empty()) << "still";
            EXPECT_EQ(link.down(0xF1, {1}).size(), 1u);
        } else {
            ASSERT_EQ(link.probes.size(), 1u) << "takes the two apart";
            EXPECT_EQ(end, Frames{last}) << "nobody's frame is lost for it";
            EXPECT_FALSE(has_forbidden_frame(stream + link.probes[0] + last));
            EXPECT_EQ(drops(link.counted()), 0u);
        }
    }
}

TEST(V7Translation, an_emergency_stop_is_sent_although_it_would_complete_a_frame_that_the_device_must_not_get) {
    V7Link link{{.address = imu, .line = 7}};
    const Bytes stop = v7_frame(0xFF, 0xE0, {0x10, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0});
    const Bytes begun = one(link.down(0xF1, {21, 0xAA, 0xFF, 0x03, 17, 27, 0}));    // the checks would be zeros in the stop
    ASSERT_TRUE(has_forbidden_frame(begun + stop));
    link.probes.clear();
    EXPECT_EQ(link.down(0xC0, {0x10, 0, 2}), Frames{stop});
    EXPECT_EQ(link.probes.size(), 1u);
    EXPECT_FALSE(has_forbidden_frame(begun + link.probes.at(0) + stop));
}

TEST(V7Translation, a_command_that_is_not_sent_is_not_acknowledged) {
    V7Link link{{.address = imu, .ack = V7Ack::sent}};
    const Bytes measurement = v7_frame(0xFF, 0x03);
    EXPECT_TRUE(link.down(0xC0, Bytes{0x10, 0, 5} + measurement).empty());
    EXPECT_EQ(link.counted().down_own_sensor, 1u);
    EXPECT_TRUE(link.received.empty());
    EXPECT_TRUE(link.down(0x61, Bytes{1} + measurement + Bytes(15)).empty());
    EXPECT_TRUE(link.received.empty());
}

TEST(V7Translation, a_frame_with_several_distances_is_dropped_once) {
    V7Link link{imu};
    Bytes distances{100};
    for (int i = 0; i < 5; ++i)
        distances = distances + pack(std::uint16_t{27000}, std::uint16_t{10});    // V7 has no such direction
    link.down(0x34, distances);
    EXPECT_EQ(drops(link.counted()), 1u);
}

TEST(V7Translation, allocates_only_at_construction) {
    V7Settings settings{.address = imu};
    settings.parameters = v7_lx_parameters();
    V7Translation translation{settings};
    struct Count final : V7Output {
        void to_device(v7::FrameView) override { ++n; }
        void from_device(ano::FrameView) override { ++n; }
        unsigned n = 0;
    } output;
    Frames v7;
    for (const auto& vector : support::v7_vectors("valid")) v7.push_back(vector.v7);
    Frames v8;
    for (unsigned id = 0; id < 256; ++id)
        for (const std::uint8_t first : Bytes{0, 1, 2, 3, 0x10})
            v8.push_back(frame(host, imu, static_cast<std::uint8_t>(id), {first, 0, 0, 0, 0, 0}));
    ano::TimePoint now{1h};
    const auto before = support::allocations;
    for (const Bytes& f : v7) translation.up(v7::FrameView{f}, now, output);
    for (const Bytes& f : v8) {
        translation.down(ano::FrameView{f}, now, output);
        translation.expire(now += 50ms, output);
    }
    EXPECT_EQ(support::allocations, before);
    EXPECT_GT(output.n, 100u);
}

TEST(V7Translation, a_request_that_its_host_repeats_is_sent_eight_times_at_most) {
    V7Link link{fc};
    const Bytes question = frame(host, fc, 0xE0, {2, 11, 0});
    std::size_t sent = link.down(question).size();
    for (int i = 0; i < 20 && link.translation.deadline(); ++i) {
        link.pass(50ms);
        sent += link.sent.size();
        if (link.translation.deadline()) sent += link.down(question).size();
    }
    EXPECT_EQ(sent, 8u);
    EXPECT_EQ(link.counted().unanswered, 1u) << "then others have their turn";
}

TEST(V7Translation, a_write_that_its_host_repeats_is_sent_again_after_50_ms) {
    V7Link link{fc};
    const Bytes write = frame(host, fc, 0xE1, {11, 0, 5, 0, 0, 0});
    const Frames first = link.down(write);
    ASSERT_EQ(first.size(), 1u);
    link.pass(49ms);
    EXPECT_TRUE(link.down(write).empty());
    EXPECT_EQ(link.counted().merged, 1u);
    link.pass(1ms);
    EXPECT_EQ(link.down(write), first);
    link.pass(199ms);
    ASSERT_TRUE(link.translation.deadline()) << "it waits for the answer to the second one";
    const Bytes& sent = first[0];
    const Bytes answer = v7_frame(0xAF, 0x00, {0xE2, sent[sent.size() - 2], sent.back()});
    EXPECT_EQ(link.up(answer), Frames{frame(fc, host, 0x00, {0xE1, write[write.size() - 2], write.back()})});
    EXPECT_FALSE(link.translation.deadline());
}

TEST(V7Translation, a_real_number_is_read_back_as_the_device_has_it) {
    V7Settings settings{.address = imu};
    settings.parameters = {{1000, "CAL_AOFF_X", 1000, true}};
    V7Link link{settings};
    ASSERT_EQ(link.down(0xE1, pack(std::uint16_t{0}, -7.17843f)),
              Frames{v7_frame(0x60, 0xE2, pack(std::uint16_t{1000}, std::int32_t{-7178}))});
    link.pass(1s);
    const auto read = [&](std::int32_t in_device) {
        link.down(0xE0, {2, 0, 0});
        return link.up(0xE2, pack(std::uint16_t{1000}, in_device));
    };
    EXPECT_EQ(read(-7178), Frames{frame(imu, host, 0xE1, pack(std::uint16_t{0}, -7.178f))});
    EXPECT_EQ(read(-7179), Frames{frame(imu, host, 0xE1, pack(std::uint16_t{0}, -7.179f))});
}

// A table of the user (v7_params=FILE).
TEST(V7TableFile, has_a_parameter_in_each_line) {
    std::vector<V7Parameter> rows;
    EXPECT_EQ(parse_v7_parameters(
                  "# number, name, scale, type\n11, PID1_P, 1000\r\n\n 82,TAKEOFF_HEIGHT\n1000, CAL_AOFF_X, 1000, f32", rows),
              "");
    EXPECT_EQ(rows, (std::vector<V7Parameter>{{11, "PID1_P", 1000}, {82, "TAKEOFF_HEIGHT"}, {1000, "CAL_AOFF_X", 1000, true}}));
}

TEST(V7TableFile, names_the_line_of_an_error) {
    std::vector<V7Parameter> rows;
    const auto fault = [&](std::string_view text) { return parse_v7_parameters(text, rows); };
    EXPECT_EQ(fault("1, A\nx, B\n"), "line 2: NUMBER must be 0 to 65535");
    EXPECT_EQ(fault("65536, B"), "line 1: NUMBER must be 0 to 65535");
    EXPECT_EQ(fault("1"), "line 1: NAME must have 1 to 20 bytes");
    EXPECT_EQ(fault("1, 123456789012345678901"), "line 1: NAME must have 1 to 20 bytes");
    EXPECT_EQ(fault("1, A, 0"), "line 1: SCALE must be 1 to 4294967295");
    EXPECT_EQ(fault("1, A, 1, u8"), "line 1: TYPE must be i32 or f32");
    EXPECT_EQ(fault("1, A, 1, i32, x"), "line 1: more than NUMBER, NAME, SCALE, TYPE");
    EXPECT_EQ(fault("# comment\n1, A\n1, B"), "line 3: the number 1 occurs twice");
    EXPECT_EQ(fault("\n# nothing\n"), "no parameters in it");
    std::string many;
    for (int i = 0; i < 2001; ++i) many += std::to_string(i) + ",P" + std::to_string(i) + "\n";
    EXPECT_EQ(fault(many), "line 2001: more than 2000 parameters");
}

}    // namespace
}    // namespace v7_translation_tests
