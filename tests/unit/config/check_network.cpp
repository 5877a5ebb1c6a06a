// Links whose peer is this gateway, by a name or an address that only the machine knows.
#include <config/check_network.hpp>
#include <config/hosts_file.hpp>
#include <support/temp_dir.hpp>
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

namespace anogate::check_network_tests {
namespace {

std::string faults_on_machine(std::initializer_list<std::string_view> links, const HostAddresses& names,
                              const std::vector<Network>& own = {}) {
    Draft draft{link_kinds()};
    for (const std::string_view link : links) read_link(link, "", draft);
    validate(draft);
    const std::size_t before = draft.errors.size();
    check_peers(draft, names, own);
    std::string text;
    for (std::size_t i = before; i < draft.errors.size(); ++i) text += draft.errors[i].where + ": " + draft.errors[i].what + "\n";
    return text;
}

TEST(HostsFile, has_an_address_and_its_names_per_line) {
    const HostAddresses names = names_in_hosts(
        "# 1.2.3.4 comment\n127.0.1.1\tVehicle vehicle.local # alias\n\n  ::1 twice \r\n10.0.0.1 twice\nwords twice\n10.0.0.9\n"
        "10.0.0.2 last");
    EXPECT_EQ(names.size(), 4u);
    EXPECT_EQ(names.at("vehicle"), (std::vector<IpAddress>{IpAddress::v4(127, 0, 1, 1)}));
    EXPECT_EQ(names.at("vehicle.local"), names.at("vehicle"));
    EXPECT_EQ(names.at("twice"), (std::vector<IpAddress>{*IpAddress::parse("::1"), IpAddress::v4(10, 0, 0, 1)}));
    EXPECT_EQ(names.at("last").size(), 1u);
    EXPECT_TRUE(names_in_hosts("").empty());
    EXPECT_TRUE(read_hosts_file("/proc/nonexistent").empty());
    EXPECT_TRUE(read_hosts_file("/dev/zero").empty());
    const support::TempDir folder;
    EXPECT_EQ(read_hosts_file(folder.write("hosts", "10.0.0.1 a\n")).size(), 1u);
}

TEST(CheckPeers, knows_the_names_of_the_hosts_file) {
    const HostAddresses names = names_in_hosts("127.0.1.1 vehicle\n10.0.0.1 own\n10.0.0.2 far\n10.0.0.2 both\n127.0.0.1 both\n");
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5,name=port", "udp:Vehicle:5,name=loop"}, names),
              "LINK 'udp:Vehicle:5,name=loop': 'Vehicle:5' is this gateway itself: 'port' (LINK "
              "'udp-listen:0.0.0.0:5,name=port') listens there\n");
    EXPECT_NE(faults_on_machine({"tcp-listen:0.0.0.0:5", "tcp:vehicle:5"}, names), "");
    EXPECT_NE(faults_on_machine({"udp-listen:10.0.0.1:5", "udp:own:5"}, names), "");
    EXPECT_EQ(faults_on_machine({"udp-listen:127.0.0.1:5", "udp:vehicle:5"}, names), "") << "127.0.1.1 is another address";
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5", "udp:far:5", "udp:unknown:5,name=u", "udp:vehicle:6"}, names), "");
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5", "tcp:vehicle:5"}, names), "");
}

TEST(CheckPeers, knows_the_addresses_of_the_interfaces) {
    const HostAddresses names = names_in_hosts("192.168.1.5 vehicle\n");
    const std::vector<Network> own{*Network::parse("127.0.0.1/8"), *Network::parse("192.168.1.5/24")};
    for (const char* itself : {"udp:vehicle:5", "udp:192.168.1.5:5"})
        EXPECT_NE(faults_on_machine({"udp-listen:0.0.0.0:5", itself}, names, own), "") << itself;
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5", "udp:192.168.1.6:5"}, names, own), "");
    EXPECT_EQ(faults_on_machine({"udp-listen:127.0.0.1:5", "udp:vehicle:5"}, names, own), "");
}

TEST(CheckPeers, regards_only_a_certain_match_as_this_gateway) {
    const HostAddresses names = names_in_hosts(
        "127.0.0.1 localhost\n::1 ip6-localhost six\n127.0.0.1 twice\n::1 twice\n127.0.0.1 both\n10.0.0.2 both\nfd00::5 own-six\n"
        "fd00::9 mixed\n127.0.0.1 mixed\n");
    const std::vector<Network> own{*Network::parse("192.168.1.5/24"), *Network::parse("fd00::5/64")};
    struct Row {
        const char *port, *link;
        bool is_fault;
    };
    const Row rows[] = {
        {"udp-listen:0.0.0.0:5", "udp:ip6-localhost:5", false},
        {"tcp-listen:0.0.0.0:5", "tcp:six:5", false},
        {"tcp-listen:[::]:5", "tcp:six:5", true},
        {"udp-listen:[::1]:5", "udp:six:5", true},
        {"udp-listen:0.0.0.0:5", "udp:[fd00::5]:5", false},
        {"tcp-listen:0.0.0.0:5", "tcp:own-six:5", false},
        {"tcp-listen:[::]:5", "tcp:own-six:5", true},
        {"tcp-listen:[::]:5", "tcp:192.168.1.5:5", true},
        {"tcp-listen:[::1]:5", "tcp:localhost:5", false},    // 127.0.0.1 alone in the hosts file
        {"tcp-listen:[::1]:5", "tcp:twice:5", true},
        {"tcp-listen:0.0.0.0:5", "tcp:twice:5", true},
        {"tcp-listen:0.0.0.0:5", "tcp:both:5", false},
        {"udp-listen:0.0.0.0:5", "udp:both:5", false},
        {"udp-listen:0.0.0.0:5", "udp:mixed:5", true},    // UDP prefers IPv4
        {"tcp-listen:0.0.0.0:5", "tcp:mixed:5", false},
        {"udp-listen:[::1]:5", "udp:twice:5", false},
        {"udp-listen:[::1]:5", "udp:twice:5,bind=[::1]:6", true},
        {"udp-listen:0.0.0.0:5,interface=lo", "udp:192.168.1.5:5", true},
        {"udp-listen:0.0.0.0:5,interface=eth0", "udp:192.168.1.5:5", false},
    };
    for (const Row& row : rows)
        EXPECT_EQ(faults_on_machine({row.port, row.link}, names, own) != "", row.is_fault) << row.port << ' ' << row.link;
    EXPECT_NE(
        faults_on_machine({"tcp-listen:[::1]:5", "tcp:localhost:5"}, names_in_hosts("::1 localhost\n127.0.0.1 localhost\n")), "");
}

TEST(CheckPeers, reports_nothing_twice) {
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5", "udp:localhost:5"}, {}), "");
    const HostAddresses names = names_in_hosts("127.0.0.1 localhost\n");
    EXPECT_EQ(faults_on_machine({"udp-listen:0.0.0.0:5", "udp:localhost:5", "udp:127.0.0.1:5"}, names), "");
}

}    // namespace
}    // namespace anogate::check_network_tests
