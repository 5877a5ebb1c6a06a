#include <link/tcp/host_port.hpp>

#include <gtest/gtest.h>

namespace host_port_tests {
namespace {

using anogate::HostPort;

TEST(HostPort, is_a_name_and_a_port) {
    const auto found = HostPort::parse("fc-1.local:8080");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->host, "fc-1.local");
    EXPECT_EQ(found->port, 8080);
    EXPECT_FALSE(found->literal);
}

TEST(HostPort, may_be_an_address) {
    for (const char* text : {"192.168.4.1:23", "[fe80::1%wlan0]:23", "[::1]:23"}) {
        const auto found = HostPort::parse(text);
        ASSERT_TRUE(found && found->literal) << text;
        EXPECT_EQ(found->literal->text(), text);
        EXPECT_EQ(found->port, 23);
    }
}

TEST(HostPort, is_nothing_else) {
    for (const char* text : {"", ":80", "host", "host:", "host:0", "host:65536", "host:80x", "-x:80", "a b:80", "300.1.1.1:5",
                             "1.2.3:5", "10.0.0.1:0", "::1:80", "ho$t:80"})
        EXPECT_FALSE(HostPort::parse(text)) << text;
    EXPECT_FALSE(HostPort::parse(std::string(254, 'a') + ":80"));
}

}    // namespace
}    // namespace host_port_tests
