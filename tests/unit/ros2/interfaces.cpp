#include <ros2/interfaces.hpp>

#include <gtest/gtest.h>

namespace interfaces_tests {
namespace {

using namespace anogate;
using Addresses = std::set<InterfaceAddress>;

TEST(Interfaces, a_new_address_has_to_be_announced_and_one_that_is_gone_may_return) {
    const Addresses joined{{1, "127.0.0.1"}, {2, "10.0.0.5"}};
    EXPECT_FALSE(must_rejoin(joined, joined));
    EXPECT_FALSE(must_rejoin(joined, {{1, "127.0.0.1"}}));
    EXPECT_FALSE(must_rejoin(joined, {}));
    EXPECT_TRUE(must_rejoin(joined, {{1, "127.0.0.1"}, {2, "10.0.0.6"}}));
    EXPECT_TRUE(must_rejoin(joined, {{1, "127.0.0.1"}, {3, "10.0.0.5"}}));    // another adapter with the same address
    EXPECT_TRUE(must_rejoin({}, joined));
}

TEST(Interfaces, only_those_that_are_named) {
    EXPECT_FALSE(interface_addresses({}).empty());
    EXPECT_EQ(interface_addresses({"lo"}).size(), 1u);
    EXPECT_TRUE(interface_addresses({"nonexistent0"}).empty());
}

}    // namespace
}    // namespace interfaces_tests
