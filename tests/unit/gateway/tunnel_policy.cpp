#include <gateway/tunnel/tunnel_policy.hpp>

#include <gtest/gtest.h>

namespace tunnel_policy_tests {
namespace {

using anogate::IpAddress;
using anogate::Network;

IpAddress ip(const char* text) { return *IpAddress::parse(text); }

anogate::TunnelPolicy policy(std::initializer_list<const char*> allow = {}) {
    anogate::TunnelSettings settings;
    for (const char* network : allow) settings.allow.push_back(*Network::parse(network));
    anogate::TunnelPolicy policy{settings};
    policy.set_networks({*Network::parse("127.0.0.1/8"), *Network::parse("192.168.0.5/24"), *Network::parse("10.1.2.3/16"),
                         *Network::parse("10.9.0.1/32"), *Network::parse("::1/128"), *Network::parse("fe80::5/64")});
    return policy;
}

TEST(TunnelPolicy, a_host_name_allows_only_those_of_its_addresses_that_are_ordinary_hosts) {
    anogate::TunnelSettings settings;
    settings.allow_hosts = {"ground.local"};
    anogate::TunnelPolicy policy{settings};
    policy.set_networks({*Network::parse("127.0.0.1/8"), *Network::parse("192.168.0.5/24")});
    EXPECT_FALSE(policy.allows(ip("192.168.0.7"))) << "not even our networks, before the name is found";
    policy.set_hosts(
        {ip("192.168.0.7"), ip("127.0.0.1"), ip("192.168.0.5"), ip("192.168.0.255"), ip("224.0.0.1"), ip("fd00::1")});
    EXPECT_TRUE(policy.allows(ip("192.168.0.7")));
    for (const char* other : {"192.168.0.8", "127.0.0.1", "192.168.0.5", "192.168.0.255", "224.0.0.1", "fd00::1"})
        EXPECT_FALSE(policy.allows(ip(other))) << other;
}

TEST(TunnelPolicy, hosts_on_local_networks_are_allowed_when_nothing_is_listed) {
    EXPECT_TRUE(policy().allows(ip("192.168.0.1")));
    EXPECT_TRUE(policy().allows(ip("192.168.0.254")));
    EXPECT_TRUE(policy().allows(ip("10.1.200.7")));
    EXPECT_FALSE(policy().allows(ip("192.168.1.1")));
    EXPECT_FALSE(policy().allows(ip("8.8.8.8")));
    EXPECT_FALSE(policy().allows(ip("10.2.0.1")));
}

TEST(TunnelPolicy, listed_networks_replace_the_local_networks) {
    EXPECT_TRUE(policy({"172.16.0.0/12"}).allows(ip("172.20.1.1")));
    EXPECT_FALSE(policy({"172.16.0.0/12"}).allows(ip("192.168.0.1")));
    EXPECT_TRUE(policy({"8.8.8.8"}).allows(ip("8.8.8.8")));
    EXPECT_FALSE(policy({"8.8.8.8"}).allows(ip("8.8.8.9")));
}

// Addresses of this machine, of many hosts, or of none.
const char* const not_ordinary[] = {"127.0.0.1",     "127.255.0.1", "224.0.0.1",    "239.255.255.250", "255.255.255.255",
                                    "192.168.0.255", "192.168.0.0", "10.1.255.255", "10.1.0.0",        "0.0.0.0",
                                    "0.1.2.3",       "192.168.0.5", "10.1.2.3",     "10.9.0.1",        "240.0.0.1",
                                    "::1",           "fe80::6",     "ff02::1",      "2001:db8::1"};

TEST(TunnelPolicy, addresses_that_are_no_ordinary_host_are_rejected) {
    for (const char* address : not_ordinary) EXPECT_FALSE(policy().allows(ip(address))) << address;
}

TEST(TunnelPolicy, a_wide_network_allows_ordinary_hosts_only) {
    for (const char* address : not_ordinary)
        EXPECT_FALSE(policy({"0.0.0.0/0", "128.0.0.0/1", "::/0"}).allows(ip(address))) << address;
    EXPECT_TRUE(policy({"0.0.0.0/0"}).allows(ip("8.8.8.8")));
    EXPECT_FALSE(policy({"192.168.0.0/24"}).allows(ip("192.168.0.255"))) << "broadcast";
    EXPECT_FALSE(policy({"192.168.0.0/24"}).allows(ip("192.168.0.5"))) << "ourselves";
    EXPECT_FALSE(policy({"192.168.0.255/24"}).allows(ip("192.168.0.255"))) << "the network by another of its names";
    EXPECT_FALSE(policy({"127.0.0.1/1"}).allows(ip("127.0.0.1")));
    EXPECT_FALSE(policy({"224.0.0.0/3"}).allows(ip("224.0.0.1")));
}

TEST(TunnelPolicy, special_addresses_are_allowed_when_they_are_listed_explicitly) {
    EXPECT_TRUE(policy({"127.0.0.0/8"}).allows(ip("127.0.0.1")));
    EXPECT_TRUE(policy({"127.0.0.1"}).allows(ip("127.0.0.1")));
    EXPECT_FALSE(policy({"127.0.0.1"}).allows(ip("127.0.0.2")));
    EXPECT_TRUE(policy({"239.0.0.0/8"}).allows(ip("239.1.2.3")));
    EXPECT_TRUE(policy({"192.168.0.255"}).allows(ip("192.168.0.255")));
    EXPECT_TRUE(policy({"255.255.255.255"}).allows(ip("255.255.255.255")));
    EXPECT_TRUE(policy({"192.168.0.5"}).allows(ip("192.168.0.5")));
    EXPECT_FALSE(policy({"0.0.0.0"}).allows(ip("0.0.0.0"))) << "on Linux a way to this machine";
    EXPECT_FALSE(policy({"240.0.0.1"}).allows(ip("240.0.0.1")));
}

TEST(TunnelPolicy, reports_that_this_computer_is_listed_exactly_if_it_is_allowed) {
    const std::vector<Network> own{*Network::parse("192.168.0.5/24"), *Network::parse("127.0.0.1/8")};
    for (const char* network : {"0.0.0.0/0", "127.0.0.1/7", "127.0.0.0/8", "127.0.0.1", "127.0.0.1/31", "192.168.0.5",
                                "192.168.0.5/31", "192.168.0.0/24", "192.168.0.6", "10.0.0.0/8"}) {
        const std::vector<Network> allow{*Network::parse(network)};
        EXPECT_EQ(anogate::listed_loopback(allow) != nullptr, policy({network}).allows(ip("127.0.0.1"))) << network;
        EXPECT_EQ(anogate::listed_own(allow, own) != nullptr, policy({network}).allows(ip("192.168.0.5"))) << network;
    }
}

TEST(TunnelPolicy, own_addresses_are_those_of_the_interfaces) {
    EXPECT_TRUE(policy().is_own(ip("192.168.0.5")));
    EXPECT_TRUE(policy().is_own(ip("10.1.2.3")));
    EXPECT_TRUE(policy().is_own(ip("127.0.0.9")));
    EXPECT_FALSE(policy().is_own(ip("192.168.0.6")));
    auto moved = policy();
    moved.set_networks({*Network::parse("192.168.7.1/24")});
    EXPECT_FALSE(moved.is_own(ip("192.168.0.5")));
    EXPECT_FALSE(moved.allows(ip("192.168.0.6")));
    EXPECT_TRUE(moved.allows(ip("192.168.7.2")));
}

}    // namespace
}    // namespace tunnel_policy_tests
