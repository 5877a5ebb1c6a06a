// TCP links with programs and hardware of other makers: socat, ser2net, stunnel, and Wi-Fi bridges such as ESP8266 boards.
#include <http/client/certificate.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/tcp_peer.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace tcp_bridges_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::http::CertificateFiles;

std::uint16_t free_port() { return TcpListener{}.port(); }
bool is_installed(const std::string& program) { return std::system(("command -v " + program + " >/dev/null").c_str()) == 0; }

// Whether `frame` arrived, possibly after bytes that a terminal echoed before a program opened it.
bool has(const Bytes& heard, const Bytes& frame) {
    return std::search(heard.begin(), heard.end(), frame.begin(), frame.end()) != heard.end();
}

// A device at a pseudo-terminal, which a program connects to a TCP port.
struct TcpBridges : testing::Test {
    void exchange(RunningGateway& daemon, const std::string& link) {
        ASSERT_TRUE(daemon.until_up(link));
        ASSERT_TRUE(daemon.until([&] {
            device.write(vendor::i_am_an_mcu);    // the first may be lost while the program opens the port
            return daemon.count(link, "frames_in") > 0;
        }));
        const std::uint64_t before = daemon.count(link, "frames_in");
        for (std::uint8_t i = 0; i < 100; ++i) {
            device.write(frame(0xDB, 0xFE, 0x03, {i, 2, 3, 4, 5, 6, 0}));
            daemon.run_for(1ms);
        }
        EXPECT_TRUE(daemon.until([&] { return daemon.count(link, "frames_in") >= before + 100; }));
        EXPECT_EQ(daemon.count(link, "bad_check"), 0u);
        UdpPeer host;
        host.send(daemon.port("ground"), vendor::write_parameter);
        EXPECT_TRUE(daemon.until([&] { return has(device.heard(), vendor::write_parameter); }));
    }
    std::string connects() const { return "tcp:127.0.0.1:" + std::to_string(port) + ",name=bridge"; }

    const std::string ground = "udp-listen:127.0.0.1:0,name=ground";
    TempDir dir;
    PtyDevice device{dir / "port"};
    std::uint16_t port = free_port();
};

TEST_F(TcpBridges, work_with_a_socat_that_listens) {
    RunningGateway daemon{settings_of_texts({connects(), ground})};
    const Shell socat{"exec socat TCP-LISTEN:" + std::to_string(port) + ",bind=127.0.0.1,reuseaddr,fork FILE:" + device.path() +
                      ",raw,echo=0,b500000"};
    exchange(daemon, "bridge");
}

TEST_F(TcpBridges, work_with_a_socat_that_connects) {
    RunningGateway daemon{settings_of_texts({"tcp-listen:127.0.0.1:0,name=bridge", ground})};
    const Shell socat{"exec socat TCP:127.0.0.1:" + std::to_string(daemon.port("bridge")) + " FILE:" + device.path() +
                      ",raw,echo=0,b500000"};
    exchange(daemon, "bridge");
}

TEST_F(TcpBridges, work_with_ser2net) {
    if (!is_installed("ser2net")) GTEST_SKIP() << "ser2net is not installed";
    std::ofstream{dir / "ser2net.yaml"} << "connection: &fc\n  accepter: tcp,127.0.0.1," << port << "\n  connector: serialdev,"
                                        << device.path() << ",500000n81,local\n  options:\n    kickolduser: true\n";
    RunningGateway daemon{settings_of_texts({connects(), ground})};
    const Shell ser2net{"exec ser2net -d -c " + dir / "ser2net.yaml" + " -P " + dir / "pid"};
    exchange(daemon, "bridge");
}

// stunnel before a plain TCP link, at either end of an encrypted one.
struct Stunnel : testing::Test {
    Stunnel() {
        EXPECT_TRUE(make_authority("ours", of("ca")));
        EXPECT_TRUE(make_signed_certificate({{"localhost"}, {"127.0.0.1"}}, of("gateway"), of("ca")));
        EXPECT_TRUE(make_signed_certificate({{"localhost"}, {"127.0.0.1"}}, of("stunnel"), of("ca")));
    }
    CertificateFiles of(const std::string& name) const { return {dir / (name + ".pem"), dir / (name + "-key.pem")}; }
    /// The configuration of one stunnel in the foreground, and the command that runs it.
    std::string command(bool is_client, std::uint16_t accept, std::uint16_t connect) const {
        std::ofstream{dir / "stunnel.conf"} << "foreground = yes\npid =\n[ano]\nclient = " << (is_client ? "yes" : "no")
                                            << "\naccept = 127.0.0.1:" << accept << "\nconnect = 127.0.0.1:" << connect
                                            << "\ncert = " << dir / "stunnel.pem"
                                            << "\nkey = " << dir / "stunnel-key.pem"
                                            << "\nCAfile = " << dir / "ca.pem"
                                            << "\nverifyChain = yes\n";
        return "exec stunnel " + dir / "stunnel.conf";
    }
    std::string ours() const {
        return ",certificate=" + dir / "gateway.pem" + ",key=" + dir / "gateway-key.pem" + ",ca=" + dir / "ca.pem";
    }
    void exchange(RunningGateway& daemon, TcpPeer& far) const {
        UdpPeer host;
        host.send(daemon.port("ground"), vendor::who_are_you);
        EXPECT_TRUE(daemon.until([&] { return has(far.heard(), vendor::who_are_you); }));
        far.send(vendor::i_am_an_mcu);
        EXPECT_TRUE(daemon.until([&] { return has(host.heard(), vendor::i_am_an_mcu); }));
    }
    const std::string ground = "udp-listen:127.0.0.1:0,name=ground";
    TempDir dir;
    std::uint16_t port = free_port();
};

TEST_F(Stunnel, connects_to_our_port) {
    if (!is_installed("stunnel")) GTEST_SKIP() << "stunnel4 is not installed";
    RunningGateway daemon{settings_of_texts({"tls-listen:127.0.0.1:0,name=t" + ours(), ground})};
    ASSERT_TRUE(daemon.until_up("t"));
    const Shell stunnel{command(true, port, daemon.port("t"))};
    TcpPeer far;
    ASSERT_TRUE(daemon.until([&] {
        if (!far || far.is_closed()) far = TcpPeer{port};
        far.send(vendor::i_am_an_mcu);
        return daemon.count("t", "frames_in") > 0;
    }));
    exchange(daemon, far);
}

TEST_F(Stunnel, accepts_our_connection) {
    if (!is_installed("stunnel")) GTEST_SKIP() << "stunnel4 is not installed";
    TcpListener behind;
    const Shell stunnel{command(false, port, behind.port())};
    RunningGateway daemon{settings_of_texts({"tls:localhost:" + std::to_string(port) + ",name=t" + ours(), ground})};
    TcpPeer far;
    ASSERT_TRUE(daemon.until([&] { return behind.accept(far); }) && daemon.until_up("t")) << daemon.link("t");
    exchange(daemon, far);
}

/// An ESP8266 with a transparent bridge: it listens, sends every byte of its serial port to each of at most six connections, in
/// segments of one byte with pauses, and has small buffers.
class WifiBridge {
public:
    explicit WifiBridge(std::uint32_t seed) : chance_{seed} {
        const int small = 512;
        ::setsockopt(listener_.fd(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    }
    std::string link(const std::string& name) const { return listener_.link(name); }
    std::string address() const { return listener_.address(); }
    /// The device behind it sends.
    void write(const Bytes& bytes) { out_ = std::move(out_) + bytes; }
    /// The bytes that the device has received from all connections.
    Bytes heard() {
        Bytes all = heard_before_;
        for (TcpPeer& one : connections_) all = std::move(all) + one.heard();
        return all;
    }
    std::size_t connections() const { return connections_.size(); }
    /// One turn of the bridge's loop.
    void turn() {
        for (TcpPeer fresh; listener_.accept(fresh);)
            if (connections_.size() < 6) connections_.push_back(std::move(fresh));
        for (std::size_t i = connections_.size(); i-- > 0;)
            if (connections_[i].is_closed()) close(i);
        if (ano::Clock::now() < silent_until_ || out_.empty()) return;
        for (TcpPeer& one : connections_) one.send(std::span{out_}.first(1));
        out_.erase(out_.begin());
        if (chance_() % 400 == 0) silent_until_ = ano::Clock::now() + 250ms;
    }
    void close_one() {
        if (!connections_.empty()) close(chance_() % connections_.size());
    }

private:
    void close(std::size_t at) {
        heard_before_ = std::move(heard_before_) + connections_[at].heard();
        connections_.erase(connections_.begin() + static_cast<std::ptrdiff_t>(at));
    }

    TcpListener listener_;
    std::vector<TcpPeer> connections_;
    Bytes out_, heard_before_;
    std::minstd_rand chance_;
    ano::TimePoint silent_until_{};
};

TEST(WifiBridges, lose_only_frames_in_transit_when_they_close_a_connection) {
    WifiBridge bridge{7};
    RunningGateway daemon{settings_of_texts({bridge.link("bridge"), "udp-listen:127.0.0.1:0,name=ground"})};
    std::vector<TcpPeer> others(5);    // five more programs connected to the same bridge
    UdpPeer host;
    const auto turn = [&] {
        bridge.turn();
        return false;
    };
    ASSERT_TRUE(daemon.until([&] { return turn() || bridge.connections() == 1; }));
    for (TcpPeer& one : others) one = TcpPeer{bridge.address()};
    ASSERT_TRUE(daemon.until([&] { return turn() || bridge.connections() == 6; }));
    std::uint64_t sent = 0;
    for (std::uint8_t round = 0; round < 4; ++round) {
        const std::uint64_t before = daemon.count("bridge", "frames_in");
        for (std::uint8_t i = 0; i < 30; ++i, ++sent) bridge.write(frame(0x05, 0xFE, 0x03, {i, 2, 3, 4, 5, 6, 0}));
        ASSERT_TRUE(daemon.until([&] { return turn() || daemon.count("bridge", "frames_in") >= before + 30; })) << int{round};
        host.send(daemon.port("ground"), frame(0xFE, 0x05, 0xE1, {round, 0, 1}));
        ASSERT_TRUE(daemon.until([&] {
            turn();
            const auto frames = split(bridge.heard()).frames;
            return std::count_if(frames.begin(), frames.end(), [](const Bytes& one) { return one[3] == 0xE1; }) == round + 1;
        })) << int{round};
        const std::size_t connected = bridge.connections();
        bridge.close_one();
        ASSERT_TRUE(daemon.until([&] {
            turn();
            for (TcpPeer& one : others)
                if (one.heard(), one.is_closed()) one = TcpPeer{bridge.address()};
            return bridge.connections() == connected && daemon.up("bridge");
        })) << int{round};
    }
    EXPECT_EQ(daemon.count("bridge", "frames_in"), sent);
    EXPECT_EQ(daemon.count("bridge", "bad_check"), 0u);
    EXPECT_TRUE(split(bridge.heard()).rest.empty()) << "nothing but frames";
    EXPECT_TRUE(daemon.counters_add_up());
}

}    // namespace
}    // namespace tcp_bridges_tests
