#include <gateway/host_spec.hpp>

#include <gtest/gtest.h>

namespace host_spec_tests {

using namespace anogate;

TEST(HostSpec, is_an_address_or_a_name_with_a_port) {
    const auto name = HostSpec::parse("flow-2.local:8888");
    ASSERT_TRUE(name);
    EXPECT_EQ(name->host, "flow-2.local");
    EXPECT_EQ(name->port, 8888);
    EXPECT_EQ(name->text(), "flow-2.local:8888");
    const auto address = HostSpec::parse("192.168.4.1:23");
    ASSERT_TRUE(address);
    EXPECT_TRUE(address->host.empty());
    EXPECT_EQ(address->address, IpAddress::v4(192, 168, 4, 1));
    EXPECT_EQ(address->text(), "192.168.4.1:23");
    EXPECT_EQ(HostSpec::parse("[fe80::1%wlan0]:23")->interface, "wlan0");
    EXPECT_NE(*name, *address);
}

TEST(HostSpec, upper_and_lower_case_and_a_final_dot_are_the_same_name) {
    EXPECT_EQ(HostSpec::parse("Flow.local:1"), HostSpec::parse("flow.LOCAL.:1"));
    EXPECT_NE(HostSpec::parse("flow.local:1"), HostSpec::parse("flow.local:2"));
    EXPECT_NE(HostSpec::parse("flow.local:1"), HostSpec::parse("flow:1"));
    EXPECT_TRUE(HostSpec::parse("LocalHost.:1")->is_here());
}

TEST(HostSpec, rejects_invalid_hosts_and_ports) {
    for (const char* text : {"",      ":1",     "a",    "a:",    "a:b",   "a:65536",     "a:1:2",           "-a:1",
                             "a-:1",  "a..b:1", ".a:1", "a b:1", "a/b:1", "192.168.4:1", "192.168.4.256:1", "fe80::1:1",
                             "[a]:1", "a:-1",   "a:+1", "a: 1"})
        EXPECT_FALSE(HostSpec::parse(text)) << text;
    EXPECT_FALSE(HostSpec::parse(std::string(64, 'a') + ":1"));
    EXPECT_TRUE(HostSpec::parse(std::string(63, 'a') + ":1"));
    std::string many;
    while (many.size() < 254) many += "abc.";
    EXPECT_FALSE(HostSpec::parse(many + "d:1"));
}

TEST(HostSpec, recognizes_addresses_of_this_computer) {
    EXPECT_TRUE(HostSpec::parse("localhost:1")->is_here());
    EXPECT_TRUE(HostSpec::parse("127.0.0.2:1")->is_here());
    EXPECT_TRUE(HostSpec::parse("[::1]:1")->is_here());
    EXPECT_FALSE(HostSpec::parse("flow:1")->is_here());
}

}    // namespace host_spec_tests
