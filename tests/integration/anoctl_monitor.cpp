// `anoctl monitor LINK` as a process, on real ptys and sockets.
#include <gtest/gtest.h>
#include <ano/frame.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/wait.hpp>

namespace anoctl_monitor_tests {
namespace {

const auto euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const auto wind = support::frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

/// Runs `anoctl monitor ...` and collects its output.
class Monitor {
public:
    explicit Monitor(std::vector<std::string> words)
        : process_{ANOCTL, arguments(std::move(words)), {}, [this] { dup2(errors_.write, STDERR_FILENO); }} {}

    const std::string& out() { return process_.output(); }
    const std::string& err() {
        std::array<char, 4096> buffer;
        for (ssize_t n; (n = read(errors_.read, buffer.data(), buffer.size())) > 0;)
            err_text_.append(buffer.data(), static_cast<std::size_t>(n));
        return err_text_;
    }
    bool prints(const std::string& text) {
        return support::wait_until([&] { return err().find(text) != std::string::npos; });
    }
    bool shows(const std::string& text) {
        return support::wait_until([&] { return out().find(text) != std::string::npos; });
    }
    void interrupt() { process_.signal(SIGINT); }
    int exit_code() {
        const int code = process_.wait();
        err();
        return code;
    }

private:
    struct Pipe {
        Pipe() {
            int ends[2];
            if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error{"no pipe"};
            fcntl(ends[0], F_SETFL, O_NONBLOCK);
            read = ends[0];
            write = ends[1];
        }
        ~Pipe() {
            close(read);
            close(write);
        }
        Pipe(const Pipe&) = delete;
        Pipe& operator=(const Pipe&) = delete;
        int read;
        int write;
    };
    static std::vector<std::string> arguments(std::vector<std::string> words) {
        words.insert(words.begin(), "monitor");
        return words;
    }

    Pipe errors_;
    support::Process process_;
    std::string err_text_;
};

TEST(AnoctlMonitor, shows_the_frames_of_a_serial_device) {
    const support::TempDir folder;
    support::PtyDevice device{(folder.path() / "tty").string()};
    Monitor monitor{{"serial:" + device.path(), "--count", "2"}};
    ASSERT_TRUE(monitor.prints("is up")) << monitor.err();
    device.write(euler);
    ASSERT_TRUE(monitor.shows("0xDC 0xFE 0x03 euler rol=1.23 pit=0 yaw=0 fusion_sta=1\n")) << monitor.out();
    device.write(wind);
    EXPECT_EQ(monitor.exit_code(), 0);
    EXPECT_NE(monitor.out().find("0xDD 0xFF 0x09 wind wind_x=1 wind_y=2\n"), std::string::npos);
    EXPECT_NE(monitor.err().find("2 frames shown of 2, 0 bytes outside any frame"), std::string::npos) << monitor.err();
}

TEST(AnoctlMonitor, decodes_text_with_the_encoding_of_the_link_unless_an_option_sets_one) {
    const support::TempDir folder;
    support::PtyDevice device{(folder.path() / "tty").string()};
    const auto log = support::frame(0xDC, 0xFE, 0xA0, {0, 0xC4, 0xA3});    // in GBK one character, in UTF-8 another
    Monitor vendor{{"serial:" + device.path() + ",encoding=gbk", "--count", "1"}};
    ASSERT_TRUE(vendor.prints("is up")) << vendor.err();
    device.write(log);
    EXPECT_EQ(vendor.exit_code(), 0);
    EXPECT_NE(vendor.out().find("模"), std::string::npos) << vendor.out();
    Monitor told{{"serial:" + device.path() + ",encoding=gbk", "--count", "1", "--encoding", "utf8"}};
    ASSERT_TRUE(told.prints("is up")) << told.err();
    device.write(log);
    EXPECT_EQ(told.exit_code(), 0);
    EXPECT_NE(told.out().find("ģ"), std::string::npos) << told.out();
}

TEST(AnoctlMonitor, prints_json_of_the_frames_that_pass_the_filters) {
    const support::TempDir folder;
    const std::string path = (folder.path() / "port").string();
    Monitor monitor{{"pty:" + path, "--json", "--id", "wind", "--from", "0xDD", "--count", "1"}};
    ASSERT_TRUE(monitor.prints("no program has")) << monitor.err();
    support::PortUser user{path};
    ASSERT_TRUE(user.is_open());
    ASSERT_TRUE(monitor.prints("is up")) << monitor.err();
    user.write(euler);
    user.write(wind);
    EXPECT_EQ(monitor.exit_code(), 0);
    EXPECT_EQ(monitor.out().find(
                  "{\"from\":221,\"to\":255,\"id\":9,\"name\":\"wind\",\"fields\":{\"wind_x\":1,\"wind_y\":2},\"time\":"),
              0u)
        << monitor.out();
    EXPECT_NE(monitor.err().find("1 frame shown of 2"), std::string::npos) << monitor.err();
}

TEST(AnoctlMonitor, shows_the_frames_of_udp_peers) {
    Monitor monitor{{"udp-listen:127.0.0.1:0", "--count", "2"}};
    const std::string before_port = "at 127.0.0.1:";
    ASSERT_TRUE(monitor.prints(before_port)) << monitor.err();
    const std::string said = monitor.err();
    const auto port = static_cast<std::uint16_t>(std::stoi(said.substr(said.find(before_port) + before_port.size())));
    support::UdpPeer one;
    support::UdpPeer other;
    ASSERT_TRUE(one.send(port, euler));
    ASSERT_TRUE(monitor.shows("euler")) << monitor.out();
    ASSERT_TRUE(other.send(port, wind));
    EXPECT_EQ(monitor.exit_code(), 0);
    EXPECT_NE(monitor.out().find("127.0.0.1:" + std::to_string(other.port())), std::string::npos) << monitor.out();
}

TEST(AnoctlMonitor, shows_the_frames_of_one_udp_peer) {
    support::UdpPeer peer;
    Monitor monitor{{"udp:127.0.0.1:" + std::to_string(peer.port()) + ",bind=127.0.0.1:0", "--count", "1"}};
    const std::string before_port = "from 127.0.0.1:";
    ASSERT_TRUE(monitor.prints(before_port)) << monitor.err();
    const std::string said = monitor.err();
    const auto port = static_cast<std::uint16_t>(std::stoi(said.substr(said.find(before_port) + before_port.size())));
    ASSERT_TRUE(peer.send(port, euler));
    EXPECT_EQ(monitor.exit_code(), 0);
    EXPECT_NE(monitor.out().find("euler"), std::string::npos);
}

TEST(AnoctlMonitor, waits_for_an_absent_device_and_exits_with_0_when_interrupted) {
    const support::TempDir folder;
    Monitor monitor{{"serial:" + (folder.path() / "tty").string()}};
    ASSERT_TRUE(monitor.prints("waiting")) << monitor.err();
    {
        support::PtyDevice device{(folder.path() / "tty").string()};
        ASSERT_TRUE(monitor.prints("is up")) << monitor.err();
        device.write(euler);
        ASSERT_TRUE(monitor.shows("euler"));
    }
    monitor.interrupt();
    EXPECT_EQ(monitor.exit_code(), 0);
}

TEST(AnoctlMonitor, a_faulty_link_or_filter_is_reported_at_once) {
    Monitor key{{"serial:/dev/x,bauds=9"}};
    EXPECT_EQ(key.exit_code(), 2);
    EXPECT_NE(key.err().find("unknown key 'bauds' (did you mean 'baud'?)"), std::string::npos) << key.err();
    Monitor kind{{"/dev/ttyUSB0"}};
    EXPECT_EQ(kind.exit_code(), 2);
    Monitor id{{"pty:/tmp/x", "--id", "eulr"}};
    EXPECT_EQ(id.exit_code(), 2);
    EXPECT_NE(id.err().find("did you mean 'euler'?"), std::string::npos);
    Monitor from{{"pty:/tmp/x", "--from", "300"}};
    EXPECT_EQ(from.exit_code(), 2);
    Monitor behind{{"--id", "euler", "pty:/tmp/x", "--count", "1"}};
    EXPECT_EQ(behind.exit_code(), 2);
    EXPECT_NE(behind.err().find("place LINK before the options"), std::string::npos) << behind.err();
    Monitor filters{{"pty:/tmp/x", "--direction", "in"}};
    EXPECT_EQ(filters.exit_code(), 2);
}

TEST(AnoctlMonitor, names_the_keys_that_have_no_effect_when_only_receiving) {
    const support::TempDir folder;
    support::PtyDevice device{(folder.path() / "tty").string()};
    Monitor monitor{
        {"serial:" + device.path() + ",baud=500000,profile=vendor,hello=on,limit.0x01=50,send.deny=bulk,receive.deny=0xA0,id=3"}};
    EXPECT_TRUE(monitor.prints("is up"));
    EXPECT_EQ(monitor.err().find("anoctl: ignored: hello, limit.0x01, send.deny, receive.deny, id; monitor only receives\n"), 0u)
        << monitor.err();
    Monitor plain{{"serial:/nowhere/tty,baud=500000,profile=vendor,parity=even,max_data=100,name=fc,encoding=gbk"}};
    EXPECT_TRUE(plain.prints("waiting"));
    EXPECT_EQ(plain.err().find("no effect"), std::string::npos) << plain.err();
}

TEST(AnoctlMonitor, shows_how_to_monitor_a_gateway_that_uses_the_link) {
    const support::TempDir folder;
    const std::string path = (folder.path() / "app").string();
    Monitor first{{"pty:" + path}};
    ASSERT_TRUE(support::wait_until([&] { return std::filesystem::is_symlink(path); })) << first.err();
    Monitor second{{"pty:" + path}};
    EXPECT_TRUE(second.prints("is in use by another gateway; to watch the gateway that uses it: anoctl monitor, without LINK\n"))
        << second.err();
}

TEST(AnoctlMonitor, shows_how_to_monitor_a_gateway_that_uses_the_port) {
    const support::TempDir folder;
    support::PtyDevice device{(folder.path() / "tty").string()};
    support::Daemon gateway{ANOGATED, (folder.path() / "socket").string(), {"serial:" + device.path() + ",name=fc"}};
    ASSERT_TRUE(gateway.until_up("fc"));
    Monitor monitor{{"serial:" + device.path()}};
    EXPECT_TRUE(monitor.prints("); to watch the gateway that uses it: anoctl monitor, without LINK\n")) << monitor.err();
}

TEST(AnoctlMonitor, reports_why_nothing_is_shown) {
    const support::TempDir folder;
    support::PtyDevice device{(folder.path() / "tty").string()};
    Monitor monitor{{"serial:" + device.path()}};
    ASSERT_TRUE(monitor.prints("is up")) << monitor.err();
    device.write(support::Bytes(200, 0x55));
    EXPECT_TRUE(monitor.prints("tty: data but no valid frames: check baud rate and protocol\n")) << monitor.err();
    device.write(euler);
    EXPECT_TRUE(monitor.shows("euler"));
    EXPECT_TRUE(support::wait_until(
        [&] {
            device.write(support::Bytes(20, 0x55));
            return monitor.err().find("tty: data but no valid frames any more: check baud rate and firmware\n") !=
                   std::string::npos;
        },
        2 * support::patience))
        << monitor.err();
}

}    // namespace
}    // namespace anoctl_monitor_tests
