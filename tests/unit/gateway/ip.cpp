#include <gateway/ip.hpp>

#include <gtest/gtest.h>

namespace ip_tests {

using namespace anogate;
using namespace std::string_view_literals;

TEST(IpAddress, reads_and_writes_both_families) {
    for (const auto text : {"0.0.0.0"sv, "127.0.0.1"sv, "192.168.1.20"sv, "::"sv, "::1"sv, "fe80::1%lo"sv, "2001:db8::7"sv}) {
        const auto address = IpAddress::parse(text);
        ASSERT_TRUE(address) << text;
        EXPECT_EQ(address->text(), text);
        EXPECT_EQ(address->v6, text.find(':') != text.npos) << text;
    }
}

TEST(IpAddress, refuses_everything_else) {
    for (const auto text : {""sv, "localhost"sv, "1.2.3"sv, "1.2.3.4.5"sv, "256.1.1.1"sv, "1.2.3.4%lo"sv, "fe80::1%"sv,
                            "fe80::1%no-such-interface"sv, "2001:db8::7%lo"sv, "[::1]"sv, "1.2.3.4 "sv, "1.2.3.4\0x"sv, ":"sv})
        EXPECT_FALSE(IpAddress::parse(text)) << text;
}

TEST(IpAddress, an_ipv4_address_mapped_into_ipv6_is_the_ipv4_address) {
    EXPECT_EQ(IpAddress::parse("::ffff:10.0.0.7"), IpAddress::v4(10, 0, 0, 7));
}

TEST(IpAddress, recognizes_special_addresses) {
    EXPECT_TRUE(IpAddress::parse("0.0.0.0")->is_any() && IpAddress::parse("::")->is_any());
    EXPECT_FALSE(IpAddress::parse("0.0.0.1")->is_any() || IpAddress::parse("::1")->is_any());
    EXPECT_TRUE(IpAddress::parse("127.8.8.8")->is_loopback() && IpAddress::parse("::1")->is_loopback());
    EXPECT_FALSE(IpAddress::parse("128.0.0.1")->is_loopback() || IpAddress::parse("1::1")->is_loopback());
    EXPECT_TRUE(IpAddress::parse("239.1.1.1")->is_multicast() && IpAddress::parse("ff02::1")->is_multicast());
    EXPECT_FALSE(IpAddress::parse("240.0.0.1")->is_multicast() || IpAddress::parse("fe80::1")->is_multicast());
    EXPECT_TRUE(IpAddress::parse("169.254.3.4")->is_link_local() && IpAddress::parse("fe80::1")->is_link_local());
    EXPECT_TRUE(IpAddress::parse("ff02::1")->is_link_local());
    EXPECT_FALSE(IpAddress::parse("fec0::1")->is_link_local() || IpAddress::parse("ff05::1")->is_link_local());
}

TEST(Endpoint, reads_and_writes_both_families) {
    for (const auto text : {"0.0.0.0:0"sv, "192.168.1.20:6670"sv, "[::1]:65535"sv, "[fe80::1%lo]:12333"sv}) {
        const auto endpoint = Endpoint::parse(text);
        ASSERT_TRUE(endpoint) << text;
        EXPECT_EQ(endpoint->text(), text);
    }
}

TEST(Endpoint, refuses_everything_else) {
    for (const auto text : {""sv, "1.2.3.4"sv, "1.2.3.4:"sv, "1.2.3.4:65536"sv, "1.2.3.4:-1"sv, "1.2.3.4:+1"sv, "1.2.3.4:80x"sv,
                            ":80"sv, "[1.2.3.4]:80"sv, "::1:80"sv, "[::1:80"sv, "[::1]80"sv, "[]:80"sv, "host:80"sv})
        EXPECT_FALSE(Endpoint::parse(text)) << text;
}

TEST(EndpointSpec, keeps_the_interface_by_its_name) {
    for (const auto text : {"[fe80::1%wlan9]:12333"sv, "[fe80::1%7]:1"sv, "1.2.3.4:5"sv, "[::1]:5"sv}) {
        const auto endpoint = EndpointSpec::parse(text);
        ASSERT_TRUE(endpoint) << text;
        EXPECT_EQ(endpoint->text(), text);
        EXPECT_EQ(endpoint->address.scope, 0u);
    }
    EXPECT_EQ(EndpointSpec::parse("[fe80::1%wlan9]:12333")->interface, "wlan9");
    EXPECT_EQ(*EndpointSpec::parse("[fe80::1]:1"), EndpointSpec{*Endpoint::parse("[fe80::1]:1")});
    EXPECT_NE(*EndpointSpec::parse("[fe80::1%a]:1"), *EndpointSpec::parse("[fe80::1%b]:1"));
}

TEST(EndpointSpec, refuses_invalid_interfaces) {
    for (const auto text : {"[fe80::1%]:1"sv, "[fe80::1%sixteen-bytes-no]:1"sv, "[fe80::1%a b]:1"sv, "[fe80::1%a/b]:1"sv,
                            "[fe80::1%a]"sv, "fe80::1%a:1"sv, "[2001:db8::7%lo]:1"sv, "169.254.1.1%lo:1"sv, "%]:"sv, "]:%"sv})
        EXPECT_FALSE(EndpointSpec::parse(text)) << text;
}

TEST(Network, contains_addresses_with_the_same_leading_bits) {
    const auto network = Network::parse("192.168.4.0/22").value();
    EXPECT_TRUE(network.contains(IpAddress::v4(192, 168, 4, 0)));
    EXPECT_TRUE(network.contains(IpAddress::v4(192, 168, 7, 255)));
    EXPECT_FALSE(network.contains(IpAddress::v4(192, 168, 8, 0)));
    EXPECT_FALSE(network.contains(IpAddress::v4(192, 168, 3, 255)));
    EXPECT_FALSE(network.contains(*IpAddress::parse("c0a8:400::")));
    EXPECT_TRUE(Network::parse("0.0.0.0/0")->contains(IpAddress::v4(255, 1, 2, 3)));
    EXPECT_TRUE(Network::parse("10.0.0.7")->contains(IpAddress::v4(10, 0, 0, 7)));
    EXPECT_FALSE(Network::parse("10.0.0.7")->contains(IpAddress::v4(10, 0, 0, 6)));
    EXPECT_TRUE(Network::parse("2001:db8::/33")->contains(*IpAddress::parse("2001:db8:7fff::1")));
    EXPECT_FALSE(Network::parse("2001:db8::/33")->contains(*IpAddress::parse("2001:db8:8000::1")));
    EXPECT_TRUE(Network::parse("::1/128")->contains(*IpAddress::parse("::1")));
}

TEST(Network, refuses_everything_else) {
    for (const auto text :
         {""sv, "/8"sv, "10.0.0.0/"sv, "10.0.0.0/33"sv, "10.0.0.0/-1"sv, "::/129"sv, "10/8"sv, "10.0.0.0/8/8"sv})
        EXPECT_FALSE(Network::parse(text)) << text;
}

TEST(Network, a_list_contains_an_address_if_one_of_its_networks_does) {
    const std::vector<Network> networks{*Network::parse("10.0.0.0/8"), *Network::parse("127.0.0.0/8")};
    EXPECT_TRUE(contains(networks, IpAddress::v4(127, 0, 0, 1)));
    EXPECT_FALSE(contains(networks, IpAddress::v4(11, 0, 0, 1)));
    EXPECT_FALSE(contains({}, IpAddress::v4(11, 0, 0, 1)));
}

}    // namespace ip_tests
