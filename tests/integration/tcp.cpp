// TCP links over real sockets: bridges, connections that end, stay silent or are not read, cut wires, names.
#include <link/tcp/connector.hpp>
#include <support/link_host.hpp>
#include <support/log_lines.hpp>
#include <support/namespaces.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/tcp_peer.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tcp_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

std::size_t commands_in(const Bytes& stream) {
    const auto frames = split(stream).frames;
    return static_cast<std::size_t>(std::count_if(frames.begin(), frames.end(), [](const Bytes& one) { return one[3] == 0xC0; }));
}

struct Tcp : testing::Test {
    void start(std::vector<std::string> links) { daemon.emplace(settings_of_texts(std::move(links))); }
    std::uint16_t port(const std::string& link) { return daemon->port(link); }
    bool accepts(TcpListener& listener, TcpPeer& into) {
        return daemon->until([&] { return listener.accept(into); });
    }
    bool until_channels(const std::string& link, std::size_t count) {
        return daemon->until([&] { return daemon->link(link).at("channels").size() == count; });
    }
    const TempDir dir;
    std::optional<RunningGateway> daemon;
};

TEST_F(Tcp, vendor_bytes_pass_unchanged_both_ways) {
    TcpListener bridge;
    start({bridge.link("fc"), "tcp-listen:127.0.0.1:0,name=ground"});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    ASSERT_TRUE(daemon->until_up("fc") && daemon->until_up("ground"));
    TcpPeer ground{port("ground")};
    ground.send(vendor::who_are_you);
    EXPECT_TRUE(daemon->until([&] { return fc.heard() == vendor::who_are_you; }));
    fc.send(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon->until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
    ground.send(vendor::write_parameter);
    EXPECT_TRUE(daemon->until([&] { return fc.heard() == vendor::who_are_you + vendor::write_parameter; }));
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Tcp, nothing_is_lost_if_a_bridge_sends_single_bytes_with_pauses) {
    TcpListener bridge;
    start({bridge.link("fc"), "udp-listen:127.0.0.1:0,name=ground"});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    UdpPeer ground;
    ground.send(port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return !fc.heard().empty(); }));
    for (std::size_t i = 0; i < vendor::i_am_an_mcu.size(); ++i) {
        fc.send(std::span{vendor::i_am_an_mcu}.subspan(i, 1));
        ASSERT_TRUE(daemon->until([&] { return daemon->count("fc", "bytes_in") == i + 1; }));
        if (i == 5) daemon->run_for(250ms);
    }
    EXPECT_TRUE(daemon->until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
}

TEST_F(Tcp, nothing_is_sent_on_an_idle_connection) {
    TcpListener bridge;
    start({bridge.link("fc")});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    daemon->run_for(1500ms);
    EXPECT_TRUE(fc.heard().empty());
}

TEST_F(Tcp, hello_sends_a_complete_request_frame_immediately) {
    TcpListener bridge;
    start({bridge.link("fc") + ",hello=on"});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    ASSERT_TRUE(daemon->until([&] { return fc.heard().size() >= vendor::who_are_you.size(); }));
    EXPECT_TRUE(split(fc.heard()).rest.empty());
}

TEST_F(Tcp, a_lost_connection_is_reopened_without_old_waiting_or_partial_frames) {
    TcpListener bridge;
    start({bridge.link("fc"), "udp-listen:127.0.0.1:0,name=ground"});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    UdpPeer ground;
    ground.send(port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return fc.heard() == vendor::who_are_you; }));
    fc.send(std::span{vendor::i_am_an_mcu}.first(9));
    ASSERT_TRUE(daemon->until([&] { return daemon->count("fc", "bytes_in") == 9; }));
    fc.close();
    ASSERT_TRUE(daemon->until([&] { return !daemon->up("fc"); }));
    EXPECT_EQ(daemon->link("fc").at("error_id"), "closed_by_peer");
    ground.send(port("ground"), vendor::command);    // lost: the connection is closed
    ASSERT_TRUE(accepts(bridge, fc));
    ASSERT_TRUE(daemon->until_up("fc"));
    fc.send(std::span{vendor::i_am_an_mcu}.subspan(9));    // the other half is no frame
    fc.send(vendor::written);
    EXPECT_TRUE(daemon->until([&] { return ground.heard() == vendor::written; }));
    EXPECT_TRUE(fc.heard().empty());
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Tcp, a_peer_that_resets_each_connection_at_once_has_closed_it) {
    TcpListener listener;
    RunningGateway gateway{settings_of_texts({listener.link("fc")})};
    const linger reset{1, 0};
    for (int n = 0; n < 4; ++n) {
        TcpPeer peer;
        ASSERT_TRUE(gateway.until([&] { return listener.accept(peer); }));
        ::setsockopt(peer.fd(), SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        peer.close();
        ASSERT_TRUE(gateway.until([&] { return gateway.link("fc").at("error") != ""; }));
        EXPECT_EQ(gateway.link("fc").at("error"), listener.address() + " closed the connection");
        EXPECT_EQ(gateway.link("fc").at("error_id"), "closed_by_peer");
    }
}

TEST_F(Tcp, a_refused_connection_and_an_unknown_host_name_are_reported_and_retried) {
    std::optional<TcpListener> bridge{std::in_place};
    const std::string local = "127.0.0.1:" + std::to_string(bridge->port());
    const std::string link = bridge->link("fc");
    bridge.reset();
    start({link, "tcp:no-such-host.invalid:80,name=nobody"});
    ASSERT_TRUE(daemon->until([&] { return daemon->link("fc").at("error_id") == "refused"; }));
    EXPECT_EQ(daemon->link("fc").at("error"), "connection refused: nothing listens at " + local);
    ASSERT_TRUE(daemon->until([&] { return daemon->link("nobody").at("error_id") == "no_such_host"; })) << daemon->link("nobody");
    bridge.emplace(local);
    TcpPeer fc;
    EXPECT_TRUE(accepts(*bridge, fc));
    EXPECT_TRUE(daemon->until_up("fc"));
}

// The kernel connects a socket to itself if the port chosen for the connecting socket equals the destination port.
TEST(TcpConnector, does_not_connect_to_itself) {
    ANOGATE_NEEDS_NAMESPACES();
    const Namespace space;
    const Inside inside{space};
    std::ofstream{"/proc/sys/net/ipv4/ip_local_port_range"} << "40000 40001";
    BareLinkHost host;
    std::string ended;
    anogate::Connector connector{host.context(), *anogate::HostSpec::parse("127.0.0.1:40000"), 1min,
                                 [&](anogate::UniqueFd, const anogate::Endpoint&) { ended = "connected"; },
                                 [&](const anogate::LinkError& why) { ended = why.id; }};
    for (int i = 0; i < 30; ++i) {    // every second one is assigned that port
        ended.clear();
        connector.start();
        ASSERT_TRUE(host.until([&] { return !ended.empty(); }));
        ASSERT_EQ(ended, "refused");
    }
    connector.stop();
    EXPECT_NO_THROW(TcpListener{"127.0.0.1:40000"}) << "a server may begin at once";
}

TEST_F(Tcp, a_name_is_resolved_and_each_of_its_addresses_is_tried) {
    TcpListener bridge;    // "localhost" may be ::1 first, where nothing listens
    start({"tcp:localhost:" + std::to_string(bridge.port()) + ",name=fc"});
    TcpPeer fc;
    ASSERT_TRUE(accepts(bridge, fc));
    ASSERT_TRUE(daemon->until_up("fc"));
    EXPECT_EQ(daemon->link("fc").at("address"), "127.0.0.1:" + std::to_string(bridge.port()));
}

TEST_F(Tcp, a_new_connection_of_a_device_replaces_its_silent_one) {
    start({"tcp-listen:127.0.0.1:0,name=air", "udp-listen:127.0.0.1:0,name=ground"});
    UdpPeer ground;
    ground.send(port("ground"), vendor::who_are_you);
    ASSERT_TRUE(until_channels("ground", 1));
    const Bytes telemetry = frame(0x05, 0xFE, 0x03, Bytes(7)), command = frame(0xFE, 0x05, 0xC0, {1, 0, 0});
    TcpPeer before{port("air")};
    before.send(telemetry);
    ASSERT_TRUE(daemon->until([&] { return ground.heard() == telemetry; }));
    daemon->run_for(1100ms);    // it restarts: the old connection stays open without a peer
    TcpPeer after{port("air")};
    after.send(telemetry);
    EXPECT_TRUE(daemon->until([&] { return before.is_closed(); }));
    ground.send(port("ground"), command);
    EXPECT_TRUE(daemon->until([&] { return after.heard() == command; }));
}

// As printf ... | nc does.
TEST_F(Tcp, a_host_that_ends_its_output_after_a_request_still_receives_the_answer) {
    PtyDevice fc{dir / "fc"};
    start({"tcp-listen:127.0.0.1:0,name=ground,max_peers=1", "serial:" + fc.path() + ",name=fc"});
    ASSERT_TRUE(daemon->until_up("ground") && daemon->until_up("fc"));
    const Bytes telemetry = frame(0x05, 0xFF, 0x03, Bytes(7)), question = frame(0xFE, 0x05, 0xE0, {0, 0, 0}),
                answer = frame(0x05, 0xFE, 0xE3, Bytes(30, 'x'));
    fc.write(telemetry);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("fc", "frames_in") == 1; }));
    TcpPeer peer{port("ground")};
    peer.send(question);
    ::shutdown(peer.fd(), SHUT_WR);
    ASSERT_TRUE(daemon->until([&] { return fc.heard() == question; }));
    daemon->run_for(50ms);    // the device takes its time
    fc.write(answer);
    EXPECT_TRUE(daemon->until([&] { return peer.is_closed() || peer.heard().size() >= answer.size(); }));
    EXPECT_EQ(peer.heard(), answer);
    // It leaves its place to another one at once.
    TcpPeer next{port("ground")};
    next.send(question);
    EXPECT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 2; }));
    EXPECT_TRUE(daemon->until([&] { return peer.is_closed(); }));
    ::shutdown(next.fd(), SHUT_WR);
    EXPECT_TRUE(daemon->until([&] { return next.is_closed(); })) << "without an answer as well";
    EXPECT_TRUE(until_channels("ground", 0));
    EXPECT_TRUE(daemon->counters_add_up());
}

TEST_F(Tcp, a_device_that_ends_its_output_and_a_host_that_is_gone_are_closed_at_once) {
    start({"tcp-listen:127.0.0.1:0,name=air", "udp-listen:127.0.0.1:0,name=ground"});
    UdpPeer ground;
    ground.send(port("ground"), vendor::who_are_you);
    ASSERT_TRUE(until_channels("ground", 1));
    const Bytes telemetry = frame(0x05, 0xFF, 0x03, Bytes(7));
    TcpPeer host{port("air")}, device{port("air")};
    host.send(vendor::who_are_you);
    device.send(telemetry);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == 2 && !host.heard().empty(); }));
    ::shutdown(device.fd(), SHUT_WR);
    const auto asked_at = std::chrono::steady_clock::now();
    ASSERT_TRUE(daemon->until([&] {
        device.heard();
        return device.is_closed();
    }));
    EXPECT_TRUE(daemon->route("0x05").is_null());
    RecordProperty(
        "ms", std::to_string(
                  std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - asked_at).count()));
    host.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("air", "frames_in") == 3; }));
    host.close();
    std::uint8_t n = 0;
    EXPECT_TRUE(daemon->until([&] {
        ground.send(port("ground"), frame(0x42, 0xFF, 0x03, Bytes(7, n++)));
        return daemon->link("air").at("channels").empty();
    }));
    EXPECT_LT(daemon->count("air", "frames_out"), 60u) << "not for two seconds";
}

TEST_F(Tcp, two_programs_of_one_computer_with_the_same_host_address_both_stay_connected) {
    start({"tcp-listen:127.0.0.1:0,name=ground", "sim:fc,hz=10,name=fc"});
    TcpPeer one{port("ground")};
    one.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 1; }));
    daemon->run_for(1100ms);
    TcpPeer two{port("ground")};
    two.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 2; }));
    const std::size_t before = one.heard().size();
    EXPECT_TRUE(daemon->until([&] { return one.heard().size() > before && !two.heard().empty(); }));
}

TEST_F(Tcp, a_host_that_reconnects_gets_the_only_place_from_its_lost_connection) {
    ANOGATE_NEEDS_NAMESPACES();
    NetworkNamespace here;
    Namespace there;
    here.join(there, "w0", "10.0.0.1/24", "10.0.0.2/24");
    start({"tcp-listen:10.0.0.1:0,name=ground,max_peers=1,dead_after=1h", "sim:fc,hz=50,name=fc"});
    const auto connect = [&] {
        const Inside inside{there};
        return std::make_unique<TcpPeer>("10.0.0.1:" + std::to_string(port("ground")));
    };
    const auto before = connect();
    ASSERT_TRUE(daemon->until([&] { return before->send(vendor::who_are_you); }));
    ASSERT_TRUE(daemon->until([&] { return !before->heard().empty(); }));
    there.ip("rule add ipproto tcp sport " + std::to_string(anogate::local_endpoint(before->fd()).port) + " blackhole");
    const auto unacknowledged_ms = [&] {
        return daemon->link("ground").at("channels").at(0).value("unacknowledged_ms", std::int64_t{});
    };
    ASSERT_TRUE(daemon->until([&] { return unacknowledged_ms() > 1000; })) << daemon->link("ground");
    LogLines log;
    const auto after = connect();
    ASSERT_TRUE(daemon->until([&] { return after->send(vendor::who_are_you); }));
    EXPECT_TRUE(daemon->until([&] { return !after->heard().empty(); })) << daemon->link("ground");
    const auto lines = log.pop_all();
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
        return line.find("another peer needed the connection") != std::string::npos;
    })) << testing::PrintToString(lines);
}

TEST_F(Tcp, max_peers_limits_connections_and_refuses_and_reports_the_next_one) {
    start({"tcp-listen:127.0.0.1:0,name=ground,max_peers=2"});
    TcpPeer one{port("ground")}, two{port("ground")};
    one.send(vendor::who_are_you);
    two.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 2; }));
    daemon->run_for(1100ms);    // programs of this computer that sent in one exchange only would be replaced
    one.send(vendor::who_are_you);
    two.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 4; }));
    TcpPeer three{port("ground")};
    three.send(vendor::who_are_you);
    EXPECT_TRUE(daemon->until([&] { return daemon->link("ground").at("error_id") == "no_place"; }));
    EXPECT_FALSE(one.is_closed() || two.is_closed());
    two.close();
    ASSERT_TRUE(until_channels("ground", 1));
    EXPECT_TRUE(daemon->until([&] {
        three.send(vendor::who_are_you);
        return daemon->link("ground").at("channels").size() == 2;
    })) << "a sender that waits gets the next free place";
}

TEST_F(Tcp, clients_that_wait_for_their_first_frame_are_reported) {
    start({"tcp-listen:127.0.0.1:0,name=full,max_peers=64", "tcp-listen:127.0.0.1:0,name=air"});
    std::vector<TcpPeer> silent;
    for (int n = 0; n < 32; ++n) silent.emplace_back(port("full"));
    ASSERT_TRUE(until_channels("full", 32));
    TcpPeer waits{port("air")};
    EXPECT_TRUE(daemon->until([&] { return daemon->link("air").at("hint_id") == "clients_without_frame"; }))
        << daemon->link("air");
    EXPECT_EQ(daemon->link("air").at("hint"), "connected clients that have not sent a complete valid frame yet: 1");
    EXPECT_EQ(daemon->link("air").at("without_frame"), 1);
}

TEST_F(Tcp, senders_outside_allow_are_refused) {
    start({"tcp-listen:127.0.0.1:0,name=ground,allow=10.1.2.0/24"});
    TcpPeer stranger{port("ground")};
    EXPECT_TRUE(daemon->until([&] { return stranger.is_closed(); }));
    EXPECT_TRUE(daemon->link("ground").at("channels").empty());
}

TEST_F(Tcp, a_peer_that_reads_nothing_is_closed_and_does_not_delay_the_others) {
    start({"tcp-listen:127.0.0.1:0,name=ground,dead_after=2s", "sim:fc,hz=100,name=fc"});
    TcpPeer deaf{port("ground")}, listener{port("ground")};
    const int small = 4096;
    ::setsockopt(deaf.fd(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    deaf.send(vendor::who_are_you);
    listener.send(vendor::who_are_you);
    ASSERT_TRUE(until_channels("ground", 2));
    EXPECT_TRUE(daemon->link("ground").at("channels").at(0).contains("unacknowledged_ms"));
    const Bytes image = frame(0xDC, 0xFE, 0xF1, Bytes(200));
    std::size_t heard = 0;
    EXPECT_TRUE(daemon->until([&] {
        for (int n = 0; n < 20; ++n) listener.send(image);    // to every host: more than their buffers can store
        const std::size_t now = listener.heard().size();
        EXPECT_GE(now, heard);
        heard = now;
        return daemon->link("ground").at("channels").size() == 1;
    })) << daemon->link("ground");
    EXPECT_GT(heard, 0u);
    EXPECT_FALSE(listener.is_closed());
}

TEST_F(Tcp, junk_and_silent_connections_disturb_nobody) {
    start({"tcp-listen:127.0.0.1:0,name=ground,max_peers=8,max_per_address=8", "sim:fc,hz=50,name=fc"});
    TcpPeer operator_{port("ground")};
    operator_.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("ground", "frames_in") == 1; }));
    const Bytes junk(500, 0xAB);
    for (int n = 0; n < 200; ++n) {
        TcpPeer stranger{port("ground")};
        stranger.send(junk);
        daemon->run_for(1ms);
    }
    const std::size_t before = operator_.heard().size();
    EXPECT_TRUE(daemon->until([&] { return operator_.heard().size() > before; }));
    EXPECT_FALSE(operator_.is_closed());
    EXPECT_TRUE(daemon->until([&] { return daemon->link("ground").at("channels").size() == 1; }));
    EXPECT_TRUE(daemon->counters_add_up());
}

class TcpInGroup : public Tcp, public testing::WithParamInterface<bool> {
protected:
    TcpInGroup() {
        start({"serial:" + cable.path() + ",name=cable,group=fc", radio.link("radio") + ",group=fc",
               "udp-listen:127.0.0.1:0,name=ground"});
    }
    void receive_on(bool by_cable) {
        const Bytes telemetry = frame(0x05, 0xFE, 0x03,
                                      {++received_, 0, 0, 0, 0, 0, 0});    // equal frames are one frame in a group
        if (by_cable) cable.write(telemetry);
        else air.send(telemetry);
    }
    std::size_t commands_of(bool by_cable) { return commands_in(by_cable ? cable.heard() : air.heard()); }
    /// The device is received on one link before each command, since a group without frames for a second sends on all links.
    void expect_commands_on(bool by_cable) {
        const std::size_t before = commands_of(by_cable);
        for (std::size_t n = 1; n <= 20; ++n) {
            receive_on(by_cable);
            ground.send(port("ground"), frame(0xFE, 0x05, 0xC0, {1, 0, 0, next_++}));
            ASSERT_TRUE(daemon->until([&] { return commands_of(by_cable) - before >= n; }));
            ASSERT_EQ(commands_of(by_cable) - before, n);
        }
    }

    PtyDevice cable{dir / "fc"};
    TcpListener radio;
    TcpPeer air;
    UdpPeer ground;
    std::uint8_t next_ = 0, received_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Loses, TcpInGroup, testing::Bool(), [](const auto& loses) { return loses.param ? "cable" : "radio"; });

// The listener of the radio stays open, so the gateway connects to it again, but no program reads there.
TEST_P(TcpInGroup, fail_over_loses_and_duplicates_no_command) {
    const bool by_cable = GetParam();
    ASSERT_TRUE(accepts(radio, air));
    ASSERT_TRUE(daemon->until_up("cable") && daemon->until_up("radio"));
    ground.send(port("ground"), vendor::who_are_you);
    ASSERT_TRUE(until_channels("ground", 1));
    for (const bool link : {!by_cable, by_cable}) {
        const std::size_t before = ground.heard().size();
        receive_on(link);
        ASSERT_TRUE(daemon->until([&] { return ground.heard().size() > before; }));
    }
    ASSERT_NO_FATAL_FAILURE(expect_commands_on(by_cable));
    EXPECT_EQ(commands_of(!by_cable), 0u) << "one link of the group carries them";
    if (by_cable) cable.unplug();
    else air.close();
    ASSERT_TRUE(daemon->until([&] { return !daemon->up(by_cable ? "cable" : "radio"); }));
    ASSERT_NO_FATAL_FAILURE(expect_commands_on(!by_cable));
}

// A cut wire: the peer's end of the veth is set down, so that nothing is refused and nothing is reset.
TEST_F(Tcp, a_cut_wire_is_detected_by_a_connection_that_sends_and_by_one_that_only_receives) {
    ANOGATE_NEEDS_NAMESPACES();
    NetworkNamespace here;
    Namespace there;
    here.join(there, "w0", "10.0.0.1/24", "10.0.0.2/24");
    std::optional<TcpListener> one, two;
    {
        const Inside inside{there};
        one.emplace("10.0.0.2:7001");
        two.emplace("10.0.0.2:7002");
    }
    start({one->link("reader") + ",dead_after=3s", two->link("writer") + ",dead_after=3s", "sim:fc,hz=20,name=fc"});
    TcpPeer first, second;
    ASSERT_TRUE(accepts(*one, first) && accepts(*two, second));
    second.send(vendor::who_are_you);
    ASSERT_TRUE(daemon->until([&] { return !second.heard().empty(); }));
    there.ip("link set w0 down");
    const auto began = std::chrono::steady_clock::now();
    EXPECT_TRUE(daemon->until([&] { return !daemon->up("writer") && !daemon->up("reader"); })) << daemon->status().at("links");
    RecordProperty("seconds", std::to_string(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count()));
}

// A wire to a peer in another namespace that can be cut and restored: the peer loses its address. (If its end of the veth were
// set down, our kernel would keep packets until it finds the peer again.)
struct CutTcp : Tcp {
    void join() { here->join(*there, "w0", "10.0.0.1/24", "10.0.0.2/24"); }
    void listen() {
        const Inside inside{*there};
        bridge.emplace("10.0.0.2:7001");
    }
    void cut() { there->ip("address del 10.0.0.2/24 dev w0"); }
    void restore() { there->ip("address add 10.0.0.2/24 dev w0"); }
    std::int64_t unacknowledged_ms() { return daemon->link("fc").value("unacknowledged_ms", std::int64_t{}); }
    /// A ground station, and a bridge with a device in another namespace. `cable`: the port of a serial link in a group with it;
    /// empty: there is none.
    void connect(const std::string& cable = {}, const std::string& more = {}) {
        here.emplace();
        there.emplace();
        join();
        listen();
        ground.emplace();
        const std::string group = cable.empty() ? "" : ",group=fc";
        std::vector<std::string> links{bridge->link("fc") + group + more, "udp-listen:127.0.0.1:0,name=ground"};
        if (!cable.empty()) links.push_back("serial:" + cable + ",name=cable" + group);
        start(links);
        ASSERT_TRUE(accepts(*bridge, fc));
        ASSERT_TRUE(daemon->until_up("fc"));
    }
    /// In a group with a serial link to the same device; commands are sent to the bridge.
    void connect_beside(PtyDevice& cable) {
        ASSERT_NO_FATAL_FAILURE(connect(cable.path()));
        ASSERT_TRUE(daemon->until_up("cable"));
        ground->send(port("ground"), vendor::who_are_you);
        ASSERT_TRUE(until_channels("ground", 1));
        cable.write(frame(0x05, 0xFE, 0x03, {1, 0, 0, 0, 0, 0, 0}));
        ASSERT_TRUE(daemon->until([&] { return daemon->count("cable", "frames_in") == 1; }));
        fc.send(frame(0x05, 0xFE, 0x03, {2, 0, 0, 0, 0, 0, 0}));
        ASSERT_TRUE(daemon->until([&] { return daemon->count("fc", "frames_in") == 1; }));
    }
    /// The next command of the ground station; `sent` are those before.
    void send_command(std::vector<Bytes>& sent) {
        const auto n = static_cast<std::uint8_t>(sent.size());
        sent.push_back(frame(0xFE, 0x05, 0xC0, {1, 0, 0, n, static_cast<std::uint8_t>(sent.size() >> 8)}));
        ground->send(port("ground"), sent.back());
    }
    void send_stick() {
        ground->send(port("ground"), frame(0xFE, 0xDC, 0x40, Bytes(20)));
        daemon->run_for(20ms);    // one second of them fits into the kernel
    }

    std::optional<UdpPeer> ground;
    TcpPeer fc;
    std::optional<NetworkNamespace> here;
    std::optional<Namespace> there;
    std::optional<TcpListener> bridge;
};

// Frames in the kernel can neither expire nor be replaced by newer ones.
TEST_F(CutTcp, while_nothing_is_acknowledged_frames_wait_in_the_queue_where_they_expire) {
    ANOGATE_NEEDS_NAMESPACES();
    connect({}, ",dead_after=1h,age.rest=1h");
    fc.send(vendor::i_am_an_mcu);
    send_stick();
    ASSERT_TRUE(daemon->until([&] { return !fc.heard().empty(); }));
    cut();
    const auto until_expired = [&](std::uint64_t count) {
        return daemon->until([&] {
            send_stick();
            return daemon->count("fc", "stale") + daemon->count("fc", "superseded") >= count;
        });
    };
    ASSERT_TRUE(until_expired(1));
    const auto written = daemon->count("fc", "frames_out");
    EXPECT_TRUE(until_expired(20));
    EXPECT_EQ(daemon->count("fc", "frames_out"), written);
    restore();
    EXPECT_TRUE(daemon->until([&] {
        send_stick();
        return daemon->count("fc", "frames_out") > written + 3;
    })) << daemon->link("fc");
    EXPECT_TRUE(daemon->counters_add_up());
}

// These would arrive late, all at once, when the wire works again.
TEST_F(CutTcp, few_frames_are_in_the_kernel_when_the_wire_is_cut) {
    ANOGATE_NEEDS_NAMESPACES();
    connect();
    fc.send(vendor::i_am_an_mcu);
    for (int n = 0; n < 50; ++n) send_stick();
    ASSERT_TRUE(daemon->until([&] { return unacknowledged_ms() == 0 && !fc.heard().empty(); }));
    const auto before = daemon->count("fc", "frames_out");
    cut();
    ASSERT_TRUE(daemon->until([&] {
        send_stick();
        return unacknowledged_ms() > 1000;
    }));
    const auto late = daemon->count("fc", "frames_out") - before;
    EXPECT_GT(late, 0u);
    EXPECT_LE(late, 9u) << "those of 120 ms";
    RecordProperty("frames", std::to_string(late));
}

// Nothing can take over, and a connection of its own would last as long.
TEST_F(CutTcp, the_only_connected_link_of_a_group_is_not_closed_by_a_short_interruption) {
    ANOGATE_NEEDS_NAMESPACES();
    connect("/dev/absent");
    fc.send(vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon->until([&] { return daemon->count("fc", "frames_in") == 1; }));
    cut();
    ASSERT_TRUE(daemon->until([&] {
        send_stick();
        return unacknowledged_ms() > 1600 || !daemon->up("fc");
    }));
    EXPECT_TRUE(daemon->up("fc")) << daemon->link("fc");
    restore();
    EXPECT_TRUE(daemon->until([&] { return !fc.heard().empty(); }));
    EXPECT_TRUE(daemon->up("fc"));
}

// The commands in the kernel would otherwise arrive after newer ones that the other link has delivered.
TEST_F(CutTcp, a_group_closes_a_connection_that_acknowledges_nothing_and_its_frames_are_not_delivered_later) {
    ANOGATE_NEEDS_NAMESPACES();
    PtyDevice cable{dir / "fc"};
    ASSERT_NO_FATAL_FAILURE(connect_beside(cable));
    cut();
    std::vector<Bytes> sent;
    const auto command = [&] { send_command(sent); };
    std::size_t late = 0;    // the first command after this one is not sent to the cut connection alone
    ASSERT_TRUE(daemon->until([&] {
        command();
        daemon->run_for(10ms);
        if (late == 0 && commands_in(cable.heard()) > 0) late = sent.size();
        return !daemon->up("fc") && late > 0 && sent.size() > late + 3;
    })) << daemon->link("fc");
    EXPECT_EQ(daemon->link("fc").at("error_id"), "peer_silent");
    EXPECT_TRUE(daemon->until([&] {
        const auto heard = split(cable.heard()).frames;
        return std::all_of(sent.begin() + static_cast<std::ptrdiff_t>(late), sent.end(),
                           [&](const Bytes& one) { return std::count(heard.begin(), heard.end(), one) == 1; });
    })) << "all further commands are on the cable";
    const std::size_t heard = fc.heard().size();
    restore();
    TcpPeer again;
    ASSERT_TRUE(accepts(*bridge, again));
    ASSERT_TRUE(daemon->until([&] {
        fc.send(Bytes(1));
        return fc.is_closed();
    }));
    EXPECT_EQ(fc.heard().size(), heard);
    EXPECT_TRUE(again.heard().empty());
}

// The commands in the kernel would be delivered as soon as the wire works again.
TEST_F(CutTcp, a_short_interruption_delivers_no_command_after_a_newer_one_of_another_link_of_the_group) {
    ANOGATE_NEEDS_NAMESPACES();
    PtyDevice cable{dir / "fc"};
    ASSERT_NO_FATAL_FAILURE(connect_beside(cable));
    std::vector<Bytes> sent;
    send_command(sent);
    ASSERT_TRUE(daemon->until([&] { return commands_in(fc.heard()) == 1 && unacknowledged_ms() == 0; }));
    cut();
    ASSERT_TRUE(daemon->until([&] {
        send_command(sent);
        daemon->run_for(10ms);
        return commands_in(cable.heard()) >= 3 || !daemon->up("fc");
    }));
    restore();
    TcpPeer again;
    EXPECT_TRUE(daemon->until([&] { return bridge->accept(again) || commands_in(fc.heard()) > 1; }));
    EXPECT_EQ(commands_in(fc.heard()), 1u) << "commands older than those of the cable";
    EXPECT_TRUE(daemon->counters_add_up());
}

}    // namespace
}    // namespace tcp_tests
