// The real program as a process: its start, its run, signals, and its end.
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>

namespace daemon_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

constexpr int config_fault = 78;
constexpr auto at_once = 5s;    // a second, plus a margin for a busy machine; a wait for the stuck one never ends
const Bytes telemetry = frame(0xDC, 0xFE, 0x03, {1, 2, 3, 4, 5, 6, 0});

struct Ended {
    int status;
    std::chrono::steady_clock::duration took;
};
Ended terminate(Process& daemon, int signal = SIGTERM) {
    const auto begin = std::chrono::steady_clock::now();
    daemon.signal(signal);
    const int status = daemon.wait();
    return {status, std::chrono::steady_clock::now() - begin};
}

TEST(Daemon, joins_a_serial_port_and_udp) {
    const TempDir dir;
    PtyDevice mcu{dir / "ttyUSB0"};
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + mcu.path() + ",baud=250000", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ttyUSB0") && daemon.until_up("ground")) << daemon.output();
    UdpPeer ground;
    ground.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(wait_until([&] { return mcu.heard() == vendor::who_are_you; }));
    mcu.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(wait_until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
    const Ended end = terminate(daemon);
    EXPECT_EQ(end.status, 0) << daemon.output();
    EXPECT_LT(end.took, at_once);
}

TEST(Daemon, forwards_the_answer_of_the_simulator_to_a_request_over_udp) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"sim:fc", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground"));
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(wait_until([&] {
        for (const Bytes& f : split(host.heard()).frames)
            if (f[1] == 0xDC && f[2] == 0xFE && f[3] == 0xE3) return true;
        return false;
    }));
}

TEST(Daemon, waits_for_absent_devices_and_ports_in_use) {
    const TempDir dir;
    UdpPeer holder;
    Daemon daemon{
        ANOGATED, dir / "control", {"serial:" + (dir / "ttyUSB0"), "udp-listen:" + holder.local().text() + ",name=ground"}};
    ASSERT_TRUE(daemon.until_answers());
    EXPECT_EQ(daemon.link("ttyUSB0").at("state"), "waiting");
    EXPECT_EQ(daemon.link("ground").at("state"), "waiting");
    PtyDevice fc{dir / "ttyUSB0"};
    EXPECT_TRUE(daemon.until_up("ttyUSB0"));
    EXPECT_EQ(terminate(daemon).status, 0);
    EXPECT_NE(daemon.output().find("not found; waiting for it"), std::string::npos) << daemon.output();
}

TEST(Daemon, logs_the_effect_of_an_absent_safety_switch) {
    const TempDir dir;
    std::ofstream{dir / "a.json"} << R"({"gpio": [{"chip": "no-such-chip", "line": 4, "use": "inhibit", "links": ["fc"]}]})";
    Daemon daemon{ANOGATED, dir / "control", {"--config", dir / "a.json", "sim:fc"}};
    EXPECT_TRUE(daemon.until_says("the chip was not found; waiting for it")) << daemon.output();
    EXPECT_TRUE(daemon.until_says("gpio inhibit of fc: on, control frames are dropped")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
}

TEST(Daemon, ends_quickly_under_load_and_with_a_stuck_reader) {
    const TempDir dir;
    PtyDevice stuck{dir / "stuck"};
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + stuck.path(), "udp-listen:127.0.0.1:0,name=ground", "sim:fc,hz=100"}};
    ASSERT_TRUE(daemon.until_up("stuck"));
    UdpPeer load;
    const auto port = daemon.port("ground");
    const auto push = [&] {
        for (int i = 0; i < 50; ++i) load.send(port, frame(0xDD, 0xFF, 0xF1, Bytes(200, 1)));
        load.datagrams();
    };
    ASSERT_TRUE(daemon.until([&](const auto&) {
        push();
        return daemon.count("stuck", "waiting") > 0;
    }));
    const auto begin = std::chrono::steady_clock::now();
    daemon.signal(SIGTERM);
    EXPECT_TRUE(wait_until([&] {
        push();
        return !daemon.is_running();
    }));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, at_once);
    EXPECT_EQ(daemon.wait(), 0);
}

TEST(Daemon, ends_immediately_after_a_second_signal) {
    const TempDir dir;
    PtyDevice stuck{dir / "stuck"};
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + stuck.path(), "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("stuck"));
    UdpPeer load;
    const auto port = daemon.port("ground");
    ASSERT_TRUE(daemon.until([&](const auto&) {
        for (int i = 0; i < 50; ++i) load.send(port, frame(0xDD, 0xFF, 0xF1, Bytes(200, 1)));
        return daemon.count("stuck", "waiting") > 0;
    }));
    daemon.signal(SIGINT);
    daemon.signal(SIGTERM);
    EXPECT_TRUE(wait_until([&] { return !daemon.is_running(); })) << daemon.output();
    EXPECT_EQ(daemon.wait(), 0);
}

TEST(Daemon, sends_waiting_frames_before_it_ends) {
    const TempDir dir;
    PtyDevice slow{dir / "slow"};
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + slow.path(), "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("slow"));
    UdpPeer air;
    const auto port = daemon.port("ground");
    std::size_t sent = 0;
    ASSERT_TRUE(daemon.until([&](const auto&) {
        for (int i = 0; i < 10; ++i, ++sent) air.send(port, frame(0xDD, 0xFF, 0xF1, Bytes(200, 1)));
        return daemon.count("slow", "waiting") > 20;
    }));
    ASSERT_TRUE(wait_until([&] { return daemon.count("ground", "frames_in") == sent; }));
    ASSERT_EQ(daemon.count("slow", "queue_full"), 0u);
    daemon.signal(SIGTERM);
    EXPECT_TRUE(wait_until([&] {
        slow.heard();
        return !daemon.is_running();
    }));
    EXPECT_EQ(split(slow.heard()).frames.size(), sent);
    EXPECT_TRUE(split(slow.heard()).rest.empty());
}

TEST(Daemon, ends_on_sigint_too) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"sim:fc", "serial:" + (dir / "absent")}};
    ASSERT_TRUE(daemon.until_answers());
    const Ended end = terminate(daemon, SIGINT);
    EXPECT_EQ(end.status, 0);
    EXPECT_LT(end.took, at_once);
}

TEST(Daemon, logs_the_status_on_sigusr1_and_does_not_end_on_sighup) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + (dir / "ttyUSB0"), "sim:fc"}};
    ASSERT_TRUE(daemon.until_answers());
    daemon.signal(SIGUSR1);
    EXPECT_TRUE(daemon.until_says("ttyUSB0: waiting: ")) << daemon.output();
    EXPECT_TRUE(daemon.until_says("fc: up, in "));
    daemon.signal(SIGHUP);
    EXPECT_TRUE(daemon.until_says("SIGHUP"));
    EXPECT_TRUE(daemon.is_running());
    EXPECT_EQ(terminate(daemon).status, 0);
}

TEST(Daemon, logs_the_hints) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + fc.path()}};
    ASSERT_TRUE(daemon.until_up("fc")) << daemon.output();
    fc.write(Bytes(500, 0xF8));
    EXPECT_TRUE(daemon.until_says("fc: data but no valid frames: check baud rate and protocol")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
}

// The log lines that contain these words.
std::string line_with(const std::string& words, const std::string& output) {
    const std::size_t at = output.find(words);
    if (at == std::string::npos) return {};
    const std::size_t begin = output.rfind('\n', at) + 1;
    return output.substr(begin, output.find('\n', at) - begin);
}

TEST(Daemon, logs_its_version_and_configuration_first_and_a_summary_last) {
    const TempDir dir;
    std::ofstream{dir / "a.json"} << R"({"links": ["sim:fc"]})";
    Daemon daemon{ANOGATED, dir / "control", {"--config", dir / "a.json", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until([&](const auto&) { return daemon.count("fc", "frames_in") > 0; })) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
    const std::string& said = daemon.output();
    const std::regex first{"\\d{4}-\\d\\d-\\d\\d \\d\\d:\\d\\d:\\d\\d\\.\\d{3} info anogated \\d[.0-9]*, (.*)"};
    std::smatch match;
    const std::string line = said.substr(0, said.find('\n'));
    ASSERT_TRUE(std::regex_match(line, match, first)) << said;
    EXPECT_EQ(match[1],
              (dir / "a.json") +
                  " and command line, 2 links; ground, for ground stations: UDP a port chosen by the system (see the status)");
    ASSERT_EQ(said.back(), '\n');
    const std::size_t last = said.rfind('\n', said.size() - 2) + 1;
    EXPECT_TRUE(std::regex_search(said.substr(last),
                                  std::regex{" info stopping \\(SIGTERM\\) after \\d+ s, [1-9]\\d* frames? in, 0 out\n$"}))
        << said;
}

TEST(Daemon, logs_to_the_journal_with_priorities_and_without_times) {
    const TempDir dir;
    const std::string as_journal = "JOURNAL_STREAM=$(stat -L -c %d:%i /proc/self/fd/2) exec \"$0\" \"$@\"";
    Process daemon{"/bin/sh", {"-c", as_journal, ANOGATED, "--control", dir / "control", "sim:fc", "serial:" + (dir / "absent")}};
    ASSERT_TRUE(daemon.until_says("waiting for it")) << daemon.output();
    ASSERT_TRUE(daemon.until_says("fc: up")) << daemon.output();
    daemon.signal(SIGUSR1);
    ASSERT_TRUE(daemon.until_says("absent: waiting")) << daemon.output();
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_TRUE(line_with("waiting for it", daemon.output()).starts_with("<4>absent: ")) << daemon.output();
    EXPECT_EQ(line_with("fc: up", daemon.output()), "<6>fc: up");
    EXPECT_TRUE(line_with("absent: waiting", daemon.output()).starts_with("<6>absent: ")) << "every line of several";

    Process faulty{"/bin/sh", {"-c", as_journal, ANOGATED, "--control", dir / "control", "sim:plane"}};
    EXPECT_EQ(faulty.wait(), config_fault);
    EXPECT_TRUE(faulty.output().starts_with("<3>anogated: ")) << faulty.output();
}

TEST(Daemon, logs_with_times_if_not_to_the_journal) {
    const TempDir dir;
    Daemon daemon{
        ANOGATED, dir / "control", {"sim:fc"}, {"JOURNAL_STREAM=1:2", "INVOCATION_ID=0123"}};    // as a desktop leaves them
    ASSERT_TRUE(daemon.until_says("fc: up")) << daemon.output();
    EXPECT_TRUE(daemon.output().starts_with("20")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
}

// Root on a machine with nothing installed: there is no problem, so there is no warning.
TEST(Daemon, a_first_run_by_root_logs_no_warning) {
    const TempDir dir;
    std::filesystem::permissions(dir.path(), std::filesystem::perms{0755});    // like /run/anogate
    Daemon daemon{ANOGATED, dir / "control", {"sim:fc", "udp-listen:127.0.0.1:0,name=ground"}};
    ASSERT_TRUE(daemon.until_up("ground")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
    EXPECT_EQ(line_with(" warning ", daemon.output()), "");
    EXPECT_EQ(line_with(" error ", daemon.output()), "");
}

TEST(Daemon, notifies_systemd_when_it_is_ready_and_when_it_stops) {
    const TempDir dir;
    const std::string path = dir / "notify";
    const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    timeval limit{10, 0};
    ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    const auto next = [&] {
        char text[100];
        const ssize_t n = ::recv(fd, text, sizeof text, 0);
        return std::string(text, n > 0 ? static_cast<std::size_t>(n) : 0);
    };
    Daemon daemon{ANOGATED, dir / "control", {"sim:fc"}, {"NOTIFY_SOCKET=" + path, "WATCHDOG_USEC=100000"}};
    EXPECT_EQ(next(), "READY=1");
    EXPECT_NE(http(dir / "control", "GET /status HTTP/1.0\r\n\r\n"), "") << "ready means that it answers";
    EXPECT_EQ(next(), "WATCHDOG=1");
    EXPECT_EQ(next(), "WATCHDOG=1");
    EXPECT_EQ(terminate(daemon).status, 0);
    std::string last;
    do last = next();
    while (last == "WATCHDOG=1");
    EXPECT_EQ(last, "STOPPING=1");
    ::close(fd);
}

TEST(Daemon, reports_in_one_line_why_it_cannot_start) {
    if (sanitized) GTEST_SKIP() << "a sanitizer needs descriptors of its own";
    Process daemon{"/bin/sh", {"-c", "ulimit -n 5; exec \"$0\" --control none sim:fc", ANOGATED}};
    EXPECT_EQ(daemon.wait(), 1) << daemon.output();
    EXPECT_TRUE(daemon.output().starts_with("anogated: ")) << daemon.output();
    EXPECT_NE(daemon.output().find("Too many open files"), std::string::npos) << daemon.output();
}

TEST(Daemon, logs_many_unknown_senders_in_few_lines) {
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground,max_peers=1"}};
    ASSERT_TRUE(daemon.until_up("ground")) << daemon.output();
    const auto port = daemon.port("ground");
    for (int i = 0; i < 200; ++i) UdpPeer{}.send(port, vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&](const auto&) { return daemon.count("ground", "frames_in") == 200; }));
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    const std::string& said = daemon.output();
    EXPECT_LT(std::count(said.begin(), said.end(), '\n'), 50) << said;
    EXPECT_NE(said.find(" more peers came or went"), std::string::npos) << said;
}

TEST(Daemon, keeps_an_existing_socket_of_another_type_at_the_control_path) {
    const TempDir dir;
    const std::string path = dir / "notify";
    const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    Daemon daemon{ANOGATED, path, {"sim:fc"}};
    EXPECT_TRUE(daemon.until_says("another program is using it")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
    const int sender = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(::connect(sender, reinterpret_cast<sockaddr*>(&address), sizeof address), 0) << "it is where it was";
    ::close(sender);
    ::close(fd);
}

TEST(Daemon, fails_if_the_printed_configuration_cannot_be_written_completely) {
    Process daemon{"/bin/sh", {"-c", "exec \"$0\" --print-config sim:fc > /dev/full", ANOGATED}};
    EXPECT_EQ(daemon.wait(), 1) << daemon.output();
    EXPECT_TRUE(daemon.output().starts_with("anogated: ")) << daemon.output();
}

TEST(Daemon, fails_if_the_help_cannot_be_written) {
    for (const char* option : {"--help", "--version"}) {
        Process daemon{"/bin/sh", {"-c", "exec \"$0\" \"$@\" > /dev/full", ANOGATED, option}};
        EXPECT_EQ(daemon.wait(), 1) << option << daemon.output();
        EXPECT_EQ(daemon.output(), "anogated: cannot write the output\n") << option;
    }
}

TEST(Daemon, replaces_closed_standard_files_with_dev_null) {
    const TempDir dir;
    const std::string script = dir / "closed";
    std::ofstream{script} << "#!/bin/sh\nexec " ANOGATED " \"$@\" <&- >&- 2>&-\n";
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
    Daemon daemon{script, dir / "control", {"sim:fc"}};
    ASSERT_TRUE(daemon.until_up("fc"));
    for (const char* fd : {"0", "1", "2"})
        EXPECT_EQ(std::filesystem::read_symlink("/proc/" + std::to_string(daemon.pid()) + "/fd/" + fd), "/dev/null");
    EXPECT_EQ(terminate(daemon).status, 0);
}

TEST(Daemon, rejects_a_pipe_as_a_log_file) {
    const TempDir dir;
    const std::string log = dir / "log";
    ASSERT_EQ(::mkfifo(log.c_str(), 0600), 0);
    std::ofstream{dir / "config.json"} << R"({"links": ["sim:fc"], "log": {"file": ")" << log << R"("}})";
    Daemon daemon{ANOGATED, dir / "control", {"--config", dir / "config.json"}};
    EXPECT_TRUE(daemon.until_up("fc"));
    EXPECT_TRUE(daemon.until_says("logging to standard error: " + log + " is a pipe")) << daemon.output();
    EXPECT_EQ(terminate(daemon).status, 0);
}

TEST(Daemon, does_not_create_the_mistyped_folder_of_a_log_file) {
    const TempDir dir;
    std::ofstream{dir / "config.json"} << R"({"links": ["sim:fc"], "log": {"file": ")" << (dir / "lgo/file") << R"("}})";
    Daemon daemon{ANOGATED, dir / "control", {"--config", dir / "config.json"}};
    EXPECT_TRUE(daemon.until_says("logging to standard error: " + (dir / "lgo/file") + ": there is no folder"))
        << daemon.output();
    EXPECT_FALSE(std::filesystem::exists(dir / "lgo"));
    EXPECT_EQ(terminate(daemon).status, 0);
}

// Takes the ten seconds that the interface guarantees.
TEST(Daemon, exits_with_1_after_ten_seconds_if_a_required_link_is_missing) {
    const TempDir dir;
    const auto begin = std::chrono::steady_clock::now();
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + (dir / "ttyUSB0") + ",required", "sim:fc,required"}};
    EXPECT_EQ(daemon.wait(15s), 1);
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 9s);
    EXPECT_NE(daemon.output().find("required link ttyUSB0 was not up"), std::string::npos) << daemon.output();
}

TEST(Daemon, reports_configuration_errors_one_per_line_and_exits_with_78) {
    const TempDir dir;
    const auto run = [&](std::vector<std::string> arguments, const std::string& words) {
        Process daemon{ANOGATED, std::move(arguments)};
        EXPECT_EQ(daemon.wait(), config_fault) << daemon.output();
        EXPECT_NE(daemon.output().find(words), std::string::npos) << daemon.output();
    };
    run({"serial:/dev/x,bauds=9"}, "LINK 'serial:/dev/x,bauds=9': unknown key 'bauds' (did you mean 'baud'?)");
    run({"serials:/dev/x"}, "serial");
    run({"udp-listen:localhost:99"}, "host name");
    run({"sim:fc,id=21"}, "id");
    run({"sim:fc,id=1", "udp-listen:127.0.0.1:0,id=1"}, "id");
    run({"--route", "0xDC=nobody", "sim:fc"}, "nobody");
    run({"--unknown", "nobody", "sim:fc"}, "nobody");
    run({"sim:fc,max_data=70000"}, "max_data");
    run({"--config", dir / "absent.json"}, "absent.json");
    std::ofstream{dir / "bad.json"} << R"({"links": [{"kind": "serial", "device": "/dev/x", "bauds": 9}], "gatway": {}})";
    run({"--config", dir / "bad.json"}, "/links/0/bauds");
    run({"--config", dir / "bad.json"}, "/gatway");
    run({"--check", "--config", dir / "bad.json"}, "/links/0/bauds");
    run({"--check", "serial:ttyUSB0"}, "did you mean '/dev/ttyUSB0'?");
    run({"--check", "can:can0,bitrate=500000"}, "ip link set can0 up type can bitrate 500000");
    run({"--config", dir / "bad.json", "--config", dir / "other.json"}, "--config: was given 2 times");
}

TEST(Daemon, accepts_its_printed_configuration_with_the_same_meaning) {
    const TempDir dir;
    const auto printed = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "--print-config");
        Process daemon{ANOGATED, std::move(arguments)};
        EXPECT_EQ(daemon.wait(), 0) << daemon.output();
        return daemon.output();
    };
    const std::string first = printed({"--id", "199", "--route", "30-40=fc", "serial:/dev/ttyUSB0,name=fc,baud=250000,id=3",
                                       "udp-listen:[::]:12333,allow=10.0.0.0/8+192.168.1.1",
                                       "udp:192.168.1.20:6670,bind=0.0.0.0:6669", "pty:/tmp/x", "sim:fc,hz=7"});
    std::ofstream{dir / "config.json"} << first;
    EXPECT_EQ(printed({"--config", dir / "config.json"}), first);
}

TEST(Daemon, sleeps_when_there_is_nothing_to_do) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    std::vector<std::string> links{"serial:" + fc.path(), "udp-listen:127.0.0.1:0,name=ground", "pty:" + (dir / "app")};
    for (int i = 0; i < 8; ++i) links.push_back("serial:" + (dir / "absent") + std::to_string(i));
    Daemon daemon{ANOGATED, dir / "control", links};
    ASSERT_TRUE(daemon.until_up("fc"));
    UdpPeer host;
    host.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(wait_until([&] { return daemon.count("ground", "frames_in") == 1; }));
    std::this_thread::sleep_for(2s);    // until retries have reached their longest pause, as a rate is measured
    const long before = daemon.proc_status("voluntary_ctxt_switches");
    std::this_thread::sleep_for(5s);
    EXPECT_LE(daemon.proc_status("voluntary_ctxt_switches") - before, 3 * 5 + 2);
}

// 1.7 MB of them are OpenSSL's, which listening on TCP needs.
TEST(Daemon, stays_below_14_megabytes) {
    if (sanitized) GTEST_SKIP() << "a sanitizer's own memory is counted too";
    const TempDir dir;
    Daemon daemon{ANOGATED, dir / "control", {"udp-listen:127.0.0.1:0,name=ground", "udp-listen:127.0.0.1:0,name=air", "sim:fc"}};
    ASSERT_TRUE(daemon.until_up("air"));
    std::vector<UdpPeer> hosts(16);
    for (UdpPeer& host : hosts) host.send(daemon.port("ground"), vendor::who_are_you);
    UdpPeer air;
    const auto port = daemon.port("air");
    std::uint64_t sent = 0;
    ASSERT_TRUE(daemon.until([&](const auto&) {
        for (int i = 0; i < 200; ++i, ++sent) air.send(port, frame(0xDC, 0xFE, 0xF1, Bytes(1000)));
        for (UdpPeer& host : hosts) host.datagrams();
        return daemon.count("air", "frames_in") > 20000;
    }));
    RecordProperty("rss_kb", std::to_string(daemon.proc_status("VmRSS")));
    EXPECT_LT(daemon.proc_status("VmHWM"), 14 * 1024);
}

TEST(Daemon, continues_after_a_peer_is_lost) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    auto peer = std::make_unique<UdpPeer>();
    Daemon daemon{ANOGATED, dir / "control", {"serial:" + fc.path(), "udp:" + peer->local().text() + ",name=host"}};
    ASSERT_TRUE(daemon.until_up("fc") && daemon.until_up("host"));
    peer.reset();
    EXPECT_TRUE(wait_until([&] {
        fc.write(telemetry);
        return daemon.link("host").value("refused", 0) > 2;
    }));
    fc.unplug();
    EXPECT_TRUE(wait_until([&] { return daemon.link("fc").at("state") == "waiting"; }));
    EXPECT_EQ(terminate(daemon).status, 0);
}

}    // namespace
}    // namespace daemon_tests
