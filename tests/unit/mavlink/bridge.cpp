// What anogate-mavlink decides, with a gateway and stations that the test plays.
#include <mavlink/bridge.hpp>

#include <ano/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace mavlink_bridge_tests {
namespace {

using namespace anogate;
using namespace anogate::mavlink;
using namespace std::chrono_literals;
using support::Bytes;

class FakeOutput final : public BridgeOutput {
public:
    bool transmit(std::size_t connection, std::span<const std::uint8_t> packet) override {
        if (room == 0) return false;
        --room;
        packets[connection].emplace_back(packet.begin(), packet.end());
        return true;
    }
    bool send(ano::Bytes frame) override {
        frames.emplace_back(frame.begin(), frame.end());
        return true;
    }
    bool request(DeviceRequest what, std::function<void(const http::Outcome&)> done) override {
        requests.push_back(std::move(what));
        waiting.push_back(std::move(done));
        return true;
    }
    void log(std::string_view) override {}
    std::uint64_t unix_us() override { return 1'700'000'000'000'000; }

    std::size_t room = 1'000'000;
    std::map<std::size_t, std::vector<Bytes>> packets;
    std::vector<Bytes> frames;
    std::vector<DeviceRequest> requests;
    std::vector<std::function<void(const http::Outcome&)>> waiting;
};

MavlinkSettings settings() {
    MavlinkSettings all;
    MavlinkDevice first, second;
    first.accept = {"velocity"};
    first.hover_throttle = 45'000;
    second.address = 0x21;
    second.system = 2;
    second.commands = CommandSet::vendor;
    all.devices = {first, second};
    return all;
}

class Bridge : public testing::Test {
protected:
    std::size_t open(bool speaks_first = false) { return bridge.open({Transport::reliable, speaks_first, true, "test"}, now); }
    template <class D>
    Bytes packet_of(const D& draft, Origin from = {255, 190}, Version version = Version::v2) {
        Bytes bytes(max_packet);
        bytes.resize(encode(bytes, version, from, sequence++, draft.row, draft.payload()));
        return bytes;
    }
    void receive(std::size_t connection, const Bytes& packet) { bridge.on_bytes(connection, packet, now); }
    void greet(std::size_t connection, Origin from = {255, 190}, Version version = Version::v2) {
        receive(connection, packet_of(Draft<"HEARTBEAT">{}.set<"type">(6), from, version));
    }
    void from_device(std::uint8_t address, std::uint8_t id, const Bytes& data) {
        const Bytes bytes = support::frame(address, 0xFE, id, data);
        FrameRecord record{.frame = ano::FrameView{bytes}};
        bridge.receive("fc", record, now);
    }
    void pass(ano::Duration time, ano::Duration step = 20ms) {
        for (const ano::TimePoint end = now + time; now < end;) {
            now += step;
            bridge.on_time(now);
        }
    }
    std::size_t count(std::size_t connection, std::uint32_t id, std::uint8_t system = 1) {
        return static_cast<std::size_t>(
            std::count_if(output.packets[connection].begin(), output.packets[connection].end(), [&](const Bytes& bytes) {
                const PacketView packet{bytes};
                return packet.id() == id && packet.system() == system;
            }));
    }
    template <ano::Name M>
    View<M> last(std::size_t connection) {
        const auto& sent = output.packets[connection];
        for (auto one = sent.rbegin(); one != sent.rend(); ++one)
            if (const auto message = as<M>(PacketView{*one})) return *message;
        ADD_FAILURE() << "no " << M.view();
        return View<M>{{}};
    }
    static auto command(Command number, float first, std::uint8_t system = 1, std::uint8_t confirmation = 0) {
        Draft<"COMMAND_LONG"> draft;
        draft.set<"target_system">(system).set<"target_component">(1).set<"command">(static_cast<std::uint16_t>(number));
        return draft.set<"param1">(first).set<"confirmation">(confirmation);
    }
    static http::Outcome outcome(unsigned status, std::string body) {
        http::Outcome result;
        result.answer.status = status;
        result.answer.body = std::move(body);
        return result;
    }

    std::uint8_t sequence = 0;
    MavlinkSettings all = settings();
    FakeOutput output;
    ano::TimePoint now{1h};
    MavlinkBridge bridge{all, output, now};
};

TEST_F(Bridge, sends_nothing_to_a_station_before_its_heartbeat) {
    const std::size_t listener = open(), configured = open(true);
    for (int i = 0; i < 100; ++i) receive(listener, packet_of(Draft<"PARAM_REQUEST_LIST">{}));
    receive(listener, packet_of(Draft<"HEARTBEAT">{}.set<"type">(2)));    // not a ground station
    pass(3s);
    EXPECT_TRUE(output.packets[listener].empty());
    EXPECT_EQ(bridge.counters().unexpected, 101u);
    EXPECT_TRUE(output.requests.empty());
    EXPECT_EQ(output.packets[configured].size(),
              count(configured, id_of<"HEARTBEAT">) + count(configured, id_of<"HEARTBEAT">, 2));
    greet(listener);
    pass(3s);
    EXPECT_GE(count(listener, id_of<"HEARTBEAT">), 3u);
    EXPECT_GE(count(listener, id_of<"HEARTBEAT">, 2), 3u);
}

TEST_F(Bridge, refuses_packets_with_the_system_ids_of_its_vehicles) {
    const std::size_t station = open();
    greet(station, {2, 1});
    greet(station, {1, 1});
    EXPECT_EQ(bridge.counters().forged, 2u);
    pass(2s);
    EXPECT_TRUE(output.packets[station].empty());
}

TEST_F(Bridge, commands_become_requests_and_responses_become_acknowledgements) {
    const std::size_t station = open();
    greet(station);
    receive(station, packet_of(command(Command::arm_disarm, 1)));
    for (std::uint8_t i = 1; i < 5; ++i) receive(station, packet_of(command(Command::arm_disarm, 1, 1, i)));
    ASSERT_EQ(output.requests.size(), 1u);
    EXPECT_EQ(output.requests[0].target, "/devices/0xDC/commands/UNLOCK?while_connected");
    EXPECT_EQ(output.requests[0].body, R"({"values":[]})");
    EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), 5);
    output.waiting[0](outcome(200, "{}"));
    pass(20ms);
    EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), 0);
    // The other vehicle has the vendor's numbers.
    receive(station, packet_of(command(Command::nav_takeoff, -1, 2).set<"param7">(std::nanf(""))));
    ASSERT_EQ(output.requests.size(), 2u);
    EXPECT_EQ(output.requests[1].target, "/devices/0x21/commands/by-cid?while_connected");
    EXPECT_EQ(output.requests[1].body, R"({"cid":[16,0,5],"values":[{"u16":0}]})");
    output.waiting[1](outcome(504, R"({"error": "no answer"})"));
    pass(20ms);
    EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), 4);
    EXPECT_EQ(last<"STATUSTEXT">(station).get<"text">(), "no answer");
    for (const auto& [status, result] : {std::pair{404u, 3}, std::pair{409u, 2}, std::pair{503u, 1}}) {
        pass(10s, 1s);
        receive(station, packet_of(command(Command::nav_land, 0)));
        output.waiting.back()(outcome(status, "{}"));
        pass(20ms);
        EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), result);
    }
}

TEST_F(Bridge, commands_for_all_or_for_others_are_not_carried_out) {
    const std::size_t station = open();
    greet(station);
    receive(station, packet_of(command(Command::arm_disarm, 1, 0)));
    receive(station, packet_of(command(Command::arm_disarm, 1, 77)));
    receive(station, packet_of(command(Command::arm_disarm, 1).set<"target_component">(100)));    // a camera
    EXPECT_TRUE(output.requests.empty());
}

TEST_F(Bridge, velocities_reach_the_device_and_their_end_stops_it) {
    const std::size_t station = open();
    greet(station);
    from_device(0xDC, 0x06, {2, 2, 0, 0, 0});
    Draft<"SET_POSITION_TARGET_LOCAL_NED"> draft;
    draft.set<"target_system">(1).set<"type_mask">(0x5C7).set<"coordinate_frame">(8).set<"vx">(1.5F);
    receive(station, packet_of(draft));
    ASSERT_EQ(output.frames.size(), 1u);
    const auto control = ano::as<"realtime_control">(ano::FrameView{output.frames[0]});
    EXPECT_EQ(control->get<"ctrl_spd_x">(), 150);
    EXPECT_EQ(control->get<"ctrl_thr">(), 45);
    pass(1s);
    ASSERT_EQ(output.frames.size(), 2u);
    EXPECT_EQ(ano::as<"realtime_control">(ano::FrameView{output.frames[1]})->get<"ctrl_spd_x">(), 0);
    receive(station, packet_of(Draft<"MANUAL_CONTROL">{}.set<"target">(1)));
    EXPECT_EQ(output.frames.size(), 2u);
    EXPECT_EQ(bridge.counters().sticks[static_cast<std::size_t>(StickFault::not_allowed)], 1u);
    // After a stop of the loop, what was read may be old.
    now += 1s;
    from_device(0xDC, 0x06, {2, 2, 0, 0, 0});
    receive(station, packet_of(draft));
    EXPECT_EQ(bridge.counters().sticks[static_cast<std::size_t>(StickFault::old)], 1u);
}

TEST_F(Bridge, a_slow_link_gets_the_newest_values) {
    const std::size_t station = open();
    greet(station);
    pass(1s);
    output.room = 0;
    for (std::uint8_t i = 0; i < 100; ++i) {
        from_device(0xDC, 0x03, {0, 0, 0, 0, static_cast<std::uint8_t>(i + 1), 0, 1});    // hundredths of a degree to the left
        pass(20ms);
    }
    output.packets.clear();
    output.room = 1'000'000;
    pass(20ms);
    EXPECT_LE(count(station, id_of<"ATTITUDE">), 2u);
    EXPECT_NEAR(last<"ATTITUDE">(station).get<"yaw">(), -1 * std::numbers::pi / 180, 1e-5);
}

TEST_F(Bridge, values_are_sent_when_they_arrive_and_once) {
    const std::size_t station = open();
    greet(station);
    for (int i = 0; i < 100; ++i) {
        now += 20ms + std::chrono::milliseconds{i % 3 - 1};
        from_device(0xDC, 0x03, {0, 0, 0, 0, static_cast<std::uint8_t>(i + 1), 0, 1});
        const std::size_t before = count(station, id_of<"ATTITUDE">);
        bridge.on_time(now);
        const std::size_t sent = count(station, id_of<"ATTITUDE">) - before;
        EXPECT_EQ(sent, i > 2 ? 1u : sent) << i;
    }
    const std::size_t before = count(station, id_of<"ATTITUDE">);
    pass(1s);
    EXPECT_EQ(count(station, id_of<"ATTITUDE">), before);
}

TEST_F(Bridge, texts_of_devices_reach_all_stations_as_utf8) {
    const std::size_t one = open(), two = open();
    greet(one);
    greet(two, {254, 190});
    from_device(0xDC, 0xA0, {1, 0xB5, 0xE7, 0xD1, 0xB9});    // 电压 in GBK, red
    pass(20ms);
    for (const std::size_t station : {one, two}) {
        EXPECT_EQ(last<"STATUSTEXT">(station).get<"text">(), "电压");
        EXPECT_EQ(last<"STATUSTEXT">(station).get<"severity">(), 3);
    }
}

TEST_F(Bridge, a_station_of_version_1_is_answered_in_version_1) {
    const std::size_t station = open();
    greet(station, {255, 190}, Version::v1);
    pass(1s);
    ASSERT_FALSE(output.packets[station].empty());
    for (const Bytes& packet : output.packets[station]) EXPECT_EQ(packet[0], magic_v1);
}

TEST_F(Bridge, answers_requests_of_messages_intervals_and_pings) {
    const std::size_t station = open();
    greet(station);
    receive(station, packet_of(command(Command::request_message, 148)));
    EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), 0);
    EXPECT_NE(last<"AUTOPILOT_VERSION">(station).get<"capabilities">() & 16u, 0u);
    receive(station, packet_of(command(Command::request_message, 76)));
    EXPECT_EQ(last<"COMMAND_ACK">(station).get<"result">(), 3);
    receive(station, packet_of(command(Command::set_message_interval, 30).set<"param2">(-1.0F)));
    receive(station, packet_of(command(Command::get_message_interval, 30)));
    EXPECT_EQ(last<"MESSAGE_INTERVAL">(station).get<"interval_us">(), -1);
    receive(station, packet_of(Draft<"PING">{}.set<"seq">(9)));
    EXPECT_EQ(last<"PING">(station).get<"target_system">(), 255);
    receive(station, packet_of(Draft<"TIMESYNC">{}.set<"ts1">(1234)));
    EXPECT_EQ(last<"TIMESYNC">(station).get<"ts1">(), 1234);
    EXPECT_TRUE(output.requests.empty());
}

TEST_F(Bridge, floods_are_bounded) {
    const std::size_t station = open();
    greet(station);
    output.room = 0;
    for (int i = 0; i < 20'000; ++i) {
        receive(station, packet_of(command(Command::request_message, 148)));
        receive(station,
                packet_of(Draft<"PING">{}, {static_cast<std::uint8_t>(3 + i % 250), static_cast<std::uint8_t>(i / 250)}));
    }
    output.room = 1'000'000;
    pass(20ms);
    EXPECT_LE(output.packets[station].size(), MavlinkBridge::max_waiting + 2 * telemetry_rows().size());
}

TEST(SignedBridge, accepts_only_packets_with_its_signature_and_signs_its_own) {
    const SigningKey key = key_of_passphrase("secret");
    const MavlinkSettings all = settings();
    FakeOutput output;
    ano::TimePoint now{1h};
    MavlinkBridge bridge{all, output, now, key};
    const std::size_t station = bridge.open({Transport::reliable, false, true, "test"}, now);
    const auto draft = Draft<"HEARTBEAT">{}.set<"type">(6);
    Bytes plain(max_packet), with_signature(max_packet);
    plain.resize(encode(plain, Version::v2, {255, 190}, 0, draft.row, draft.payload()));
    with_signature.resize(encode(with_signature, Version::v2, {255, 190}, 0, draft.row, draft.payload(), flag_signed) +
                          signature_size);
    sign(with_signature, key, 0, signing_time(output.unix_us()));
    bridge.on_bytes(station, plain, now);
    EXPECT_EQ(bridge.counters().unsigned_packets, 1u);
    bridge.on_time(now += 1s);
    EXPECT_TRUE(output.packets[station].empty());
    bridge.on_bytes(station, with_signature, now);
    bridge.on_time(now += 1s);
    SignatureCheck check{key};
    ASSERT_FALSE(output.packets[station].empty());
    for (const Bytes& packet : output.packets[station])
        EXPECT_TRUE(check.accepts(PacketView{packet}, signing_time(output.unix_us())));
}

}    // namespace
}    // namespace mavlink_bridge_tests
