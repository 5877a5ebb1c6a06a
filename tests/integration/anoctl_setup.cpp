// anoctl setup: port, rate, configuration and service, checked by the commands that it runs. tools/packaging/upgrade runs it with
// a real systemd, tests/vm/serial.cpp with real serial drivers.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <support/files.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/signing_browser.hpp>
#include <support/temp_dir.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace anoctl_setup_tests {
namespace {

using namespace support;
using nlohmann::json;

class AnoctlSetup : public testing::Test {
protected:
    AnoctlSetup() {
        const std::string program = dir.write("systemctl", "#!/bin/sh\necho \"systemctl $*\"\n");
        std::filesystem::permissions(program, std::filesystem::perms{0700});
    }
    struct Result {
        int exit;
        std::string printed;
    };
    Result setup(std::vector<std::string> words) const {
        words.insert(words.begin(), {"setup", "--into", config});
        Process process{ANOCTL, std::move(words), {"PATH=" + dir.path().string(), "DISPLAY=", "WAYLAND_DISPLAY="}};
        const int exit = process.wait();
        return {exit, process.output()};
    }
    json written() const { return json::parse(file_text(config), nullptr, true, true); }

    TempDir dir;
    std::string config = dir / "anogate.json";
    PtyDevice device{dir / "tty"};
};

TEST_F(AnoctlSetup, writes_a_configuration_that_the_gateway_accepts_and_starts_the_service) {
    const Result done = setup({device.path(), "--baud", "115200", "--yes"});
    ASSERT_EQ(done.exit, 0) << done.printed;
    EXPECT_NE(done.printed.find("systemctl enable anogated\nsystemctl restart anogated\n"), std::string::npos) << done.printed;
    EXPECT_NE(done.printed.find("http://127.0.0.1:8088/"), std::string::npos) << done.printed;
    const json fc = written().at("links").at(0);
    EXPECT_EQ(fc.at("device"), device.path());
    EXPECT_EQ(fc.at("baud"), 115200);
    EXPECT_EQ(fc.at("profile"), "vendor");
    Process check{ANOGATED, {"--check", "--config", config}};
    EXPECT_EQ(check.wait(), 0) << check.output();
    EXPECT_EQ(std::filesystem::status(config).permissions(), std::filesystem::perms{0644}) << "others may read it";
}

TEST_F(AnoctlSetup, opens_the_page_signed_in) {
    const std::string socket = dir / "control.sock";
    Daemon service{
        ANOGATED, socket, {"udp-listen:127.0.0.1:0", "--http", "0.0.0.0:0"}, {"STATE_DIRECTORY=" + dir.path().string()}};
    ASSERT_TRUE(service.until_answers()) << service.output();
    write_signing_browser(dir, service.status().at("http").at("port"));
    Process process{
        ANOCTL,
        {"setup", "--into", config, "--control", socket, device.path(), "--baud", "115200", "--yes"},
        {"PATH=" + dir.path().string() + ":/usr/bin:/bin", "DISPLAY=:0", "SUDO_USER=", "HOME=" + dir.path().string()}};
    EXPECT_EQ(process.wait(), 0) << process.output();
    EXPECT_NE(process.output().find("leads to http://127.0.0.1:8088/\n{\"access\": \"control\"}"), std::string::npos)
        << process.output();
}

TEST_F(AnoctlSetup, opens_nothing_where_there_is_no_screen) {
    const Result done = setup({device.path(), "--baud", "115200", "--yes"});    // DISPLAY is set, but empty
    ASSERT_EQ(done.exit, 0) << done.printed;
    EXPECT_EQ(done.printed.find("does not serve the page"), std::string::npos) << done.printed;
}

TEST_F(AnoctlSetup, keeps_a_copy_of_the_previous_configuration) {
    dir.write("anogate.json", "{\"links\": [\"sim:fc\"]}");
    ASSERT_EQ(setup({device.path(), "--baud", "115200", "--yes"}).exit, 0);
    EXPECT_EQ(file_text(config + ".old"), "{\"links\": [\"sim:fc\"]}");
    EXPECT_EQ(written().at("links").at(0).at("device"), device.path());
}

TEST_F(AnoctlSetup, detects_the_rate_from_received_frames) {
    Process process{ANOCTL, {"setup", "--into", config, device.path(), "--yes"}, {"PATH=" + dir.path().string(), "DISPLAY="}};
    const std::vector<std::uint8_t> frame{0xAB, 0xFE, 0xFF, 0x03, 0x00, 0x00, 0xAB, 0xFD};
    ASSERT_TRUE(wait_until([&] {
        device.write(frame);
        return process.output().find("systemctl restart") != std::string::npos;
    })) << process.output();
    EXPECT_EQ(process.wait(), 0);
    EXPECT_NE(process.output().find(": 500000 baud\n"), std::string::npos) << process.output();
    EXPECT_EQ(written().at("links").at(0).at("baud"), 500000) << "the first rate: a pseudo-terminal has none";
}

TEST_F(AnoctlSetup, changes_nothing_when_it_cannot_ask_for_confirmation) {
    const Result refused = setup({device.path()});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_NE(refused.printed.find("use --yes"), std::string::npos) << refused.printed;
    EXPECT_FALSE(std::filesystem::exists(config));
}

TEST_F(AnoctlSetup, shows_how_to_find_out_why_the_service_does_not_start) {
    dir.write("systemctl", "#!/bin/sh\nexit 1\n");
    const Result failed = setup({device.path(), "--baud", "115200", "--yes"});
    EXPECT_EQ(failed.exit, 1);
    EXPECT_NE(failed.printed.find("systemctl enable failed; for the reason: journalctl -u anogated"), std::string::npos)
        << failed.printed;
}

}    // namespace
}    // namespace anoctl_setup_tests
