// CAN links on a kernel that has SocketCAN, with can-utils as the other side. Runs in a network namespace of its own, where CAN
// is: on such a host, and in the machine of tests/vm/machine.
#include "can_rate.hpp"

#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <thread>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using Frames = std::vector<Bytes>;
using support::frame;
using support::Loop;
using support::run;
using support::RunningGateway;
using support::Shell;
using support::UdpPeer;

namespace {

bool have_vcan() {
    static const bool have = [] {
        if (::unshare(CLONE_NEWNET) != 0) return false;
        return run("ip link set lo up") == 0 && run("ip link add dev vcan0 type vcan 2>/dev/null") == 0 &&
               run("ip link del vcan0") == 0;
    }();
    return have;
}

std::string hex(std::span<const std::uint8_t> bytes) {
    std::string text;
    char digits[3];
    for (const std::uint8_t byte : bytes) text += (std::snprintf(digits, sizeof digits, "%02X", byte), digits);
    return text;
}

/// "6DC#AB…" as can-utils write it.
std::string words(const CanCutter::Piece& piece, const CanSettings& can) {
    Bytes data(piece.bytes.begin(), piece.bytes.end());
    data.resize(piece.size);
    char id[16];
    std::snprintf(id, sizeof id, can.extended ? "%08X" : "%03X", piece.id);
    return id + std::string{can.fd ? "##1" : "#"} + hex(data);
}

std::vector<std::string> cut(const Bytes& frame, const CanSettings& can) {
    CanCutter cutter{can};
    const std::span<const std::uint8_t> waiting = frame;
    std::vector<std::string> all;
    for (const auto& piece : cutter.cut({&waiting, 1})) all.push_back(words(piece, can));
    return all;
}

double cpu_seconds(int whose) {
    rusage usage{};
    ::getrusage(whose, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

Bytes data_of(std::size_t size, std::uint8_t first = 1) {
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(first + i);
    return data;
}

// A raw socket on the bus, faster than any program.
class BusSocket {
public:
    explicit BusSocket(const char* interface) : fd_{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)} {
        const int on = 1;
        ::setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
        sockaddr_can address{};
        address.can_family = AF_CAN;
        address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
        EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    ~BusSocket() { ::close(fd_); }
    void send(const Bytes& frame, const CanSettings& can = {}, std::size_t leave_out = SIZE_MAX) {
        const std::span<const std::uint8_t> waiting = frame;
        const auto pieces = cutter(can).cut({&waiting, 1});
        for (std::size_t i = 0; i < pieces.size(); ++i)
            if (i != leave_out) put(pieces[i], can);
    }
    void put(const CanCutter::Piece& piece, const CanSettings& can) {
        canfd_frame out{};
        out.can_id = piece.id | (can.extended ? CAN_EFF_FLAG : 0);
        out.len = piece.size;
        std::copy(piece.bytes.begin(), piece.bytes.end(), out.data);
        if (::write(fd_, &out, can.fd ? CANFD_MTU : CAN_MTU) < 0) FAIL() << "write: " << errno;
    }

private:
    static CanCutter& cutter(const CanSettings& can) {
        static CanCutter cutter{can};
        return cutter = CanCutter{can};
    }
    int fd_;
};

struct Can : testing::Test {
    static void SetUpTestSuite() { have_vcan(); }    // enters the namespace, before a socket is made
    void SetUp() override {
        if (!have_vcan()) {
            if (std::getenv("ANOGATE_IN_VM")) FAIL() << "no vcan in the test machine";
            GTEST_SKIP() << "this kernel has no vcan, or we may not make one; tests/vm/run runs it in a machine that has";
        }
        make_bus();
    }
    void TearDown() override {
        if (have_vcan()) run("ip link del vcan0 2>/dev/null");
    }
    static void make_bus() { ASSERT_EQ(run("ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 up"), 0); }

    /// candump, listening when this returns.
    std::unique_ptr<Shell> dump(const std::string& options = "-L vcan0") {
        const auto listeners = [] {
            std::ifstream list{"/proc/self/net/can/rcvlist_all"};
            std::size_t lines = 0;
            for (std::string line; std::getline(list, line);) ++lines;
            return lines;
        };
        const std::size_t before = listeners();
        auto process = std::make_unique<Shell>("candump " + options);
        EXPECT_TRUE(loop.until([&] { return listeners() > before; }));
        return process;
    }
    /// What candump -L wrote of the next `count` frames, without its times.
    std::vector<std::string> dumped(Shell& dump, std::size_t count) {
        std::string text;
        loop.until([&] {
            text += dump.new_output();
            return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) >= count;
        });
        std::vector<std::string> all;
        std::istringstream lines{text};
        for (std::string time, interface, what; lines >> time >> interface >> what;) all.push_back(what);
        return all;
    }
    std::vector<Bytes> received(UdpPeer& from, std::size_t count, std::chrono::seconds patience = 30s) {
        std::vector<Bytes> all;
        loop.until(
            [&] {
                for (Bytes& one : from.frames()) all.push_back(std::move(one));
                return all.size() >= count;
            },
            patience);
        return all;
    }

    Loop loop;
    UdpPeer app;
};

}    // namespace

TEST_F(Can, an_11_bit_frame_on_the_wire_is_base_and_source_in_pieces_of_8) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0xA0, data_of(3)));
    EXPECT_EQ(dumped(*bus, 2), (std::vector<std::string>{"6FE#ABFEFFA003000102", "6FE#0351C5"}));
    app.send(gateway.port("app"), frame(0x01, 0xFF, 0x03));    // now: it would overtake the other, which is less urgent
    EXPECT_EQ(dumped(*bus, 1), std::vector<std::string>{"601#AB01FF030000AE0C"});
    EXPECT_EQ(gateway.count("vcan0", "frames_out"), 2u) << gateway.status();
    EXPECT_EQ(gateway.count("vcan0", "frames_in"), 0u);    // own frames do not come back
}

TEST_F(Can, what_comes_while_the_gateway_stands_still_is_as_old_as_it_is) {
    for (const std::string can : {"can:vcan0", "can:vcan0,framing=isotp,tx=0x101,rx=0x102"}) {
        RunningGateway gateway{loop, {can, app.link("app") + ",age.control=2s"}};
        EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }));
        const auto say = [&](std::uint8_t n) {
            const Bytes sticks = frame(0xFE, 0xDC, 0x41, Bytes(14, n));
            if (can == "can:vcan0") return BusSocket{"vcan0"}.send(sticks);
            std::string spaced;
            for (const std::uint8_t byte : sticks) spaced += hex({&byte, 1}) + " ";
            EXPECT_EQ(run("echo " + spaced + "| isotpsend -s 102 -d 101 vcan0"), 0);
        };
        say(1);
        std::this_thread::sleep_for(2500ms);    // the loop does not run
        say(2);
        EXPECT_EQ(received(app, 1), Frames{frame(0xFE, 0xDC, 0x41, Bytes(14, 2))}) << can;
        EXPECT_EQ(gateway.count("app", "stale"), 1u) << can;
    }
}

TEST_F(Can, base_moves_the_ids) {
    RunningGateway gateway{loop, {"can:vcan0,base=0x100", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(dumped(*bus, 1).at(0).substr(0, 4), "1FE#");
}

TEST_F(Can, a_29_bit_id_tells_class_source_and_destination) {
    RunningGateway gateway{loop, {"can:vcan0,extended", app.link("app")}};
    auto bus = dump();
    for (const std::uint8_t id : Bytes{0xC0, 0x03, 0xB0}) app.send(gateway.port("app"), frame(0xFE, 0xDC, id));
    const auto lines = dumped(*bus, 3);
    ASSERT_EQ(lines.size(), 3u);
    std::vector<std::string> ids;
    for (const auto& line : lines) ids.push_back(line.substr(0, 9));
    std::sort(ids.begin(), ids.end());
    EXPECT_EQ(ids, (std::vector<std::string>{"0AB0FEDC#", "0AB1FEDC#", "0AB2FEDC#"}));
}

TEST_F(Can, fd_pieces_are_up_to_64_bytes_padded_with_zeros_and_have_the_bit_rate_switch_unless_told) {
    for (const bool brs : {true, false}) {
        RunningGateway gateway{loop, {brs ? "can:vcan0,fd" : "can:vcan0,fd,brs=false", app.link("app")}};
        auto bus = dump();
        const Bytes large = frame(0xFE, 0xFF, 0x03, data_of(65)), small = frame(0xFE, 0xFF, 0x03);
        app.send(gateway.port("app"), large);
        app.send(gateway.port("app"), small);
        const auto lines = dumped(*bus, 3);
        ASSERT_EQ(lines.size(), 3u);
        const std::string flags = brs ? "##[15]" : "##[04]";    // newer kernels add FDF, 4
        EXPECT_TRUE(lines[0].substr(0, 3) == "6FE" && lines[0].substr(6) == hex(std::span{large}.first(64))) << lines[0];
        EXPECT_EQ(lines[1].substr(6), hex(std::span{large}.subspan(64)) + "000000");
        EXPECT_EQ(lines[2].substr(6), hex(small));
        for (const auto& line : lines) EXPECT_NE(flags.find(line.at(5)), std::string::npos) << line;
    }
}

TEST_F(Can, what_cansend_sends_arrives_classic_extended_and_fd) {
    const std::pair<const char*, const char*> kinds[] = {{"", ""}, {"extended", ""}, {"", "fd"}, {"extended", "fd"}};
    for (const auto& [extended, fd] : kinds) {
        CanSettings can;
        can.extended = *extended;
        can.fd = *fd;
        RunningGateway gateway{loop,
                               {std::string{"can:vcan0"} + (can.extended ? ",extended" : "") + (can.fd ? ",fd" : ""),
                                app.link("app") + ",age.telemetry=60s"}};
        const Bytes sent = frame(0xDC, 0xFE, 0x03, data_of(20));
        std::string command = "true";
        for (const std::string& piece : cut(sent, can)) command += " && cansend vcan0 '" + piece + "'";
        ASSERT_EQ(run(command), 0);    // the loop stands still meanwhile
        EXPECT_EQ(received(app, 1), Frames{sent});
        EXPECT_EQ(gateway.count("vcan0", "skipped_bytes"), 0u);
        EXPECT_EQ(gateway.count("vcan0", "bytes_in"), sent.size());
    }
}

TEST_F(Can, twenty_senders_interleaved_by_canplayer) {
    std::vector<std::vector<std::string>> senders;
    for (std::uint8_t s = 1; s <= 20; ++s) {
        senders.emplace_back();
        for (std::uint8_t n = 0; n < 10; ++n)
            for (auto& piece : cut(frame(s, 0xFE, 0x03, data_of(8u + s, n)), {})) senders.back().push_back(piece);
    }
    const std::string log = testing::TempDir() + "twenty.log";
    std::ofstream file{log};
    for (std::size_t i = 0; i < 50; ++i)
        for (const auto& sender : senders)
            if (i < sender.size()) file << "(0.000000) vcan0 " << sender[i] << '\n';
    file.close();
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    Shell player{"canplayer -t -I " + log};
    const auto frames = received(app, 200);
    EXPECT_EQ(frames.size(), 200u);
    std::map<std::uint8_t, std::uint8_t> next;
    for (const Bytes& f : frames) EXPECT_EQ(f, frame(f[1], 0xFE, 0x03, data_of(8u + f[1], next[f[1]]++)));
    EXPECT_EQ(gateway.count("vcan0", "skipped_bytes"), 0u);
    std::remove(log.c_str());
}

TEST_F(Can, a_lost_can_frame_costs_one_v8_frame) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (std::size_t i = 0; i < 40; ++i) bus.send(frame(0xDC, 0xFE, 0x03, data_of(17)), {}, i == 20 ? 1 : SIZE_MAX);
    EXPECT_EQ(received(app, 39).size(), 39u);
    EXPECT_EQ(gateway.count("vcan0", "frames_in"), 39u);
}

TEST_F(Can, a_frame_whose_rest_never_comes_holds_nobody_back_for_long) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    ASSERT_EQ(run("cansend vcan0 6DC#ABDCFE03C8000102"), 0);    // 200 bytes announced
    BusSocket bus{"vcan0"};
    bus.send(frame(0xDC, 0xFE, 0x03, data_of(17)));
    EXPECT_EQ(received(app, 1, 10s), Frames{frame(0xDC, 0xFE, 0x03, data_of(17))});
    EXPECT_EQ(gateway.count("vcan0", "expired"), 1u) << gateway.status();
}

TEST_F(Can, a_frame_of_another_source_than_its_id_is_refused_and_counted) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    ASSERT_EQ(run("cansend vcan0 6DD#" + hex(frame(0xDC, 0xFE, 0x03))), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "denied_in") == 1; }));
    EXPECT_EQ(gateway.count("vcan0", "wrong_source"), 1u);
    EXPECT_TRUE(app.frames().empty());
}

TEST_F(Can, other_traffic_on_the_bus_is_kept_out_by_the_kernel) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (const char* other : {"5FF#AB01", "700#AB01", "000006DC#AB01", "6DC#R8"})
        ASSERT_EQ(run(std::string{"cansend vcan0 "} + other), 0);
    bus.send(frame(0xDC, 0xFE, 0x03));
    EXPECT_EQ(received(app, 1).size(), 1u);
    EXPECT_EQ(gateway.count("vcan0", "bytes_in"), 8u);
}

TEST_F(Can, noise_at_full_rate_harms_nothing) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    Shell full{"cangen vcan0 -g 0 -i -I 6DD -L 8 -D r -n 20000"};
    Shell any_length{
        "cangen vcan0 -g 0 -i -I 601 -D r -n 20000"};    // no id at random: noise amid a frame of ours costs that frame
    const double before = cpu_seconds(RUSAGE_SELF), theirs = cpu_seconds(RUSAGE_CHILDREN);
    std::size_t sent = 0, got = 0;
    loop.until(
        [&] {
            if (sent - got < 20) bus.send(frame(0xDC, 0xFE, 0x03, data_of(17))), ++sent;
            got += app.frames().size();
            return !full.is_running() && !any_length.is_running();
        },
        120s);
    EXPECT_TRUE(loop.until([&] { return (got += app.frames().size()) >= sent; }));
    EXPECT_EQ(got, sent);
    EXPECT_GT(sent, 20u);
    const double ours = cpu_seconds(RUSAGE_SELF) - before, noise = cpu_seconds(RUSAGE_CHILDREN) - theirs;
    RecordProperty("cpu_to_noise", std::to_string(ours / noise));
    EXPECT_LT(ours, 2 * noise) << "the test's own frames included: " << ours << " s beside " << noise
                               << " s of those who make it";
    EXPECT_TRUE(gateway.up("vcan0"));
    EXPECT_GT(gateway.count("vcan0", "skipped_bytes"), 100'000u);
    EXPECT_EQ(gateway.count("vcan0", "kernel_drops"), 0u);
}

TEST_F(Can, what_the_kernel_drops_is_in_the_status) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (int i = 0; i < 20000; ++i) bus.send(frame(0xDC, 0xFE, 0x03));    // the gateway's loop stands still
    EXPECT_GT(gateway.count("vcan0", "kernel_drops"), 0u);
    received(app, 20000 - gateway.count("vcan0", "kernel_drops"), 60s);
    EXPECT_EQ(gateway.count("vcan0", "kernel_drops") + gateway.count("vcan0", "frames_in"), 20000u);
}

TEST_F(Can, error_frames_are_in_the_status_with_their_times) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    EXPECT_EQ(gateway.link("vcan0")["bus"], "error-active");
    const auto bus_becomes = [&](const char* error, const char* state) {
        EXPECT_EQ(run(std::string{"cansend vcan0 "} + error), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.link("vcan0")["bus"] == state; })) << state;
    };
    bus_becomes("20000004#0008000000000000", "error-warning");
    EXPECT_NE(gateway.link("vcan0")["error"], "");
    bus_becomes("20000004#0020000000000000", "error-passive");
    bus_becomes("20000040#0000000000000000", "bus-off");
    bus_becomes("20000100#0000000000000000", "error-active");
    const auto link = gateway.link("vcan0");
    for (const char* event : {"error_warning", "error_passive", "bus_off", "restarted"}) {
        EXPECT_EQ(link[event], 1) << event;
        EXPECT_LE(link[std::string{event} + "_s"], 60) << event;
    }
    EXPECT_EQ(link["state"], "up");
    EXPECT_EQ(link["error"], "");
}

TEST_F(Can, an_interface_may_be_down_absent_and_back_and_nothing_else_is_disturbed) {
    UdpPeer other;
    RunningGateway gateway{loop, {"can:vcan0,fd", app.link("app"), other.link("other")}};
    const auto passes = [&] {
        BusSocket bus{"vcan0"};
        CanSettings can;
        can.fd = true;
        bus.send(frame(0xDC, 0xFE, 0x03), can);
        return received(app, 1).size() == 1;
    };
    const auto waits_for = [&](const char* change, const char* why) {
        EXPECT_EQ(run(change), 0);
        EXPECT_TRUE(loop.until([&] {
            return !gateway.up("vcan0") && gateway.link("vcan0")["error"].get<std::string>().find(why) == 0;
        })) << why;
        other.send(gateway.port("other"), frame(0x05, 0xFE, 0x03));
        EXPECT_EQ(received(app, 1).size(), 1u);
        const auto refused = gateway.count("vcan0", "link_down");
        app.send(gateway.port("app"), frame(0xFE, 0xDC, 0x03));    // for the link that is down: counted there
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "link_down") == refused + 1; }));
    };
    const auto comes_back = [&](const char* change) {
        EXPECT_EQ(run(change), 0);
        EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }, 10s));
        EXPECT_TRUE(passes());
    };
    ASSERT_TRUE(passes());
    waits_for("ip link set vcan0 down", "vcan0 is down");
    comes_back("ip link set vcan0 up");
    waits_for("ip link del vcan0", "there is no interface vcan0");
    waits_for("ip link add dev vcan0 type vcan && ip link set vcan0 mtu 16 up", "vcan0 carries no CAN FD");
    waits_for("ip link set vcan0 down", "vcan0 is down");
    comes_back("ip link set vcan0 mtu 72 up");
    EXPECT_EQ(gateway.count("vcan0", "link_down"), 5u);    // and the first to 0xFE, who had not spoken yet
}

TEST_F(Can, an_interface_that_is_no_can_is_refused_in_words) {
    RunningGateway gateway{loop, {"can:lo", app.link("app")}};
    EXPECT_EQ(gateway.link("lo")["error"], "lo is not a CAN interface");
}

TEST_F(Can, absent_interfaces_cost_few_wake_ups) {
    Shell daemon{std::string{"exec "} + ANOGATED +
                 " --control none --log-level error can:nocan0 can:nocan1,fd can:nocan2,framing=isotp,tx=1,rx=2"};
    const auto wake_ups = [&] {
        std::ifstream status{"/proc/" + std::to_string(daemon.pid()) + "/status"};
        for (std::string word; status >> word;)
            if (word == "voluntary_ctxt_switches:") return status >> word, std::stoi(word);
        return -1;
    };
    std::this_thread::sleep_for(5s);    // the first, shorter pauses
    const int before = wake_ups();
    std::this_thread::sleep_for(5s);
    EXPECT_GE(before, 0);
    EXPECT_LE(wake_ups() - before, 15);
}

TEST_F(Can, a_full_queue_never_cuts_a_frame) {
    ASSERT_EQ(run("ip link set vcan0 txqueuelen 4"), 0);
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 400kbit burst 200 limit 400"), 0);    // a slow bus
    UdpPeer far;
    RunningGateway gateway{loop, {"can:vcan0,name=near", app.link("app")}};
    RunningGateway there{loop, {"can:vcan0,name=far", far.link("app")}};
    Shell beside{"cangen vcan0 -g 1 -i -I 123 -L 8"};    // fills the queue too: ENOBUFS
    for (std::uint8_t n = 0; n < 200; ++n) {
        for (int k = 0; k < 5; ++k) app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(60, n)));
        loop.turn();
    }
    EXPECT_TRUE(loop.until([&] { return gateway.count("near", "waiting") == 0; }, 60s));
    beside.end();
    const std::uint64_t out = gateway.count("near", "frames_out");
    EXPECT_GT(out, 20u);
    EXPECT_TRUE(loop.until([&] { return there.count("far", "frames_in") == out; }));
    EXPECT_EQ(there.count("far", "frames_in"), out);
    EXPECT_EQ(there.count("far", "skipped_bytes"), 0u);
}

TEST_F(Can, a_frame_that_the_bus_leaves_in_its_middle_is_given_up_whole) {
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 100kbit burst 200 limit 400"), 0);
    UdpPeer far;
    RunningGateway near{loop, {"can:vcan0,max_data=5000", app.link("app") + ",max_data=5000"}};
    RunningGateway there{loop, {"can:vcan0,max_data=5000", far.link("app")}};
    app.send(near.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(5000)));
    ASSERT_TRUE(loop.until([&] { return there.count("vcan0", "bytes_in") > 100; }));
    ASSERT_EQ(run("ip link set vcan0 down"), 0);
    EXPECT_TRUE(loop.until([&] { return !near.up("vcan0") && !there.up("vcan0"); }));
    EXPECT_EQ(near.count("vcan0", "link_down"), 1u) << near.link("vcan0");
    EXPECT_EQ(near.count("vcan0", "frames_out"), 0u);
    ASSERT_EQ(run("ip link set vcan0 up"), 0);
    EXPECT_TRUE(loop.until([&] { return near.up("vcan0") && there.up("vcan0"); }));
    const Bytes next = frame(0x11, 0xFF, 0x03, data_of(17));
    app.send(near.port("app"), next);
    EXPECT_EQ(received(far, 1), Frames{next});
    EXPECT_EQ(there.count("vcan0", "wrong_source"), 0u);
    EXPECT_EQ(there.count("vcan0", "frames_in"), 1u);
}

// A slow bus that another program keeps full; images wait, and commands among them.
TEST_F(Can, urgent_frames_leave_first_beside_a_saturated_bus) {
    ASSERT_EQ(run("ip link set vcan0 txqueuelen 4"), 0);
    ASSERT_EQ(run("tc qdisc add dev vcan0 root tbf rate 400kbit burst 200 limit 400"), 0);
    UdpPeer far;
    RunningGateway near{loop, {"can:vcan0,queue=65536", app.link("app")}};
    RunningGateway there{loop, {"can:vcan0", far.link("app")}};
    Shell beside{"cangen vcan0 -g 1 -i -I 123 -L 8"};
    for (std::uint8_t n = 0; n < 200; ++n) app.send(near.port("app"), frame(0xDF, 0xFF, 0xB0, data_of(200, n)));
    EXPECT_TRUE(loop.until([&] { return near.count("vcan0", "waiting") > 100; }));
    app.send(near.port("app"), frame(0xFE, 0xFF, 0xC0, data_of(11)));
    std::size_t images = 0;
    bool commanded = false;
    loop.until(
        [&] {
            for (const Bytes& f : far.frames()) {
                if (f[3] == 0xC0) commanded = true;
                else if (!commanded) ++images;
            }
            return commanded;
        },
        60s);
    EXPECT_TRUE(commanded);
    EXPECT_GT(near.count("vcan0", "waiting"), 100u) << images << " images came before it";
}

TEST_F(Can, two_gateways_joined_by_one_bus) {
    for (const std::string options : {"", ",fd", ",extended", ",fd,extended"}) {
        UdpPeer far;
        RunningGateway a{loop, {"can:vcan0" + options, app.link("app")}};
        RunningGateway b{loop, {"can:vcan0" + options, far.link("app")}};
        const Bytes there = frame(0xFE, 0xDC, 0xC0, data_of(11)), back = frame(0xDC, 0xFE, 0xB0, data_of(200));
        app.send(a.port("app"), there);
        EXPECT_EQ(received(far, 1), Frames{there});
        far.send(b.port("app"), back);
        EXPECT_EQ(received(app, 1), Frames{back});
        app.send(a.port("app"), frame(0xFE, 0xFF, 0x03));    // to everybody: once, and it does not go round
        EXPECT_EQ(received(far, 1).size(), 1u);
        EXPECT_EQ(a.count("vcan0", "frames_in"), 1u);
        EXPECT_EQ(b.count("vcan0", "frames_in"), 2u);
    }
}

TEST_F(Can, pty_to_can_to_udp_and_back) {
    const std::string path = testing::TempDir() + "can-test-pty";
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0", "pty:" + path + ",name=pty"}};
    RunningGateway b{loop, {"can:vcan0", far.link("app")}};
    const int pty = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(pty, 0);
    const Bytes there = frame(0xDC, 0xFF, 0xA0, data_of(100)), back = frame(0xFE, 0xDC, 0xE1, data_of(6));
    EXPECT_EQ(::write(pty, there.data(), there.size()), static_cast<ssize_t>(there.size()));
    EXPECT_EQ(received(far, 1), Frames{there});
    far.send(b.port("app"), back);
    Bytes got(200);
    std::size_t size = 0;
    EXPECT_TRUE(loop.until([&] {
        const ssize_t n = ::read(pty, got.data() + size, got.size() - size);
        if (n > 0) size += static_cast<std::size_t>(n);
        return size >= back.size();
    }));
    got.resize(size);
    EXPECT_EQ(got, back);
    ::close(pty);
}

// The table of src/link/README.md stands on these counts.
TEST_F(Can, the_bus_sees_as_many_frames_and_bytes_as_computed) {
    for (const bool fd : {false, true}) {
        for (const bool isotp : {false, true}) {
            const std::string options = std::string{fd ? ",fd" : ""} + (isotp ? ",framing=isotp" : "");
            UdpPeer far;
            RunningGateway a{loop, {"can:vcan0" + options + (isotp ? ",tx=1,rx=2" : ""), app.link("app")}};
            RunningGateway b{loop, {"can:vcan0" + options + (isotp ? ",tx=2,rx=1" : ""), far.link("app")}};
            for (const std::size_t size : {0u, 4u, 13u, 50u, 54u, 55u, 200u}) {
                const auto counted = [] {
                    std::array<std::uint64_t, 2> counts{};    // frames and bytes of vcan0
                    std::ifstream list{"/proc/self/net/dev"};
                    for (std::string word; list >> word;)
                        if (word == "vcan0:") list >> counts[1] >> counts[0];
                    return counts;
                };
                const auto before = counted();
                app.send(a.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(size)));
                EXPECT_EQ(received(far, 1).size(), 1u);
                const auto after = counted();
                const auto sizes = isotp ? can_rate::isotp(size + 8, fd) : can_rate::stream(size + 8, fd);
                EXPECT_EQ(after[0] - before[0], sizes.size()) << size << options;
                EXPECT_EQ(after[1] - before[1], std::accumulate(sizes.begin(), sizes.end(), std::size_t{0})) << size << options;
            }
        }
    }
}

// Senders that keep a window of frames on the way: UDP to A, CAN to B, UDP to the far app. Each one's frames stay in order;
// between senders of one class the outbox takes turns.
TEST_F(Can, a_hundred_thousand_frames_without_a_lost_or_altered_one) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,fd", app.link("app")}};
    RunningGateway b{loop, {"can:vcan0,fd", far.link("app")}};
    const std::uint16_t to = a.port("app");
    constexpr std::uint32_t all = 100'000, window = 200, senders = 20;
    std::uint32_t sent = 0, got = 0;
    const auto made = [](std::uint32_t n) {
        Bytes data(4 + n % 90);
        for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(n >> (8 * (i % 4)));
        return frame(static_cast<std::uint8_t>(1 + n % senders), 0xFF, 0xB0, data);
    };
    std::array<std::uint32_t, senders> next{};    // of each sender, the frame that is to come
    std::iota(next.begin(), next.end(), 0u);
    const auto arrived = [&](const Bytes& f) {
        const std::uint32_t sender = f.at(1) - 1u;
        ASSERT_LT(sender, senders);
        EXPECT_EQ(f, made(next[sender]));
        next[sender] += senders;
        ++got;
    };
    const bool done = loop.until(
        [&] {
            for (; sent < all && sent - got < window; ++sent) app.send(to, made(sent));
            for (const Bytes& f : far.frames()) arrived(f);
            return got >= all || testing::Test::HasFailure();
        },
        400s);
    EXPECT_TRUE(done) << "sent " << sent << ", got " << got;
    EXPECT_EQ(b.count("vcan0", "frames_in"), all);
    EXPECT_EQ(b.count("vcan0", "skipped_bytes"), 0u);
    EXPECT_EQ(b.count("vcan0", "kernel_drops"), 0u);
}

// ISO-TP

TEST_F(Can, isotp_one_frame_one_pdu_from_and_to_the_tools) {
    for (const std::string fd : {"", ",fd"}) {
        const std::string tools = fd.empty() ? "" : " -L 72:64:0";
        RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=0x7E0,rx=0x7E8" + fd, app.link("app")}};
        ASSERT_TRUE(gateway.up("vcan0")) << gateway.link("vcan0")["error"];
        for (const std::size_t size : {0u, 54u, 300u}) {
            const Bytes sent = frame(0xDC, 0xFE, 0x03, data_of(size));
            std::string text;
            for (const std::uint8_t byte : sent) text += hex({&byte, 1}) + " ";
            Shell sender{"echo " + text + " | isotpsend -s 7E8 -d 7E0" + tools + " vcan0"};
            EXPECT_EQ(received(app, 1), Frames{sent}) << size << fd;

            EXPECT_TRUE(loop.until([&] { return !sender.is_running(); }));
            const auto bound = [] {
                std::ifstream list{"/proc/self/net/can/rcvlist_sff"};
                std::size_t ours = 0;
                for (std::string word; list >> word;) ours += word == "7e0";
                return ours;
            };
            const std::size_t before = bound();
            Shell receiver{"isotprecv -s 7E8 -d 7E0" + tools + " vcan0"};
            EXPECT_TRUE(loop.until([&] { return bound() > before; }));
            const Bytes back = frame(0xFE, 0xDC, 0xB0, data_of(size));
            app.send(gateway.port("app"), back);
            std::string got;
            EXPECT_TRUE(loop.until([&] {
                got += receiver.new_output();
                return got.find('\n') != std::string::npos;
            })) << size
                << fd;
            std::string digits;
            for (const char c : got)
                if (c != ' ' && c != '\n') digits += c;
            EXPECT_EQ(digits, hex(back));
        }
    }
}

TEST_F(Can, isotp_extended_ids_are_29_bit) {
    RunningGateway gateway{loop, {"can:vcan0,framing=isotp,extended,tx=0x18DA10F1,rx=0x18DAF110", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(dumped(*bus, 1).at(0).substr(0, 13), "18DA10F1#1008");
}

TEST_F(Can, isotp_between_two_gateways_in_order_and_complete) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app")}};
    RunningGateway b{loop, {"can:vcan0,framing=isotp,tx=2,rx=1", far.link("app")}};
    std::vector<Bytes> sent;
    for (std::uint8_t n = 0; n < 100; ++n) {
        sent.push_back(frame(0xFE, 0xFF, 0xB0, data_of(n * 2u, n)));
        app.send(a.port("app"), sent.back());
    }
    EXPECT_EQ(received(far, sent.size()), sent);
    EXPECT_EQ(a.count("vcan0", "frames_out"), 100u);
}

TEST_F(Can, isotp_refuses_what_is_above_4095_bytes) {
    UdpPeer far;
    RunningGateway a{loop, {"can:vcan0,framing=isotp,tx=1,rx=2,max_data=5000", app.link("app") + ",max_data=5000"}};
    RunningGateway b{loop, {"can:vcan0,framing=isotp,tx=2,rx=1,max_data=5000", far.link("app") + ",max_data=5000"}};
    const Bytes largest = frame(0xFE, 0xFF, 0xB0, data_of(4087));
    app.send(a.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(4088)));
    app.send(a.port("app"), largest);
    EXPECT_EQ(received(far, 1), Frames{largest});
    EXPECT_EQ(a.count("vcan0", "too_big"), 1u);
    EXPECT_EQ(a.count("vcan0", "frames_out"), 1u);
}

TEST_F(Can, isotp_to_nobody_is_said_and_blocks_nothing) {
    const auto start = std::chrono::steady_clock::now();
    {
        UdpPeer other;
        RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app"), other.link("other")}};
        app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(50)));
        EXPECT_EQ(received(other, 1).size(), 1u);
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "transfer_errors") == 1; }));
        EXPECT_EQ(gateway.link("vcan0")["error"].get<std::string>().find("the peer does not answer"), 0u);
        EXPECT_TRUE(gateway.up("vcan0"));
        app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03, data_of(50)));
        EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "frames_out") == 2; }));
        const auto before = std::chrono::steady_clock::now();
        EXPECT_EQ(run("ip link set vcan0 down"), 0);    // in the middle of a transfer
        EXPECT_TRUE(loop.until([&] { return !gateway.up("vcan0"); }));
        loop.turn();
        RecordProperty("ms_to_notice", static_cast<int>((std::chrono::steady_clock::now() - before) / 1ms));
    }
    RecordProperty("ms", static_cast<int>((std::chrono::steady_clock::now() - start) / 1ms));
}

TEST_F(Can, isotp_stays_up_while_many_frames_wait_for_nobody) {
    RunningGateway gateway{loop, {"can:vcan0,framing=isotp,tx=1,rx=2", app.link("app")}};
    for (std::uint8_t n = 0; n < 3; ++n) app.send(gateway.port("app"), frame(0xFE, 0xFF, 0xE1, data_of(50, n)));
    bool went_down = false;
    EXPECT_TRUE(loop.until([&] {
        went_down = went_down || !gateway.up("vcan0");
        return gateway.count("vcan0", "transfer_errors") == 3;
    })) << gateway.link("vcan0");
    EXPECT_FALSE(went_down);
    EXPECT_EQ(gateway.count("vcan0", "frames_out"), 3u) << gateway.link("vcan0");
    EXPECT_EQ(gateway.link("vcan0")["error"].get<std::string>().find("the peer does not answer"), 0u);
}

TEST_F(Can, a_kernel_without_isotp_is_named_and_waited_for) {
    if (!std::getenv("ANOGATE_IN_VM")) GTEST_SKIP() << "unloads a kernel module: only in tests/vm/machine";
    ASSERT_EQ(run("echo 'install can-isotp /bin/false' >/etc/modprobe.d/no-isotp.conf"), 0);
    ASSERT_TRUE(loop.until([] { return run("rmmod can-isotp 2>/dev/null") == 0; })) << "sockets of earlier tests close late";
    UdpPeer other;
    RunningGateway gateway{loop,
                           {"can:vcan0,framing=isotp,tx=1,rx=2", "can:vcan0,name=stream", app.link("app"), other.link("other")}};
    EXPECT_EQ(gateway.link("vcan0")["state"], "waiting");
    EXPECT_EQ(gateway.link("vcan0")["error"], "this kernel has no ISO-TP (module can-isotp)");
    EXPECT_TRUE(gateway.up("stream"));
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(received(other, 1).size(), 1u) << "the rest runs";
    ASSERT_EQ(run("rm /etc/modprobe.d/no-isotp.conf && modprobe can-isotp"), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }));
}
