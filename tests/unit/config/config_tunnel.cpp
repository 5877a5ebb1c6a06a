// The tunnel in a configuration.
#include <config/check_network.hpp>
#include <gateway/tunnel/tunnel_policy.hpp>
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_tunnel_tests {
namespace {

TEST(Config, a_tunnel_has_defaults_and_exists_only_with_its_key) {
    EXPECT_FALSE(settings_of("{}").tunnel);
    EXPECT_EQ(settings_of(R"({"tunnel": {}})").tunnel, TunnelSettings{});
    const TunnelSettings t;
    EXPECT_EQ(t.address, 0xE6);
    EXPECT_EQ(t.port, 12333);
    EXPECT_TRUE(t.bind.is_any() && !t.ip && t.deliver == Deliver::frames);
}

TEST(Config, a_tunnel_is_read_as_it_is_written) {
    const TunnelSettings t = *settings_of(R"({"links": ["serial:/dev/fc"], "tunnel": {"links": ["fc"], "address": "0xE7",
        "bind": "192.168.0.5", "port": 5, "ip": "203.0.113.9", "deliver": "tunnel", "allow": ["192.168.0.0/24", "127.0.0.0/8"],
        "wrap": [{"from": "192.168.0.0/24", "link": "fc", "as": "ip_tunnel_short", "source": 7, "to": "0xDC"}]}})")
                                  .tunnel;
    TunnelSettings expected;
    expected.links = {"fc"};
    expected.address = 0xE7;
    expected.bind = *IpAddress::parse("192.168.0.5");
    expected.port = 5;
    expected.ip = IpAddress::parse("203.0.113.9");
    expected.deliver = Deliver::tunnel;
    expected.allow = {*Network::parse("192.168.0.0/24"), *Network::parse("127.0.0.0/8")};
    expected.wrap = {{*Network::parse("192.168.0.0/24"), "fc", 0xB2, 7, 0xDC}};
    EXPECT_EQ(t, expected);
}

TEST(Config, a_tunnel_may_name_hosts) {
    const std::string text = R"({"links": ["serial:/dev/fc"], "tunnel": {"links": ["fc"], "ip": "gw.example.org",
        "allow": ["ground.local", "10.0.0.0/8"], "wrap": [{"from": "radio", "link": "fc"}]}})";
    const TunnelSettings t = *settings_of(text).tunnel;
    EXPECT_EQ(t.ip_host, "gw.example.org");
    EXPECT_FALSE(t.ip);
    EXPECT_EQ(t.allow, std::vector{*Network::parse("10.0.0.0/8")});
    EXPECT_EQ(t.allow_hosts, std::vector<std::string>{"ground.local"});
    EXPECT_EQ(t.wrap.at(0).from_host, "radio");
    EXPECT_EQ(settings_of(print_config(settings_of(text))).tunnel, t) << "it is printed as it was read";
    EXPECT_NE(faults_in(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"], "allow": ["192.168.0"]}})"), "")
        << "digits and dots are a mistyped address";
}

// For links whose peers are in the network, and for other links.
TEST(Config, a_tunnel_relays_the_network_to_local_programs_only_if_configured) {
    const auto faults = [](const std::string& link, const std::string& allow, const std::string& more = {}) {
        return faults_in("{\"links\": [\"" + link +
                         ",name=g\", \"sim:fc\"], \"tunnel\": {\"links\": [\"fc\", \"g\"], \"port\": 1, \"allow\": [" + allow +
                         "]" + more + "}}");
    };
    const std::string open = "udp-listen:0.0.0.0:12333";
    EXPECT_EQ(faults(open, R"("10.0.0.0/8", "127.0.0.0/8")"),
              "/tunnel/allow: 'allow' lists 127.0.0.0/8, which is this computer, and 'links' includes 'g': its network peers "
              "could reach local programs through tunnel frames; remove one of them, or set \"relay\": true to allow it\n");
    for (const char* link : {"udp-listen:192.168.1.5:12333", "udp-listen:[::]:12333", "udp:192.168.1.20:6670"})
        EXPECT_NE(faults(link, R"("127.0.0.1/32")"), "") << link;
    EXPECT_EQ(faults(open, R"("127.0.0.0/8")", R"(, "relay": true)"), "");
    EXPECT_NE(faults(open, R"("127.0.0.0/8")", R"(, "relay": false)"), "");
    EXPECT_EQ(faults(open, R"("10.0.0.0/8")"), "");
    for (const char* link : {"serial:/dev/ttyUSB0", "pty:/run/x", "can:can0", "udp-listen:127.0.0.1:12333", "udp:127.0.0.1:6670"})
        EXPECT_EQ(faults(link, R"("127.0.0.0/8")"), "") << link << " has no peers in the network";
    EXPECT_EQ(
        faults_in(
            R"({"links": ["udp-listen:0.0.0.0:1,name=g", "sim:fc"], "tunnel": {"links": ["fc"], "allow": ["127.0.0.0/8"]}})"),
        "")
        << "its tunnel frames are not carried";
}

TEST(Config, a_check_also_considers_the_addresses_of_this_computer) {
    const auto faults = [](const std::string& allow, const std::string& relay = "false") {
        Draft draft = parse_config(R"({"links": ["udp-listen:0.0.0.0:1,name=g"], "tunnel": {"links": ["g"], "allow": [")" +
                                   allow + R"("], "relay": )" + relay + "}}");
        EXPECT_TRUE(draft.errors.empty());
        check_relay(draft, {*Network::parse("127.0.0.1/8"), *Network::parse("192.168.1.5/24")});
        return draft.errors.size();
    };
    EXPECT_EQ(faults("192.168.1.5/32"), 1u);
    EXPECT_EQ(faults("192.168.1.5/32", "true"), 0u);
    EXPECT_EQ(faults("192.168.1.0/24"), 0u) << "an own address counts only when it is listed by itself";
    EXPECT_EQ(faults("192.168.1.6/32"), 0u);
}

TEST(Config, errors_in_a_tunnel_name_their_location) {
    EXPECT_EQ(
        faults_in(R"({"links": ["serial:/dev/fc", "udp-listen:0.0.0.0:12333,name=g"], "tunnel": {"links": ["fd"], "bind": "::",
        "ip": "0.0.0.0", "delivers": "x", "allow": ["::1/128"], "wrap": [{"from": "192.168.0", "as": "ip", "link": "tunnel"}, 5]}})"),
        "/tunnel/allow: 'allow' must be any, or networks such as 192.168.0.0/24 and host names such as ground.local, not "
        "'::1/128'\n"
        "/tunnel/bind: 'bind' must be an IPv4 address such as 192.168.0.5, not '::'\n"
        "/tunnel/delivers: unknown key 'delivers' (did you mean 'deliver'?)\n"
        "/tunnel/ip: 'ip' must be an IPv4 address such as 192.168.0.5, a host name such as gateway.example.org or auto, not "
        "'0.0.0.0'\n"
        "/tunnel/wrap/0/as: 'as' must be one of ip_tunnel, ip_tunnel_short, not 'ip'\n"
        "/tunnel/wrap/0/from: 'from' must be an IPv4 network such as 192.168.0.0/24, or a host name such as ground.local, not "
        "'192.168.0'\n"
        "/tunnel/wrap/1: must be an object {...} of from, link, as, source, to, not 5\n"
        "/tunnel/links/0: there is no link 'fd' (did you mean 'fc'?); use one of fc, g\n"
        "/tunnel/wrap/0/link: there is no link 'tunnel'; use one of fc, g\n"
        "/tunnel/port: local port 12333 is already used by 'g' (/links/1: LINK 'udp-listen:0.0.0.0:12333,name=g')\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc,name=tunnel"], "tunnel": 5})"),
              "/tunnel: must be an object {...}, not 5\n/links/0: LINK 'sim:fc,name=tunnel': 'name' can't be 'tunnel', a "
              "reserved word\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {}, "routes": [{"address": 5, "link": "tunnel"}]})"), "");
}

}    // namespace
}    // namespace anogate::config_tunnel_tests
