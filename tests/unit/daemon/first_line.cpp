#include <config/config.hpp>
#include <daemon/first_line.hpp>
#include <link/kinds.hpp>

#include <gtest/gtest.h>

namespace anogate::first_line_tests {
namespace {

using namespace std::chrono_literals;

std::vector<Network> networks(std::initializer_list<const char*> texts) {
    std::vector<Network> all;
    for (const char* text : texts) all.push_back(Network::parse(text).value());
    return all;
}

/// The line without the version at its beginning.
std::string said(std::initializer_list<std::string_view> links, const std::vector<Network>& own = {}) {
    Draft draft{link_kinds()};
    for (const std::string_view link : links) read_link(link, "", draft);
    validate(draft);
    EXPECT_TRUE(draft.errors.empty()) << lines(draft.errors);
    const std::string line = first_line(draft.settings, "my.json", own);
    EXPECT_TRUE(line.starts_with("anogated ")) << line;
    return line.substr(line.find(", ") + 2);
}

TEST(FirstLine, has_the_configuration_and_the_number_of_links) {
    EXPECT_EQ(said({"sim:fc"}), "my.json, 1 link");
    EXPECT_EQ(said({"sim:fc", "serial:/dev/ttyUSB0"}), "my.json, 2 links");
}

TEST(FirstLine, shows_the_address_to_enter_in_a_ground_station) {
    const auto own = networks({"127.0.0.1/8", "192.168.1.20/24", "10.0.0.2/8", "::1/128", "fe80::1/64", "2001:db8::5/64"});
    EXPECT_EQ(said({"udp-listen:0.0.0.0:12333,name=ground"}, own),
              "my.json, 1 link; ground, for ground stations: UDP 192.168.1.20:12333 or 10.0.0.2:12333");
    EXPECT_EQ(said({"udp-listen:[::]:9,name=ground"}, own),
              "my.json, 1 link; ground, for ground stations: UDP 192.168.1.20:9 or 10.0.0.2:9 or [2001:db8::5]:9");
    EXPECT_EQ(said({"udp-listen:10.0.0.2:7,name=a", "udp-listen:127.0.0.1:8,name=b"}, own),
              "my.json, 2 links; a, for ground stations: UDP 10.0.0.2:7; b, for ground stations: UDP 127.0.0.1:8 (from this "
              "computer only)");
}

TEST(FirstLine, proposes_no_port_of_protocol_v7_for_ground_stations) {
    EXPECT_EQ(said({"udp-listen:10.0.0.2:7,name=a,protocol=v7,v7_device=0xDD"}), "my.json, 1 link; a: UDP 10.0.0.2:7");
}

TEST(FirstLine, reports_that_there_is_no_address_yet) {
    EXPECT_EQ(said({"udp-listen:0.0.0.0:12333,name=g"}, networks({"127.0.0.1/8"})),
              "my.json, 1 link; g, for ground stations: UDP port 12333 of this computer, which has no network address yet");
    EXPECT_EQ(said({"udp-listen:0.0.0.0:0,name=g"}),
              "my.json, 1 link; g, for ground stations: UDP a port chosen by the system (see the status)");
}

TEST(FirstLine, is_short_when_there_are_many_networks) {
    EXPECT_EQ(said({"udp-listen:0.0.0.0:1,name=g"},
                   networks({"10.0.0.1/24", "10.0.1.1/24", "10.0.2.1/24", "10.0.3.1/24", "10.0.4.1/24"})),
              "my.json, 1 link; g, for ground stations: UDP 10.0.0.1:1 or 10.0.1.1:1 or 10.0.2.1:1 or 10.0.3.1:1 ...");
}

TEST(LastLine, has_the_cause_the_time_and_the_frames) {
    EXPECT_EQ(last_line("SIGTERM", 59'999ms, 1, 0), "stopping (SIGTERM) after 59 s, 1 frame in, 0 out");
    EXPECT_EQ(last_line("SIGINT", 61s, 20, 3), "stopping (SIGINT) after 1 min 1 s, 20 frames in, 3 out");
    EXPECT_EQ(last_line("x", 1h, 0, 3), "stopping (x) after 1 h 0 min, 0 frames in, 3 out");
    EXPECT_EQ(last_line("x", 26h + 3min, 0, 3), "stopping (x) after 26 h 3 min, 0 frames in, 3 out");
}

}    // namespace
}    // namespace anogate::first_line_tests
