#include <gtest/gtest.h>

#include <csignal>
#include <string>

#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>

namespace anoctl_ports_tests {
namespace {

TEST(AnoctlPorts, names_the_gateway_that_uses_a_port_and_shows_what_to_do) {
    const support::TempDir folder;
    const support::PtyDevice device{(folder.path() / "tty").string()};
    support::Daemon gateway{ANOGATED, (folder.path() / "socket").string(), {"serial:" + device.path() + ",name=fc"}};
    ASSERT_TRUE(gateway.until_up("fc"));
    support::Process detection{ANOCTL, {"ports", "--detect", device.path()}};
    EXPECT_EQ(detection.wait(), 1);
    EXPECT_NE(detection.output().find(" is in use by anogated (pid " + std::to_string(gateway.pid()) +
                                      "); its status shows whether it receives frames. To detect the rate, stop it first"),
              std::string::npos)
        << detection.output();
}

TEST(AnoctlPorts, detection_ends_at_once_when_it_is_interrupted) {
    const support::TempDir folder;
    const support::PtyDevice device{(folder.path() / "tty").string()};
    support::Process detection{ANOCTL, {"ports", "--detect", device.path()}};
    ASSERT_TRUE(support::wait_until([&] { return (device.settings().c_lflag & ICANON) == 0; })) << "it has not begun";
    detection.signal(SIGINT);
    EXPECT_EQ(detection.wait(), 1);
    EXPECT_NE(detection.output().find("interrupted: no frames found up to 500000 baud"), std::string::npos) << detection.output();
}

TEST(AnoctlPorts, are_listed_on_this_machine) {
    support::Process people{ANOCTL, {"ports"}}, programs{ANOCTL, {"ports", "--json"}};
    EXPECT_EQ(people.wait(), 0) << people.output();
    EXPECT_EQ(programs.wait(), 0) << programs.output();
    for (std::size_t at = 0, end; (end = programs.output().find('\n', at)) != std::string::npos; at = end + 1)
        EXPECT_TRUE(nlohmann::json::accept(programs.output().substr(at, end - at))) << programs.output();
}

}    // namespace
}    // namespace anoctl_ports_tests
