// Peers configured by name: found, moved, unknown, slow to resolve; in the tunnel too.
#include <daemon/command_line.hpp>
#include <link/resolver.hpp>
#include <link/tcp/connector.hpp>
#include <link/udp/udp_link.hpp>
#include <support/link_host.hpp>
#include <support/namespaces.hpp>
#include <support/own_hosts.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/tcp_peer.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace host_names_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;

struct HostNames : testing::Test {
    void SetUp() override {
        ANOGATE_NEEDS_NAMESPACES();
        hosts.emplace("127.0.0.1 localhost\n");
    }
    std::optional<OwnHosts> hosts;
};

TEST_F(HostNames, a_udp_peer_is_found_by_its_name) {
    hosts->set("127.0.0.2 fc.test\n::1 fc.test\n");
    UdpPeer fc{"127.0.0.2:0"};
    RunningGateway daemon{
        settings_of_texts({"udp:fc.test:" + std::to_string(fc.local().port) + ",name=fc", "udp-listen:127.0.0.1:0,name=ground"})};
    ASSERT_TRUE(daemon.until_up("fc")) << daemon.link("fc");
    EXPECT_EQ(daemon.link("fc").at("sends_to"), fc.local().text()) << "IPv4 where there are both";
    UdpPeer ground;
    ground.send(daemon.port("ground"), vendor::who_are_you);
    EXPECT_TRUE(daemon.until([&] { return fc.heard() == vendor::who_are_you; }));
    fc.send(fc.last_sender(), vendor::i_am_an_mcu);
    EXPECT_TRUE(daemon.until([&] { return ground.heard() == vendor::i_am_an_mcu; }));
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST_F(HostNames, an_unknown_name_is_reported_and_looked_up_again) {
    RunningGateway daemon{settings_of_texts({"udp:later.test:9,name=fc"})};
    ASSERT_TRUE(daemon.until([&] { return daemon.link("fc").at("error_id") == "no_such_host"; }));
    EXPECT_EQ(daemon.link("fc").at("error").get<std::string>().rfind("later.test: ", 0), 0u) << daemon.link("fc");
    hosts->set("127.0.0.2 later.test\n");
    EXPECT_TRUE(daemon.until_up("fc"));
}

TEST_F(HostNames, a_name_keeps_its_last_addresses_while_it_is_not_found) {
    hosts->set("127.0.0.2 fc.test\n");
    BareLinkHost host{0s};
    int answers = 0;
    std::vector<anogate::IpAddress> last;
    const auto look_up = [&] {
        const int before = answers;
        host.context().names.resolve("fc.test", host.now(), this,
                                     [&](const auto& addresses, const auto&) { ++answers, last = addresses; });
        return host.until([&] { return answers > before; });
    };
    ASSERT_TRUE(look_up());
    ASSERT_EQ(last.size(), 1u);
    hosts->set("127.0.0.1 localhost\n");
    ASSERT_TRUE(look_up());
    ASSERT_EQ(last.size(), 1u);
    EXPECT_EQ(last.front().text(), "127.0.0.2");
    hosts->set("127.0.0.3 fc.test\n");
    ASSERT_TRUE(look_up());
    EXPECT_EQ(last.front().text(), "127.0.0.3");
}

TEST_F(HostNames, an_answer_is_kept_for_a_minute) {
    hosts->set("127.0.0.2 fc.test\n");
    BareLinkHost host;
    const ano::TimePoint start = host.now();
    const auto address_at = [&](ano::Duration later) {
        std::string address;
        host.context().names.resolve("fc.test", start + later, this,
                                     [&](const auto& addresses, const auto&) { address = addresses.at(0).text(); });
        EXPECT_TRUE(host.until([&] { return !address.empty(); }));
        return address;
    };
    EXPECT_EQ(address_at(0s), "127.0.0.2");
    hosts->set("127.0.0.3 fc.test\n");
    EXPECT_EQ(address_at(59s), "127.0.0.2");
    EXPECT_EQ(address_at(61s), "127.0.0.3");
}

// A wire to which no address belongs: nothing is answered, and nothing is refused. Each address is in the file twice.
TEST_F(HostNames, all_addresses_of_a_name_are_tried_even_if_many_do_not_answer) {
    const Namespace here, there;
    here.join(there, "w0", "10.0.0.1/24", "10.0.0.2/24");
    here.ip("link set w0 arp off");
    const Inside inside{here};
    std::string all;
    for (int n = 0; n < 90; ++n) all += "10.0.0." + std::to_string(100 + n / 2) + " many.test\n";
    hosts->set(all);
    BareLinkHost host;
    std::vector<anogate::IpAddress> order;
    host.context().names.resolve("many.test", host.now(), this, [&](const auto& addresses, const auto&) { order = addresses; });
    ASSERT_TRUE(host.until([&] { return !order.empty(); }));
    ASSERT_EQ(order.size(), 45u);
    here.ip("address add " + order.back().text() + "/32 dev lo");
    const TcpListener last{order.back().text() + ":7001"};
    std::string ended;
    anogate::Connector connector{host.context(), *anogate::HostSpec::parse("many.test:7001"), 1min,
                                 [&](anogate::UniqueFd, const anogate::Endpoint& peer) { ended = peer.text(); },
                                 [&](const anogate::LinkError& why) { ended = why.text; }};
    connector.start();
    ASSERT_TRUE(host.until([&] { return !ended.empty(); }));
    EXPECT_EQ(ended, last.address());
}

TEST_F(HostNames, a_check_knows_a_name_of_this_gateway) {
    hosts->set("127.0.0.1 localhost\n127.0.1.1 vehicle\n10.9.8.7 far\n");
    const auto fault_of = [](const char* port, const char* link) {
        const char* const arguments[] = {"anogated", "--check", port, link};
        const auto parsed = anogate::parse_command_line(4, arguments, "/proc/nonexistent/anogate.json");
        const auto* const exit = std::get_if<anogate::Exit>(&parsed);
        return exit != nullptr ? exit->text : std::string{};
    };
    EXPECT_NE(fault_of("udp-listen:0.0.0.0:5", "udp:vehicle:5").find("'vehicle:5' is this gateway itself"), std::string::npos);
    EXPECT_NE(fault_of("udp-listen:127.0.0.1:5", "udp:localhost:5").find("is this gateway itself"), std::string::npos);
    EXPECT_NE(fault_of("tcp-listen:0.0.0.0:5", "tcp:vehicle:5").find("is this gateway itself"), std::string::npos);
    EXPECT_EQ(fault_of("udp-listen:0.0.0.0:5", "udp:far:5"), "");
}

TEST_F(HostNames, a_udp_peer_that_gets_another_address_is_followed) {
    BareLinkHost host{50ms};
    UdpPeer before{"127.0.0.2:0"}, after{"127.0.0.3:" + std::to_string(before.local().port)};
    hosts->set("127.0.0.2 fc.test other.test\n");
    const std::string port = ":" + std::to_string(before.local().port);
    anogate::UdpLink link{anogate::LinkId{0}, udp("fc", "fc.test" + port), host.context()};
    link.start();
    const auto reaches = [&](UdpPeer& peer) {
        return host.until([&] {
            link.write_raw(vendor::who_are_you);
            return !peer.frames().empty();
        });
    };
    ASSERT_TRUE(reaches(before));
    EXPECT_EQ(host.ups, 1);
    hosts->set("127.0.0.2 other.test\n");
    anogate::UdpLink other{anogate::LinkId{1}, udp("other", "other.test" + port), host.context()};
    other.start();
    int moves = 0;    // of the other one: both are looked up equally often
    ASSERT_TRUE(host.until([&] {
        if (host.ups == moves + 2) hosts->set(++moves % 2 == 1 ? "127.0.0.3 other.test\n" : "127.0.0.2 other.test\n");
        return moves == 4;
    })) << host.ups;
    EXPECT_EQ(link.facts().at(1).second, anogate::LinkFacts::value_type::second_type{"127.0.0.2" + port})
        << "a name without an answer moves nobody";
    other.stop();
    hosts->set("127.0.0.3 fc.test\n");
    EXPECT_TRUE(reaches(after));
    link.stop();
}

TEST_F(HostNames, the_tunnel_accepts_hosts_by_name_and_no_others) {
    hosts->set("10.79.0.2 ground.test\n127.0.0.1 trap.test\n");
    const Namespace here, there;
    here.join(there, "cable", "10.79.0.1/24", "10.79.0.2/24");
    there.ip("address add 10.79.0.3/24 dev cable");
    anogate::Settings settings = settings_of_texts({"sim:fc,hz=50,name=fc"});
    anogate::TunnelSettings& tunnel = settings.tunnel.emplace();
    tunnel.links = {"fc"};
    tunnel.allow_hosts = {"ground.test", "trap.test", "nobody.test"};
    std::optional<RunningGateway> daemon;
    {
        const Inside inside{here};
        daemon.emplace(settings);
    }
    const auto until = [&](const std::function<bool()>& holds) {
        const Inside inside{here};
        return daemon->until(holds);
    };
    ASSERT_TRUE(until([&] { return daemon->link("tunnel").at("error_id") == "no_such_host"; })) << daemon->link("tunnel");
    EXPECT_EQ(daemon->link("tunnel").at("error").get<std::string>().rfind("nobody.test: ", 0), 0u);
    const auto peer = [](const Namespace& space, const std::string& local) {
        const Inside inside{space};
        return std::make_unique<UdpPeer>(local);
    };
    const auto ground = peer(there, "10.79.0.2:0"), stranger = peer(there, "10.79.0.3:0"), local = peer(here, "127.0.0.1:0");
    const auto refused = [&] { return daemon->status().at("tunnel").at("tunnel_not_allowed").get<std::uint64_t>(); };
    // Each name has its own lookup: that of the ground station may still run.
    EXPECT_TRUE(until([&] {
        ground->send(endpoint("10.79.0.1:12333"), vendor::who_are_you);
        return ground->frames().size() > 5;
    }));
    const std::uint64_t before = refused();
    stranger->send(endpoint("10.79.0.1:12333"), vendor::who_are_you);
    local->send(endpoint("127.0.0.1:12333"), vendor::who_are_you);
    EXPECT_TRUE(until([&] { return refused() == before + 2; }))
        << "a name opens neither the rest of the network nor this computer: " << daemon->status().at("tunnel");
    const Inside inside{here};
    daemon.reset();
}

// A name server that never answers: a lookup takes many seconds, in its own thread.
TEST(SlowNames, do_not_block_the_loop_and_do_not_delay_the_shutdown) {
    ANOGATE_NEEDS_NAMESPACES();
    const TempDir dir;
    const Namespace space;
    const Inside inside{space};
    UdpPeer server{"127.0.0.9:53"};
    dir.write("resolv.conf", "nameserver 127.0.0.9\noptions timeout:5 attempts:3\n");
    dir.write("nsswitch.conf", "hosts: dns\n");
    const auto with_that_server = [&] {
        ::unshare(CLONE_NEWNS);
        ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
        ::mount((dir / "resolv.conf").c_str(), "/etc/resolv.conf", nullptr, MS_BIND, nullptr);
        ::mount((dir / "nsswitch.conf").c_str(), "/etc/nsswitch.conf", nullptr, MS_BIND, nullptr);
    };
    Daemon daemon{ANOGATED,
                  dir / "s",
                  {"sim:fc,hz=100", "udp-listen:127.0.0.1:0,name=ground", "tcp:slow.example.org:9000,name=a",
                   "tcp:slow.example.org:9001,name=b", "udp:slow.example.org:9002,name=c"},
                  {},
                  with_that_server};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    UdpPeer ground{"127.0.0.1:0"};
    std::size_t frames = 0, queries = 0;
    const auto receive = [&] {
        ground.send(daemon.port("ground"), vendor::who_are_you);
        frames += ground.frames().size();
        Bytes query(512);
        while (::recv(server.fd(), query.data(), query.size(), MSG_DONTWAIT) > 0) ++queries;
    };
    ASSERT_TRUE(wait_until([&] { return receive(), frames > 100 && queries > 0; }));
    EXPECT_LE(queries, 4u) << "one lookup, of two kinds of addresses, for three links";
    EXPECT_EQ(daemon.status().at("gateway").at("standstills"), 0);
    const auto start = ano::Clock::now();
    daemon.signal(SIGTERM);
    daemon.wait();
    EXPECT_LT(ano::Clock::now() - start, 10s) << "the lookup takes 15 s";
}

TEST(SlowNames, do_not_keep_another_name_from_being_found) {
    ANOGATE_NEEDS_NAMESPACES();
    const TempDir dir;
    const Namespace space;
    const Inside inside{space};
    UdpPeer server{"127.0.0.9:53"};    // never answers
    dir.write("resolv.conf", "nameserver 127.0.0.9\noptions timeout:5 attempts:3\n");
    dir.write("nsswitch.conf", "hosts: files dns\n");
    dir.write("hosts", "127.0.0.2 good.test\n");
    const auto with_those_files = [&] {
        ::unshare(CLONE_NEWNS);
        ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
        for (const std::string file : {"resolv.conf", "nsswitch.conf", "hosts"})
            ::mount((dir / file).c_str(), ("/etc/" + file).c_str(), nullptr, MS_BIND, nullptr);
    };
    std::vector<std::string> links;
    for (int n = 0; n < 12; ++n)
        links.push_back("tcp:slow" + std::to_string(n) + ".example.org:9000,name=slow" + std::to_string(n));
    links.push_back("udp:good.test:9000,name=good");
    Daemon daemon{ANOGATED, dir / "s", links, {}, with_those_files};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    ASSERT_TRUE(wait_until([&] {
        const auto all = daemon.status().at("links");
        return std::any_of(all.begin(), all.end(),
                           [](const auto& link) { return link.at("name") == "good" && link.at("state") == "up"; });
    }));
    EXPECT_EQ(daemon.output().find("too many"), std::string::npos) << daemon.output();
}

}    // namespace
}    // namespace host_names_tests
