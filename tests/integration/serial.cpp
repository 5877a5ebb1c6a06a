// Serial ports in all situations of their use: pseudo-terminals replace the devices, everything else is real.
#include <link/serial/serial_settings.hpp>
#include <support/child.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>
#include <support/wait.hpp>
#include <sys/device_holder.hpp>

#include <gtest/gtest.h>

#include <grp.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <fstream>

namespace serial_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

TEST(SerialLink, vendor_bytes_pass_unchanged_both_ways) {
    const TempDir dir;
    PtyDevice mcu{dir / "ttyUSB0"};
    RunningGateway daemon{serial("mcu", mcu.path()), udp_listen("ground")};
    ASSERT_TRUE(daemon.until_up("mcu"));
    UdpPeer ground;

    ground.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return mcu.heard() == vendor::who_are_you; }));
    mcu.write(vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
    ground.send(daemon.port("ground"), vendor::write_parameter);
    EXPECT_TRUE(daemon.until([&] { return mcu.heard() == vendor::who_are_you + vendor::write_parameter; }));
    mcu.write(vendor::written);
    EXPECT_TRUE(daemon.until([&] { return ground.heard() == vendor::i_am_an_mcu + vendor::written; }));
    ground.send(daemon.port("ground"), vendor::command);
    EXPECT_TRUE(daemon.until([&] { return mcu.heard() == vendor::who_are_you + vendor::write_parameter + vendor::command; }));
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(SerialLink, a_frame_sent_one_byte_at_a_time_arrives_whole) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"};
    RunningGateway daemon{serial("a", a.path()), serial("b", b.path())};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("b"));
    for (std::size_t i = 0; i < vendor::i_am_an_mcu.size(); ++i) {
        EXPECT_TRUE(b.heard().empty());
        a.write(std::span{vendor::i_am_an_mcu}.subspan(i, 1));
        ASSERT_TRUE(daemon.until([&] { return daemon.count("a", "bytes_in") == i + 1; }));
    }
    EXPECT_TRUE(daemon.until([&] { return b.heard() == vendor::i_am_an_mcu; }));
}

TEST(SerialLink, suggests_the_right_form_for_an_absent_device_written_as_for_other_programs) {
    RunningGateway daemon{serial("a", "ttyAbsent"), serial("b", "/dev/ttyAbsent:115200"),
                          serial("c", "/dev/by-path/usb-0:1:1.0")};
    EXPECT_EQ(daemon.link("a").at("error"), "ttyAbsent not found (did you mean /dev/ttyAbsent?)");
    EXPECT_EQ(daemon.link("b").at("error"), "/dev/ttyAbsent:115200 not found (did you mean /dev/ttyAbsent,baud=115200?)");
    EXPECT_EQ(daemon.link("c").at("error"), "/dev/by-path/usb-0:1:1.0 not found");
}

TEST(SerialLink, other_links_are_not_disturbed_when_a_device_is_plugged_and_unplugged) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"}, fc{dir / "fc"};
    fc.unplug();
    RunningGateway daemon{serial("fc", fc.path()), serial("a", a.path()), serial("b", b.path())};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("b"));
    EXPECT_EQ(daemon.link("fc").at("state"), "waiting");
    EXPECT_EQ(daemon.link("fc").at("error"), fc.path() + " not found");

    b.write(frame(0xDE, 0xDD, 0xF1));
    ASSERT_TRUE(daemon.until([&] { return a.heard() == frame(0xDE, 0xDD, 0xF1); })) << "0xDE is known to be at b";
    Bytes sent;
    std::uint8_t n = 0;
    const auto others_flow = [&] {
        const Bytes next = frame(0xDD, 0xDE, 0xF1, {n++});
        sent = sent + next;
        a.write(next);
        return daemon.until([&] { return b.heard() == sent; }, 1s);
    };
    EXPECT_TRUE(others_flow());
    for (int round = 0; round < 3; ++round) {
        fc.plug();
        EXPECT_TRUE(daemon.until([&] { return others_flow() && daemon.link("fc").at("state") == "up"; }));
        EXPECT_EQ(daemon.link("fc").at("error"), "");
        const auto frames_before = daemon.count("fc", "frames_in");
        fc.write(frame(0xDB, 0xDD, 0xF1));
        EXPECT_TRUE(daemon.until([&] { return daemon.count("fc", "frames_in") > frames_before; })) << "it is heard";
        a.write(frame(0xDD, 0xDB, 0xF1));
        EXPECT_TRUE(daemon.until([&] { return fc.read() == frame(0xDD, 0xDB, 0xF1); })) << "it hears";
        fc.unplug();
        EXPECT_TRUE(daemon.until([&] { return others_flow() && daemon.link("fc").at("state") == "waiting"; }));
        EXPECT_NE(daemon.link("fc").at("error"), "");
    }
    EXPECT_EQ(daemon.count("fc", "frames_in"), 3u) << "counters of a link never decrease";
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(SerialLink, frames_for_an_unplugged_device_are_counted_and_not_sent_later) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, fc{dir / "fc"};
    fc.unplug();
    auto fc_link = serial("fc", fc.path());
    fc_link.id = 1;
    RunningGateway daemon{serial("a", a.path()), fc_link};
    ASSERT_TRUE(daemon.until_up("a"));
    for (int i = 0; i < 5; ++i) a.write(frame(0xFE, 1, 0xC0, {1, 2, 3}));
    EXPECT_TRUE(daemon.until([&] { return daemon.count("fc", "link_down") == 5; }));
    EXPECT_EQ(daemon.count("a", "no_route"), 0u) << "there was a taker, it was down";
    fc.plug();
    ASSERT_TRUE(daemon.until_up("fc"));
    a.write(frame(0xFE, 1, 0xC0, {4, 5, 6}));
    EXPECT_TRUE(daemon.until([&] { return !fc.heard().empty(); }));
    EXPECT_EQ(fc.heard(), frame(0xFE, 1, 0xC0, {4, 5, 6}));
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(SerialLink, waits_for_a_port_that_another_program_has_locked_and_names_it_in_the_status) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    Child holder{[&] {
        const int fd = ::open(fc.path().c_str(), O_RDWR | O_NOCTTY);
        if (::flock(fd, LOCK_EX | LOCK_NB) != 0 || ::write(ready[1], "", 1) != 1) return 1;
        ::pause();
        return 0;
    }};
    char byte;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    RunningGateway daemon{serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_waiting("fc"));
    const std::string error = daemon.link("fc").at("error");
    EXPECT_NE(error.find("in use by"), std::string::npos) << error;
    EXPECT_NE(error.find("(pid " + std::to_string(holder.pid()) + ")"), std::string::npos) << error;
    ::kill(holder.pid(), SIGKILL);
    holder.wait();
    EXPECT_TRUE(daemon.until_up("fc")) << "it is free now";
}

// socat may have both sides of a pseudo-terminal open: that is the device of the port, and does not take its bytes.
TEST(SerialLink, a_program_that_holds_the_other_side_of_the_port_does_not_count_as_a_second_reader) {
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    Child socat{[&] {
        const int master = ::posix_openpt(O_RDWR | O_NOCTTY);
        if (::grantpt(master) != 0 || ::unlockpt(master) != 0) return 1;
        const std::string name = ::ptsname(master);
        const int user_side = ::open(name.c_str(), O_RDWR | O_NOCTTY);
        if (user_side < 0 || ::write(ready[1], name.c_str(), name.size() + 1) < 0) return 1;
        return ::pause();
    }};
    char name[64];
    ASSERT_GT(::read(ready[0], name, sizeof name), 0);
    ASSERT_TRUE(anogate::device_holder(name));
    EXPECT_FALSE(anogate::device_holder(name, anogate::OtherSide::does_not_count));
    RunningGateway daemon{serial("fc", name)};
    ASSERT_TRUE(daemon.until_up("fc"));
    EXPECT_NE(daemon.link("fc").at("hint_id"), "shared_port") << daemon.link("fc");
}

TEST(SerialLink, names_a_program_that_has_the_port_open_without_a_lock_until_it_ends) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    Child other{[&] {
        ::close(fc.fd());    // a process that has the other side open as well takes no bytes
        const PortUser reads{fc.path()};
        return ::pause();
    }};
    ASSERT_TRUE(wait_until([&] {
        const auto holder = anogate::device_holder(fc.path());
        return holder && holder->pid == other.pid();
    }));
    RunningGateway daemon{serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_up("fc"));
    const auto link = daemon.link("fc");
    EXPECT_EQ(link.at("hint_id"), "shared_port") << link;
    EXPECT_NE(
        link.at("hint").get<std::string>().find("(pid " + std::to_string(other.pid()) + ") has " + fc.path() + " open, too"),
        std::string::npos)
        << link;
    ::kill(other.pid(), SIGKILL);
    other.wait();
    EXPECT_NE(daemon.link("fc").at("hint_id"), "shared_port");
}

TEST(SerialLink, waits_for_a_port_that_another_program_has_opened_exclusively) {
    if (::getuid() != 0) GTEST_SKIP() << "needs root to become nobody: root itself opens exclusive ports";
    const TempDir dir;
    ::chmod(dir.path().c_str(), 0755);
    PtyDevice fc{dir / "fc"};
    ::chmod(fc.terminal().c_str(), 0666);
    const PortUser holder{fc.path()};
    ASSERT_EQ(::ioctl(holder.fd(), TIOCEXCL), 0);
    int busy[2];
    ASSERT_EQ(::pipe(busy), 0);
    Child child{[&] {
        if (!become_nobody()) return 1;
        RunningGateway daemon{serial("fc", fc.path())};
        if (!daemon.until([&] { return daemon.link("fc").at("error") == fc.path() + " is in use by another program"; })) return 2;
        if (::write(busy[1], "", 1) != 1) return 3;
        return daemon.until_up("fc") ? 0 : 4;
    }};
    ::close(busy[1]);
    char byte;
    EXPECT_EQ(::read(busy[0], &byte, 1), 1);
    ::ioctl(holder.fd(), TIOCNXCL);
    EXPECT_EQ(child.wait(), 0);
}

/// A gateway run by root has the port open; other gateways are run by the user nobody.
class SerialLinkOfRoot : public testing::Test {
protected:
    void SetUp() override {
        if (::getuid() != 0) GTEST_SKIP() << "needs root to become nobody: root itself opens exclusive ports";
        ::chmod(dir.path().c_str(), 0755);
        ::chmod(fc.terminal().c_str(), 0666);
    }
    int open_as_nobody() {
        return Child{[&] {
                   if (!become_nobody()) return 1;
                   return ::open(fc.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK) >= 0 ? 0 : errno;
               }}
            .wait();
    }
    /// Runs a gateway as the user nobody; the child exits with 0 if its status for the port is `expected`.
    int gateway_of_nobody(const std::string& state, const std::string& error) {
        return Child{[&] {
                   if (!become_nobody()) return 1;
                   RunningGateway daemon{serial("fc", fc.path())};
                   const auto is_so = [&](const nlohmann::json& link) {
                       return link.at("state") == state && link.at("error") == error;
                   };
                   return daemon.until([&] { return is_so(daemon.link("fc")); }) ? 0 : 2;
               }}
            .wait();
    }
    TempDir dir;
    PtyDevice fc{dir / "fc"};
};

TEST_F(SerialLinkOfRoot, locks_out_other_gateways_while_the_port_is_open_and_not_afterwards) {
    RunningGateway daemon{serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_up("fc"));
    EXPECT_EQ(gateway_of_nobody("waiting", fc.path() + " is in use by another program"), 0);
    daemon.stop();
    EXPECT_EQ(gateway_of_nobody("up", ""), 0);
}

// The master of a pseudo-terminal keeps the terminal and its settings after its last user has closed it.
TEST_F(SerialLinkOfRoot, leaves_a_pseudo_terminal_usable_for_all_users_after_the_program_is_killed) {
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    Child killed{[&] {
        RunningGateway daemon{serial("fc", fc.path())};
        if (!daemon.until_up("fc") || ::write(ready[1], "", 1) != 1) return 1;
        return ::pause();
    }};
    ::close(ready[1]);
    char byte;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    ::close(ready[0]);
    ::kill(killed.pid(), SIGKILL);
    killed.wait();
    EXPECT_EQ(open_as_nobody(), 0);
    EXPECT_EQ(gateway_of_nobody("up", ""), 0);
}

TEST(SerialLink, closing_the_port_does_not_reset_the_board) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    const PortUser earlier{fc.path()};
    termios t = fc.settings();
    t.c_cflag |= HUPCL;    // the default of most ports
    ASSERT_EQ(::tcsetattr(earlier.fd(), TCSANOW, &t), 0);
    ASSERT_NE(fc.settings().c_cflag & HUPCL, 0u);
    RunningGateway daemon{serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_up("fc"));
    EXPECT_EQ(fc.settings().c_cflag & HUPCL, 0u);
    daemon.stop();
    EXPECT_EQ(fc.settings().c_cflag & HUPCL, 0u);
}

TEST(SerialLink, the_line_is_raw_8n1_by_default) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, b{dir / "b"};
    auto odd = serial("b", b.path());
    odd.as<anogate::SerialSettings>().parity = anogate::Parity::odd;
    odd.as<anogate::SerialSettings>().stop_bits = 2;
    RunningGateway daemon{serial("a", a.path()), odd};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("b"));
    const termios raw = a.settings();
    EXPECT_EQ(raw.c_lflag & (ICANON | ECHO | ISIG | IEXTEN), 0u);
    EXPECT_EQ(raw.c_iflag & (ICRNL | IXON | IXOFF | INLCR | ISTRIP | PARMRK), 0u);
    EXPECT_EQ(raw.c_oflag & OPOST, 0u);
    EXPECT_EQ(raw.c_cflag & (CSTOPB | PARENB | CRTSCTS), 0u);
    // A pty does not support parity: the kernel shows 8 bits without parity, whatever was requested.
    EXPECT_EQ(raw.c_cflag & CSIZE, static_cast<tcflag_t>(CS8));
    EXPECT_NE(b.settings().c_cflag & CSTOPB, 0u);

    // Every byte value, including control characters.
    Bytes all(256);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
    a.write(frame(0xDC, 0xFE, 0xF1, all));
    EXPECT_TRUE(daemon.until([&] { return b.heard() == frame(0xDC, 0xFE, 0xF1, all); }));
}

class AnyBaud : public testing::TestWithParam<std::uint32_t> {};
TEST_P(AnyBaud, is_set_and_shown) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    auto link = serial("fc", fc.path());
    link.as<anogate::SerialSettings>().baud = GetParam();
    RunningGateway daemon{link};
    ASSERT_TRUE(daemon.until_up("fc")) << daemon.link("fc");
    EXPECT_EQ(daemon.link("fc").at("baud"), GetParam());
}
INSTANTIATE_TEST_SUITE_P(SerialLink, AnyBaud, testing::Values(1200, 9600, 115200, 250000, 500000, 921600, 3333333, 5000000));

TEST(HidLink, a_path_that_is_not_a_hidraw_device_is_reported_with_the_way_to_find_one) {
    const TempDir dir;
    std::ofstream{dir / "file"} << "notes";
    RunningGateway daemon{settings_of_texts({"hid:" + (dir / "file") + ",name=file", "hid:/dev/null,name=null"})};
    const auto error = [&](const std::string& name) { return daemon.link(name).value("error", ""); };
    EXPECT_TRUE(daemon.until([&] { return !error("file").empty() && !error("null").empty(); }));
    for (const std::string name : {"file", "null"})
        EXPECT_NE(error(name).find(" is not a hidraw device with a byte stream; `anoctl ports` lists the devices"),
                  std::string::npos)
            << error(name);
}

TEST(SerialLink, a_path_that_is_not_a_serial_port_is_reported_with_the_reason) {
    const TempDir dir;
    std::ofstream{dir / "file"} << "notes";
    std::filesystem::create_directory(dir / "folder");
    PtyDevice fc{dir / "fc"};
    RunningGateway daemon{serial("file", dir / "file"), serial("folder", dir / "folder"), serial("null", "/dev/null"),
                          serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_up("fc"));
    EXPECT_EQ(daemon.link("file").at("error"), (dir / "file") + ": this is not a serial port");
    EXPECT_EQ(daemon.link("null").at("error"), "/dev/null: this is not a serial port");
    EXPECT_EQ(daemon.link("folder").at("error"), (dir / "folder") + ": Is a directory");
    std::string kept;
    std::ifstream{dir / "file"} >> kept;
    EXPECT_EQ(kept, "notes");
}

TEST(SerialLink, a_port_without_permission_is_reported_with_the_action_to_take) {
    if (::getuid() != 0) GTEST_SKIP() << "needs root to become nobody";
    const TempDir dir;
    ::chmod(dir.path().c_str(), 0755);
    PtyDevice fc{dir / "fc"};
    ::chmod(fc.terminal().c_str(), 0600);
    const auto nobody_is_told = [&](const std::string& words) {
        return Child{[&] {
                   if (!become_nobody()) return 1;
                   RunningGateway daemon{serial("fc", fc.path())};
                   return daemon.link("fc").at("error") == fc.path() + ": no permission: " + words ? 0 : 2;
               }}
            .wait();
    };
    ASSERT_EQ(::chown(fc.terminal().c_str(), 0, 0), 0);
    EXPECT_EQ(nobody_is_told("only root may open it: add a udev rule for a group (GROUP=\"dialout\", MODE=\"0660\")"), 0);
    const group* const dialout = ::getgrnam("dialout");
    if (dialout == nullptr) GTEST_SKIP() << "there is no group dialout";
    ASSERT_EQ(::chown(fc.terminal().c_str(), 0, dialout->gr_gid), 0);
    ::chmod(fc.terminal().c_str(), 0660);
    EXPECT_EQ(nobody_is_told("it belongs to the group dialout: sudo usermod -aG dialout $USER, and log in again"), 0);
}

TEST(SerialLink, a_port_whose_data_is_not_read_does_not_delay_the_stop) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, stuck{dir / "stuck"};
    RunningGateway daemon{serial("a", a.path()), serial("stuck", stuck.path())};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("stuck"));
    const Bytes big = frame(0xDC, 0xFE, 0xF1, Bytes(1000, 0x55));
    EXPECT_TRUE(daemon.until([&] {
        a.write(big);
        return daemon.count("stuck", "waiting") > 10;
    }));
    EXPECT_LT(daemon.stop(), 1s);
}

TEST(SerialLink, waiting_frames_are_sent_at_the_end_if_the_device_reads) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, slow{dir / "slow"};
    RunningGateway daemon{serial("a", a.path()), serial("slow", slow.path())};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("slow"));
    Bytes sent;
    for (std::uint8_t n = 0; n < 100 && daemon.count("slow", "waiting") < 5; ++n) {
        const Bytes next = frame(0xDC, 0xFE, 0xF1, Bytes(1000, n));
        ASSERT_EQ(a.write(next), next.size());
        sent = sent + next;
        ASSERT_TRUE(daemon.until([&] { return daemon.count("a", "frames_in") == n + 1u; }));
    }
    ASSERT_EQ(daemon.count("slow", "waiting"), 5u) << "the kernel's buffer is full";
    EXPECT_LT(daemon.stop(500ms, [&] { slow.heard(); }), 1s);
    EXPECT_EQ(slow.heard().size(), sent.size());
    EXPECT_EQ(slow.heard(), sent);
}

TEST(SerialLink, sent_frames_still_reach_the_device_after_the_program_ends) {
    const TempDir dir;
    PtyDevice a{dir / "a"}, slow{dir / "slow"};
    RunningGateway daemon{serial("a", a.path()), serial("slow", slow.path())};
    ASSERT_TRUE(daemon.until_up("a") && daemon.until_up("slow"));
    a.write(vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("slow", "frames_out") == 1; }));
    daemon.stop();
    EXPECT_EQ(slow.heard(), vendor::i_am_an_mcu);
}

TEST(SerialLink, discards_data_received_before_the_device_is_opened) {
    const TempDir dir;
    PtyDevice fc{dir / "fc"};
    const PortUser keeps_raw{fc.path()};
    termios raw = fc.settings();
    ::cfmakeraw(&raw);
    ::tcsetattr(fc.fd(), TCSANOW, &raw);
    fc.write(frame(0xDC, 0xFE, 0x01));
    RunningGateway daemon{serial("fc", fc.path())};
    ASSERT_TRUE(daemon.until_up("fc"));
    fc.write(frame(0xDC, 0xFE, 0x03));
    EXPECT_TRUE(daemon.until([&] { return daemon.count("fc", "frames_in") > 0; }));
    daemon.run_for(20ms);
    EXPECT_EQ(daemon.count("fc", "frames_in"), 1u);
}

}    // namespace
}    // namespace serial_tests
