#include <control/control_listeners.hpp>

#include <gtest/gtest.h>

namespace anogate::control_listeners_tests {
namespace {

TEST(ControlListeners, requires_no_token_on_loopback_from_the_user_who_started_it) {
    for (const std::string here : {"127.0.0.1", "127.1.2.3", "::1"}) {
        EXPECT_FALSE(network_needs_token(here, 1000)) << here;
        EXPECT_TRUE(network_needs_token(here, 999)) << here << ", as a service";
        EXPECT_TRUE(network_needs_token(here, 0)) << here << ", as root";
    }
    for (const std::string elsewhere : {"0.0.0.0", "::", "192.168.1.5", "fe80::1%lo", "128.0.0.1"})
        EXPECT_TRUE(network_needs_token(elsewhere, 1000)) << elsewhere;
}

}    // namespace
}    // namespace anogate::control_listeners_tests
