// sim:fc as seen by a ground station.
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <functional>
#include <map>

namespace simulator_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

std::map<std::uint8_t, int> count_by_id(const Bytes& stream) {
    std::map<std::uint8_t, int> counts;
    for (const Bytes& f : split(stream).frames) ++counts[f[3]];
    return counts;
}

TEST(Simulator, sends_its_device_information_when_requested_by_address_or_by_broadcast) {
    RunningGateway daemon{sim("fc", 1), udp_listen("ground")};
    UdpPeer host;
    for (const std::uint8_t to : {std::uint8_t{0xDC}, std::uint8_t{0xFF}}) {
        host.forget();
        host.send(daemon.port("ground"), frame(0xFE, to, 0xE0, {0, 0, 0}));
        EXPECT_TRUE(daemon.until([&] { return count_by_id(host.heard())[0xE3] == 1; })) << int{to};
        for (const Bytes& f : split(host.heard()).frames) {
            if (f[3] != 0xE3) continue;
            EXPECT_EQ(f[1], 0xDC);
            EXPECT_EQ(f[2], 0xFE);
            EXPECT_EQ(f[6], 0xDC) << "dev_id";
        }
    }
    host.forget();
    host.send(daemon.port("ground"), frame(0xFE, 0xDB, 0xE0, {0, 0, 0}));
    host.send(daemon.port("ground"), frame(0xFE, 0xDC, 0xE0));
    daemon.run_for(50ms);
    EXPECT_EQ(count_by_id(host.heard())[0xE3], 0) << "not its address; no cmd";
}

class SimulatorRate : public testing::TestWithParam<std::uint16_t> {};
TEST_P(SimulatorRate, is_never_above_the_configured_rate) {
    const auto rate = GetParam();
    RunningGateway daemon{sim("fc", rate), udp_listen("ground")};
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return count_by_id(host.heard())[0x03] > 0; }));
    host.forget();
    // Whole periods of its clock, measured by the frames of the slowest stream.
    const auto begin = anogate::Clock::now();
    ASSERT_TRUE(daemon.until([&] { return count_by_id(host.heard())[0x03] >= std::max<int>(rate, 2); }));
    const double seconds = std::chrono::duration<double>(anogate::Clock::now() - begin).count();
    EXPECT_GT(seconds, 0.8 * std::max<int>(rate, 2) / rate - 1.0 / rate) << "not faster";
    auto counts = count_by_id(host.heard());
    for (const std::uint8_t id : {std::uint8_t{0x01}, std::uint8_t{0x03}})
        EXPECT_LE(counts[id], 1 + 1.3 * rate * seconds) << "id " << int{id};
    EXPECT_NEAR(counts[0x01], counts[0x03], 1) << "a slow machine makes both late";
    for (const int id : {0x05, 0x06, 0x07, 0x0D}) EXPECT_GT(counts[static_cast<std::uint8_t>(id)], 0) << id;
    for (const Bytes& f : split(host.heard()).frames) EXPECT_EQ(f[2], 0xFE);
}
INSTANTIATE_TEST_SUITE_P(Simulator, SimulatorRate, testing::Values(1, 20, 100));

std::int16_t i16(const Bytes& f, std::size_t at) { return static_cast<std::int16_t>(f[6 + at] | f[7 + at] << 8); }

// The frames that a host receives, and those of one id among them.
struct Listener {
    explicit Listener(RunningGateway& gateway) : daemon{gateway} { host.send(daemon.port("ground"), vendor::who_are_you); }
    bool receives(std::uint8_t id, const std::function<bool(const Bytes&)>& fits) {
        host.forget();
        return daemon.until([&] {
            for (const Bytes& f : split(host.heard()).frames)
                if (f[3] == id && fits(f)) return found = f, true;
            return false;
        });
    }
    Bytes one(std::uint8_t id) {
        EXPECT_TRUE(receives(id, [](const Bytes&) { return true; })) << int{id};
        return found;
    }
    void send(std::uint8_t to, std::uint8_t id, const Bytes& data) {
        host.send(daemon.port("ground"), frame(0xFE, to, id, data));
    }

    RunningGateway& daemon;
    UdpPeer host;
    Bytes found;
};

TEST(Simulator, its_values_are_those_of_a_vehicle_at_rest) {
    RunningGateway daemon{sim("fc", 100), udp_listen("ground")};
    Listener host{daemon};
    EXPECT_NEAR(i16(host.one(0x01), 4), 981, 70) << "gravity, with a sensor that nobody calibrated";
    EXPECT_EQ(host.one(0x01).size(), 8u + 13);
    EXPECT_LT(std::abs(i16(host.one(0x03), 0)), 100) << "roll in hundredths of a degree";
    EXPECT_EQ(host.one(0x03).size(), 8u + 7);
    EXPECT_EQ(host.one(0x05).size(), 8u + 13);
    EXPECT_EQ(host.one(0x06).size(), 8u + 5);
    EXPECT_EQ(host.one(0x07).size(), 8u + 6);
    EXPECT_NEAR(i16(host.one(0x0D), 0), 1200, 120) << "volts in hundredths";
    EXPECT_EQ(host.one(0x0D).size(), 8u + 4);
}

TEST(Simulator, takes_off_on_command) {
    RunningGateway daemon{sim("fc", 100), udp_listen("ground")};
    Listener host{daemon};
    EXPECT_EQ(host.one(0x06)[7], 0) << "locked";
    host.send(0xDC, 0xC0, {0x10, 0, 1, 50, 0});
    EXPECT_TRUE(host.receives(0x00, [](const Bytes& f) { return f[6] == 0xC0; })) << "acknowledged";
    EXPECT_TRUE(host.receives(0x06, [](const Bytes& f) { return f[7] == 2; })) << "airborne";
    EXPECT_TRUE(host.receives(0x05, [](const Bytes& f) { return i16(f, 8) > 40; })) << "cm";
}

TEST(Simulator, uses_the_configured_address) {
    RunningGateway daemon{settings_of_texts({"sim:fc,dev_id=33", "udp-listen:127.0.0.1:0,name=ground"})};
    Listener host{daemon};
    EXPECT_EQ(host.one(0x03)[1], 33);
}

TEST(Simulator, all_kinds_answer_at_their_addresses) {
    RunningGateway daemon{
        settings_of_texts({"sim:fc", "sim:imu", "sim:flow", "sim:radio", "sim:car", "udp-listen:127.0.0.1:0,name=ground"})};
    Listener host{daemon};
    for (const int address : {0xDC, 0xDD, 0xDE, 0xE6, 40}) {
        host.send(static_cast<std::uint8_t>(address), 0xE0, {0, 0, 0});
        EXPECT_TRUE(host.receives(0xE3, [&](const Bytes& f) { return f[1] == address; })) << address;
    }
}

TEST(Simulator, counts_the_configured_faults) {
    RunningGateway daemon{settings_of_texts({"sim:fc,hz=100,loss=50,corrupt=30,duplicate=50,jitter=5ms,seed=5",
                                             "sim:imu,deaf_after=1ms", "udp-listen:127.0.0.1:0,name=ground"})};
    Listener host{daemon};
    EXPECT_TRUE(daemon.until([&] {
        return daemon.link("fc").value("faults_lost", 0) > 20 && daemon.link("fc").value("faults_duplicated", 0) > 20 &&
               daemon.link("fc").value("faults_corrupted", 0) > 10;
    }));
    EXPECT_GT(daemon.count("fc", "bad_check"), 0u) << "the parser saw the damage";
    host.send(0xDD, 0xE0, {0, 0, 0});
    EXPECT_TRUE(daemon.until([&] { return daemon.link("imu").value("faults_unheard", 0) > 0; })) << "it is deaf";
    EXPECT_FALSE(daemon.link("ground").contains("faults_lost"));
}

}    // namespace
}    // namespace simulator_tests
