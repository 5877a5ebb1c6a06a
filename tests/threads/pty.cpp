// The pty link: a program opens the path as if it were a serial port.
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <sys/syscall.h>

#include <fstream>
#include <optional>

// Replaces libc's function: a user has about 128 instances of inotify, and other programs may use all of them.
static bool inotify_instances_left = true;
static int inotify_instances_made = 0;

extern "C" int inotify_init1(int flags) noexcept {
    if (inotify_instances_left) return ++inotify_instances_made, static_cast<int>(::syscall(SYS_inotify_init1, flags));
    errno = EMFILE;
    return -1;
}

namespace pty_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
namespace fs = std::filesystem;

class WithoutInotify {
public:
    WithoutInotify() { inotify_instances_left = false; }
    ~WithoutInotify() { inotify_instances_left = true; }
};

TEST(PtyLink, a_program_at_the_path_and_a_peer_exchange_frames) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), udp_listen("ground")};
    EXPECT_EQ(daemon.link("app").at("state"), "waiting");
    EXPECT_EQ(daemon.link("app").at("error"), "no program has opened " + (dir / "app"));
    EXPECT_EQ(fs::read_symlink(dir / "app"), daemon.link("app").at("device").get<std::string>());
    UdpPeer ground;
    PortUser app{dir / "app"};
    ASSERT_TRUE(app.is_open());
    EXPECT_TRUE(daemon.until_up("app"));
    app.write(vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return daemon.count("app", "frames_in") == 1; }));
    ground.send(daemon.port("ground"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return app.heard() == vendor::i_am_an_mcu; }));
    app.write(vendor::write_parameter);
    EXPECT_TRUE(daemon.until([&] { return ground.heard() == vendor::write_parameter; }));
}

void close_and_open_again() {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), udp_listen("ground")};
    UdpPeer ground;
    const auto send = [&](std::uint8_t n) {
        const auto before = daemon.count("ground", "frames_in");
        ground.send(daemon.port("ground"), frame(0xDC, 0xFE, 0xF1, {n}));
        return daemon.until([&] { return daemon.count("ground", "frames_in") == before + 1; });
    };
    const std::string device = daemon.link("app").at("device");
    for (std::uint8_t round = 0; round < 3; ++round) {
        PortUser app{dir / "app"};
        ASSERT_TRUE(app.is_open());
        ASSERT_TRUE(daemon.until_up("app"));
        ASSERT_TRUE(send(round));
        EXPECT_TRUE(daemon.until([&] { return !app.heard().empty(); }));
        EXPECT_EQ(app.heard(), frame(0xDC, 0xFE, 0xF1, {round})) << "round " << int{round};
        ASSERT_TRUE(send(100)) << "this one is never read";
        ASSERT_TRUE(daemon.until([&] { return daemon.count("app", "frames_out") == 2u * round + 2; }));
        app.close();
        ASSERT_TRUE(daemon.until_waiting("app"));
        ASSERT_TRUE(send(200)) << "nobody is there";
        EXPECT_EQ(daemon.count("app", "link_down"), round + 1u);
        EXPECT_EQ(daemon.link("app").at("device"), device) << "the same terminal";
    }
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST(PtyLink, a_user_that_closes_and_reopens_receives_nothing_stale) { close_and_open_again(); }

TEST(PtyLink, a_user_that_closes_and_reopens_receives_nothing_stale_without_inotify) {
    const WithoutInotify without;
    close_and_open_again();
}

TEST(PtyLink, is_not_up_without_a_user_even_without_inotify) {
    const WithoutInotify without;
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), udp_listen("ground")};
    EXPECT_EQ(daemon.link("app").at("error"), "no program has opened " + (dir / "app"));
    UdpPeer ground;
    ground.send(daemon.port("ground"), vendor::who_are_you);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("app", "link_down") == 1; }));
    { PortUser{dir / "app"}.write(vendor::i_am_an_mcu); }    // opened and closed between two checks
    EXPECT_TRUE(daemon.until([&] { return daemon.count("app", "frames_in") == 1; }));
    fs::remove(dir / "app");
    EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "app"); }));
}

TEST(PtyLink, watches_again_when_there_is_inotify) {
    const TempDir dir;
    std::optional<WithoutInotify> without{std::in_place};
    RunningGateway daemon{pty("app", dir / "app")};
    const int made_before = inotify_instances_made;
    without.reset();
    ASSERT_TRUE(daemon.until([&] { return inotify_instances_made > made_before; }));
    without.emplace();    // it keeps an inotify instance that it has
    PortUser app{dir / "app"};
    EXPECT_TRUE(daemon.until_up("app"));
}

TEST(PtyLink, receives_data_that_its_user_wrote_before_closing) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app")};
    {
        PortUser app{dir / "app"};
        app.write(vendor::who_are_you);
    }
    EXPECT_TRUE(daemon.until([&] { return daemon.count("app", "frames_in") == 1; }));
    EXPECT_TRUE(daemon.until_waiting("app"));
    {
        PortUser app{dir / "app"};
        app.write(vendor::who_are_you);
        ASSERT_TRUE(daemon.until([&] { return daemon.count("app", "frames_in") == 2; }));
        app.write(vendor::who_are_you);
    }
    EXPECT_TRUE(daemon.until([&] { return daemon.count("app", "frames_in") == 3; }));
}

TEST(PtyLink, is_up_as_long_as_one_of_several_users_is_left) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), udp_listen("ground")};
    UdpPeer ground;
    PortUser first{dir / "app"}, second{dir / "app"}, third{dir / "app"};
    ASSERT_TRUE(daemon.until_up("app"));
    first.close();
    third.close();
    daemon.run_for(20ms);
    EXPECT_EQ(daemon.link("app").at("state"), "up");
    ground.send(daemon.port("ground"), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return second.heard() == vendor::i_am_an_mcu; }));
    second.close();
    EXPECT_TRUE(daemon.until_waiting("app"));
}

TEST(PtyLink, a_user_who_does_not_read_does_not_hold_up_the_others) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), pty("other", dir / "other"), udp_listen("ground")};
    UdpPeer ground;
    PortUser stuck{dir / "app"}, other{dir / "other"};
    ASSERT_TRUE(daemon.until_up("app") && daemon.until_up("other"));
    const Bytes big = frame(0xDC, 0xFE, 0xF1, Bytes(1000, 1));
    ASSERT_TRUE(daemon.until([&] {
        ground.send(daemon.port("ground"), big);
        other.heard();
        return daemon.count("app", "queue_full") > 0;
    }));
    ASSERT_TRUE(daemon.until([&] {
        other.heard();
        return daemon.count("other", "waiting") == 0;
    }));
    EXPECT_EQ(daemon.count("other", "queue_full"), 0u);
    EXPECT_EQ(other.heard().size() / big.size(), daemon.count("ground", "frames_in"));
    EXPECT_TRUE(daemon.counters_add_up());
    EXPECT_LT(daemon.stop(), 1s);
}

TEST(PtyLink, the_path_is_created_with_its_folder_and_removed_at_the_end) {
    const TempDir dir;
    ::setenv("XDG_RUNTIME_DIR", (dir / "run").c_str(), 1);    // in which the folder anogate belongs to us
    {
        RunningGateway daemon{pty("app", dir / "run/anogate/app")};
        EXPECT_TRUE(fs::is_symlink(dir / "run/anogate/app"));
        daemon.stop();
        EXPECT_FALSE(fs::exists(fs::symlink_status(dir / "run/anogate/app")));
    }
    ::unsetenv("XDG_RUNTIME_DIR");
}

TEST(PtyLink, a_folder_that_was_mistyped_is_not_made) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "rnu/anogate/app")};
    EXPECT_EQ(daemon.link("app").at("error"), (dir / "rnu/anogate/app") + ": there is no folder " + (dir / "rnu/anogate"));
    EXPECT_FALSE(fs::exists(dir / "rnu"));
    fs::create_directories(dir / "rnu/anogate");
    EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "rnu/anogate/app"); })) << "it is waited for";
}

TEST(PtyLink, waiting_frames_are_delivered_at_the_end_to_a_user_that_reads) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app"), udp_listen("ground")};
    UdpPeer ground;
    PortUser app{dir / "app"};
    ASSERT_TRUE(daemon.until_up("app"));
    ground.send(daemon.port("ground"), vendor::i_am_an_mcu);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("app", "frames_out") == 1; }));
    bool late = false;    // it reads shortly after the signal
    daemon.stop(500ms, [&] {
        if (std::exchange(late, true)) app.heard();
    });
    EXPECT_EQ(app.heard(), vendor::i_am_an_mcu);
}

TEST(PtyLink, a_symlink_of_an_earlier_run_is_replaced) {
    const TempDir dir;
    fs::create_symlink("/dev/pts/99999", dir / "app");
    RunningGateway daemon{pty("app", dir / "app")};
    EXPECT_EQ(fs::read_symlink(dir / "app"), daemon.link("app").at("device").get<std::string>());
}

TEST(PtyLink, waits_for_a_path_that_another_gateway_uses) {
    const TempDir dir;
    fs::create_directory_symlink(dir.path(), dir / "same");
    std::optional<RunningGateway> first;
    first.emplace(std::initializer_list<anogate::LinkSettings>{pty("app", dir / "app")});
    const std::string device = first->link("app").at("device");
    RunningGateway second{pty("app", dir / "same/app"), pty("own", dir / "own")};
    EXPECT_EQ(second.link("app").at("error"), (dir / "same/app") + " is in use by another gateway");
    EXPECT_EQ(fs::read_symlink(dir / "own"), second.link("own").at("device").get<std::string>());
    second.run_for(100ms);
    EXPECT_EQ(fs::read_symlink(dir / "app"), device);
    first.reset();
    EXPECT_TRUE(second.until([&] { return fs::is_symlink(dir / "app"); }));
    PortUser app{dir / "app"};
    EXPECT_TRUE(second.until_up("app")) << second.link("app");
}

TEST(PtyLink, the_path_of_a_killed_gateway_is_recreated) {
    const TempDir dir;
    Daemon killed{ANOGATED, dir / "control", {"pty:" + (dir / "app")}};
    ASSERT_TRUE(killed.until_answers());
    PtyDevice others{dir / "others"};    // its terminal may reuse the number of the closed one
    killed.signal(SIGKILL);
    killed.wait();
    ASSERT_TRUE(fs::is_symlink(dir / "app"));
    PtyDevice more{dir / "more"};
    RunningGateway next{pty("app", dir / "app")};
    EXPECT_EQ(fs::read_symlink(dir / "app"), next.link("app").at("device").get<std::string>());
    EXPECT_EQ(next.link("app").at("error"), "no program has opened " + (dir / "app"));
}

TEST(PtyLink, a_path_that_another_program_replaced_is_reported_and_recreated_when_it_is_free) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app")};
    const std::string device = daemon.link("app").at("device");
    fs::create_symlink("/dev/pts/99999", dir / "others");
    fs::rename(dir / "others", dir / "app");
    EXPECT_TRUE(daemon.until([&] {
        return daemon.link("app").at("error") ==
               (dir / "app") + " leads to /dev/pts/99999, which belongs to another program: choose another path for this link";
    })) << daemon.link("app").at("error");
    fs::remove(dir / "app");
    EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "app"); }));
    EXPECT_EQ(fs::read_symlink(dir / "app"), device);
    EXPECT_EQ(daemon.link("app").at("error"), "no program has opened " + (dir / "app"));
    const PortUser app{dir / "app"};
    EXPECT_TRUE(daemon.until_up("app"));
}

TEST(PtyLink, a_path_that_another_program_replaced_is_not_removed_at_the_end) {
    const TempDir dir;
    PtyDevice others{dir / "others"};
    RunningGateway daemon{pty("app", dir / "app"), pty("own", dir / "own")};
    {
        const PortUser app{dir / "app"};
        ASSERT_TRUE(daemon.until_up("app"));
        fs::create_symlink(others.terminal(), dir / "new");
        fs::rename(dir / "new", dir / "app");
        daemon.run_for(50ms);
        EXPECT_EQ(daemon.link("app").at("state"), "up") << "who has it open goes on";
    }
    daemon.stop();
    EXPECT_EQ(fs::read_symlink(dir / "app"), others.terminal());
    EXPECT_FALSE(fs::exists(fs::symlink_status(dir / "own")));
}

TEST(PtyLink, a_path_that_was_removed_is_made_again_each_time) {
    const TempDir dir;
    RunningGateway daemon{pty("app", dir / "app")};
    for (int round = 0; round < 3; ++round) {
        fs::remove(dir / "app");
        EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "app"); }));
        const PortUser app{dir / "app"};
        EXPECT_TRUE(daemon.until_up("app"));
        fs::remove(dir / "app");
        EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "app"); })) << "in use, too";
        EXPECT_EQ(daemon.link("app").at("state"), "up");
    }
}

TEST(PtyLink, keeps_an_existing_file_at_its_path_and_waits) {
    const TempDir dir;
    std::ofstream{dir / "app"} << "precious";
    std::ofstream{dir / "app.new"} << "precious";
    fs::create_symlink("/dev/null", dir / "port");
    RunningGateway daemon{pty("app", dir / "app"), pty("port", dir / "port")};
    EXPECT_EQ(daemon.link("app").at("state"), "waiting");
    EXPECT_NE(daemon.link("app").at("error").get<std::string>().find("is left alone"), std::string::npos);
    EXPECT_TRUE(fs::is_regular_file(dir / "app"));
    EXPECT_EQ(fs::read_symlink(dir / "port"), "/dev/null") << "a link to somebody else's device";
    EXPECT_NE(daemon.link("port").at("error").get<std::string>().find("is left alone"), std::string::npos);
    fs::remove(dir / "app");
    EXPECT_TRUE(daemon.until([&] { return fs::is_symlink(dir / "app"); })) << "the way is free now";
    EXPECT_TRUE(fs::is_regular_file(dir / "app.new"));
    PortUser app{dir / "app"};
    EXPECT_TRUE(daemon.until_up("app"));
}

TEST(PtyLink, is_never_up_while_its_path_is_taken) {
    const TempDir dir;
    std::ofstream{dir / "app"} << "mine";
    RunningGateway daemon{pty("app", dir / "app")};
    daemon.run_for(300ms);
    EXPECT_FALSE(daemon.gateway().links()[0].was_up);
    EXPECT_NE(daemon.link("app").at("error").get<std::string>().find("exists, was not created by anogated"), std::string::npos);
}

TEST(PtyLink, a_path_may_be_relative) {
    const TempDir dir;
    const fs::path before = fs::current_path();
    fs::current_path(dir / "");
    {
        RunningGateway daemon{pty("app", "app")};
        const PortUser user{dir / "app"};
        EXPECT_TRUE(daemon.until_up("app"));
    }
    fs::current_path(before);
}

TEST(PtyLink, a_folder_that_cannot_be_created_is_reported) {
    const TempDir dir;
    std::ofstream{dir / "file"} << "x";
    RunningGateway daemon{pty("app", dir / "file/app")};
    EXPECT_EQ(daemon.link("app").at("state"), "waiting");
    EXPECT_EQ(daemon.link("app").at("error"), (dir / "file/app") + ": Not a directory");
}

TEST(PtyLink, is_never_up_while_its_path_cannot_be_made) {
    const TempDir dir;
    std::ofstream{dir / "file"} << "x";
    Daemon daemon{ANOGATED, dir / "control", {"pty:" + (dir / "file/app"), "sim:fc,hz=100"}};
    ASSERT_TRUE(daemon.until([&](const auto&) { return daemon.count("app", "link_down") > 50; })) << "retried some times";
    EXPECT_EQ(daemon.output().find("app: up"), std::string::npos) << daemon.output();
}

}    // namespace
}    // namespace pty_tests
