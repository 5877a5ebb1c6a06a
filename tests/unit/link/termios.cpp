#include <link/serial/termios.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <stdlib.h>

#include <string>

namespace termios_tests {
namespace {

using anogate::UniqueFd;
using anogate::terminal::is_port_at;

// A name in /proc leads to an unplugged port, like the name of an adapter leads to the next one with the same number.
TEST(Termios, an_unplugged_port_is_no_longer_found_at_its_name) {
    UniqueFd device{::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)};
    char name[64];
    ASSERT_TRUE(::grantpt(device.get()) == 0 && ::unlockpt(device.get()) == 0 &&
                ::ptsname_r(device.get(), name, sizeof name) == 0);
    const UniqueFd port{::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC)};
    const std::string path = "/proc/self/fd/" + std::to_string(port.get());
    EXPECT_TRUE(is_port_at(port.get(), name));
    EXPECT_TRUE(is_port_at(port.get(), path));
    device = {};
    EXPECT_FALSE(is_port_at(port.get(), path));
}

}    // namespace
}    // namespace termios_tests
