// Encrypted links: accepted certificates, certificates that change, handshakes that never end, programs of other makers.
#include <http/client/certificate.hpp>
#include <link/tcp/tcp_keys.hpp>
#include <link/tcp/tls_context.hpp>
#include <support/changed_certificate.hpp>
#include <support/http.hpp>
#include <support/key_updates.hpp>
#include <support/leased_file.hpp>
#include <support/log_lines.hpp>
#include <support/namespaces.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/tcp_peer.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>

#include <poll.h>
#include <sys/inotify.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace tls_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::http::CertificateFiles;

struct Tls : testing::Test {
    Tls() {
        EXPECT_TRUE(make_authority("ours", authority("ca")));
        EXPECT_TRUE(make_authority("another", authority("other")));
        make("gateway", "ca", {{"localhost"}, {"127.0.0.1"}});
        make("vehicle", "ca", {{"vehicle"}, {}});
    }
    CertificateFiles authority(const std::string& name) const { return {dir / (name + ".pem"), dir / (name + "-key.pem")}; }
    void make(const std::string& name, const std::string& by, const anogate::http::CertificateNames& names) const {
        std::filesystem::remove(dir / (name + ".pem"));
        std::filesystem::remove(dir / (name + "-key.pem"));
        EXPECT_TRUE(make_signed_certificate(names, authority(name), authority(by)));
    }
    std::string pair(const std::string& name) const {
        return ",certificate=" + (dir / (name + ".pem")) + ",key=" + (dir / (name + "-key.pem"));
    }
    std::string ca(const std::string& name = "ca") const { return ",ca=" + (dir / (name + ".pem")); }
    /// Starts the listening gateway; to() returns the LINK text by which another one connects to it.
    void listen(const std::string& more) {
        ground.emplace(
            loop, std::vector<std::string>{"tls-listen:127.0.0.1:0,name=l" + pair("gateway") + more, "sim:fc,hz=50,name=fc"});
        ASSERT_TRUE(ground->until_up("l"));
    }
    std::string to(const std::string& host, const std::string& more) {
        return "tls:" + host + ":" + std::to_string(ground->port("l")) + ",name=t" + more;
    }
    std::string connect_error(const std::string& link) {
        air.emplace(loop, std::vector<std::string>{link});
        EXPECT_TRUE(air->until(
            [&] { return !air->link("t").at("error").get<std::string>().empty() && air->link("t").at("error_id") != "other"; }));
        return air->link("t").at("error");
    }

    TempDir dir;
    Loop loop;
    std::optional<RunningGateway> ground, air;
};

TEST_F(Tls, a_client_that_sends_only_messages_of_tls_is_disconnected) {
    listen(",verify=none");
    std::signal(SIGPIPE, SIG_IGN);
    constexpr int most = 200'000;
    std::atomic<int> sent{-2};
    std::thread client{[&sent, port = ground->port("l")] { sent = flood_with_key_updates(port, most); }};
    EXPECT_TRUE(ground->until([&] { return sent != -2; }));
    client.join();
    EXPECT_GT(sent, 0);
    EXPECT_LT(sent, most);
}

TEST_F(Tls, both_ends_show_certificates_and_frames_pass_both_ways) {
    listen(ca());
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca()), "udp-listen:127.0.0.1:0,name=u"});
    ASSERT_TRUE(air->until_up("t")) << air->link("t");
    UdpPeer station;
    station.send(air->port("u"), vendor::who_are_you);
    EXPECT_TRUE(air->until([&] { return split(station.heard()).frames.size() > 20; }));
    EXPECT_TRUE(split(station.heard()).rest.empty());
    EXPECT_GT(ground->count("l", "frames_in"), 0u);
    EXPECT_GT(air->link("t").at("certificate_days"), 800);
    EXPECT_TRUE(air->counters_add_up() && ground->counters_add_up());
}

TEST_F(Tls, large_frames_arrive_whole) {
    listen(ca());
    air.emplace(loop, std::vector<std::string>{to("127.0.0.1", pair("vehicle") + ca()), "udp-listen:127.0.0.1:0,name=u"});
    ASSERT_TRUE(air->until_up("t")) << air->link("t");
    UdpPeer station;
    const Bytes large = frame(0xFE, 0xFF, 0xF1, Bytes(4000, 0x5A));
    for (int n = 1; n <= 50; ++n) {
        ASSERT_TRUE(station.send(air->port("u"), large));
        ASSERT_TRUE(air->until([&] { return ground->count("l", "frames_in") == static_cast<std::uint64_t>(n); }));
    }
    EXPECT_EQ(ground->count("l", "bad_check"), 0u);
}

TEST_F(Tls, both_sides_refuse_a_certificate_of_another_authority) {
    listen(ca());
    EXPECT_NE(connect_error(to("localhost", pair("vehicle") + ca("other"))).find("its certificate: "), std::string::npos);
    make("stranger", "other", {{"stranger"}, {}});
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("stranger") + ca())});
    EXPECT_TRUE(ground->until([&] { return ground->link("l").at("error_id") == "tls"; })) << ground->link("l");
    EXPECT_EQ(ground->count("l", "frames_in"), 0u);
}

TEST_F(Tls, a_client_without_a_certificate_is_refused_unless_none_is_needed) {
    listen(ca());
    const std::string error = connect_error(to("localhost", ca()));
    EXPECT_NE(error.find("certificate required"), std::string::npos) << error;
    ground.reset();
    listen(",verify=none");
    air.emplace(loop, std::vector<std::string>{to("localhost", ca())});
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") > 10; }));
}

TEST_F(Tls, a_certificate_for_another_name_is_refused) {
    make("gateway", "ca", {{"elsewhere"}, {"10.1.2.3"}});
    listen(ca());
    EXPECT_NE(connect_error(to("localhost", pair("vehicle") + ca())).find("its certificate is for other names"),
              std::string::npos);
    EXPECT_NE(connect_error(to("127.0.0.1", pair("vehicle") + ca())).find("its certificate is for other names"),
              std::string::npos);
}

TEST_F(Tls, a_key_that_others_may_read_is_refused) {
    listen(ca());
    std::filesystem::permissions(dir / "vehicle-key.pem", std::filesystem::perms{0644});
    EXPECT_NE(
        connect_error(to("localhost", pair("vehicle") + ca())).find("every user of this computer can read it; run chmod o= "),
        std::string::npos);
    std::filesystem::permissions(dir / "vehicle-key.pem", std::filesystem::perms{0600});
    EXPECT_TRUE(air->until_up("t"));
}

TEST_F(Tls, a_new_certificate_is_used_for_new_connections_and_open_ones_continue) {
    listen(ca());
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
    ASSERT_TRUE(air->until([&] { return air->count("t", "frames_in") > 5; }));
    make("gateway", "other", {{"localhost"}, {}});
    std::optional<RunningGateway> second;
    EXPECT_TRUE(ground->until([&] {
        if (second && !second->up("t")) return second->link("t").at("error_id") == "tls";
        second.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
        return false;
    })) << "it sees the new one, of another authority";
    const auto before = air->count("t", "frames_in");
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") > before + 5; })) << "the open connection goes on";
}

// The kernel lets the thread that opens the file wait for 45 s.
TEST_F(Tls, files_on_a_slow_disk_are_read_while_frames_pass_and_the_previous_ones_are_in_use) {
    listen(ca());
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
    ASSERT_TRUE(air->until_up("t"));
    const LeasedFile slow{dir / "gateway.pem"};
    std::filesystem::permissions(dir / "gateway.pem", std::filesystem::perms{0640});
    ASSERT_TRUE(ground->until([&] { return ground->up("l") && slow.is_awaited(); }));
    const auto before = air->count("t", "frames_in");
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") > before + 5; }));
    RunningGateway second{loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())}};
    EXPECT_TRUE(second.until_up("t"));
    EXPECT_TRUE(slow.is_awaited()) << "it was not read meanwhile";
}

TEST_F(Tls, connections_without_a_handshake_are_closed_and_do_not_block_others_for_long) {
    listen(ca() + ",max_peers=64,max_per_address=64");
    std::vector<TcpPeer> silent;
    silent.reserve(40);
    for (int n = 0; n < 40; ++n) silent.emplace_back(ground->port("l"));
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
    EXPECT_TRUE(air->until_up("t")) << air->link("t");
    EXPECT_TRUE(ground->until([&] { return silent.front().is_closed(); })) << "after 10 s";
}

/// More connections than may wait, from a hundred addresses with a few each, which stop within the handshake and reconnect when
/// they are closed.
struct Crowd {
    Crowd(RunningGateway& at, Bytes words) : gateway{at}, says{std::move(words)}, all(100 * 4) {}
    void come() {
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i] && !all[i].is_closed()) continue;
            all[i] = TcpPeer{
                anogate::UniqueFd{support::connect_tcp(gateway.port("l"), "127.9.0." + std::to_string(1 + i % 100))}};
            if (!says.empty() && all[i]) all[i].send(says);
        }
    }
    RunningGateway& gateway;
    Bytes says;
    std::vector<TcpPeer> all;
};

TEST_F(Tls, many_clients_that_stop_within_the_handshake_do_not_block_a_host) {
    for (const Bytes& says : {Bytes{}, Bytes{22, 3, 1, 0, 100, 1}}) {
        listen(ca() + ",max_peers=8");
        Crowd crowd{*ground, says};
        int got_in = 0;
        for (int n = 0; n < 4; ++n) {
            crowd.come();
            air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
            got_in += air->until([&] { return air->count("t", "frames_in") > 0; }, 4s) ? 1 : 0;
            air.reset();
        }
        EXPECT_EQ(got_in, 4) << says.size();
        EXPECT_EQ(ground->link("l").at("error_id"), "handshakes");
        EXPECT_EQ(ground->link("l").at("hint_id"), "handshakes");
        EXPECT_GT(ground->link("l").at("handshakes_gave_way"), 0);
        ground.reset();
    }
}

TEST_F(Tls, clients_that_send_nothing_are_closed_first_when_others_connect) {
    listen(ca());
    TcpPeer silent{ground->port("l")}, begun{ground->port("l")};
    begun.send(Bytes{22, 3, 1, 0, 100, 1});
    std::vector<TcpPeer> others;
    EXPECT_TRUE(ground->until([&] {
        if (others.size() < 200) others.emplace_back(ground->port("l"));
        ground->run_for(50ms);
        return silent.is_closed();
    }));
    EXPECT_FALSE(begun.is_closed());
}

// The loop learns of its first bytes only after it has accepted the others.
TEST_F(Tls, a_client_that_has_begun_its_handshake_is_not_closed_as_silent) {
    listen(ca());
    const auto evicted = [&] { return ground->link("l").at("handshakes_gave_way").get<std::size_t>(); };
    TcpPeer first{ground->port("l")};
    std::vector<TcpPeer> others;
    while (others.size() < 255) others.emplace_back(ground->port("l"));
    ground->io().restart();
    ground->io().poll();
    ASSERT_EQ(evicted(), 0u);
    for (int i = 0; i < 10; ++i) others.emplace_back(ground->port("l"));
    first.send(Bytes{22, 3, 1, 0, 100, 1});
    EXPECT_TRUE(ground->until([&] { return evicted() >= 10; }));
    EXPECT_FALSE(first.is_closed());
}

TEST_F(Tls, invalid_data_instead_of_a_handshake_closes_only_that_connection) {
    listen(ca());
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
    ASSERT_TRUE(air->until_up("t"));
    TcpPeer stranger{ground->port("l")};
    stranger.send(vendor::who_are_you + Bytes(500, 0xFF));
    EXPECT_TRUE(ground->until([&] { return stranger.is_closed(); }));
    const auto before = air->count("t", "frames_in");
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") > before; }));
    EXPECT_EQ(ground->count("l", "frames_in"), 0u);
}

// 48 KiB of it were sent; the rest is sent with the next frame, if there is one.
TEST_F(Tls, the_end_of_a_large_frame_arrives_over_a_slow_wire) {
    ANOGATE_NEEDS_NAMESPACES();
    make("gateway", "ca", {{"localhost"}, {"10.78.0.1"}});
    const Namespace here, there;
    here.join(there, "w0", "10.78.0.1/24", "10.78.0.2/24");
    UdpPeer host, station;
    {
        const Inside inside{here};
        ASSERT_EQ(run("tc qdisc add dev w0 root tbf rate 1mbit burst 4kb latency 400ms"), 0);
        ground.emplace(loop, std::vector<std::string>{"tls-listen:10.78.0.1:0,name=l,max_data=60000" + pair("gateway") + ca(),
                                                      "udp-listen:127.0.0.1:0,name=u,max_data=60000"});
        ASSERT_TRUE(ground->until_up("l"));
        host = UdpPeer{};
    }
    {
        const Inside inside{there};
        air.emplace(loop, std::vector<std::string>{"tls:10.78.0.1:" + std::to_string(ground->port("l")) +
                                                       ",name=t,max_data=60000" + pair("vehicle") + ca(),
                                                   "udp-listen:127.0.0.1:0,name=u,max_data=60000"});
        ASSERT_TRUE(air->until_up("t")) << air->link("t");
        station = UdpPeer{};
    }
    station.send(air->port("u"), vendor::who_are_you);
    ASSERT_TRUE(air->until([&] { return ground->count("l", "frames_in") > 0; }));
    const Bytes image = frame(0xDC, 0xFE, 0xF1, Bytes(60000));
    host.send(ground->port("u"), image);
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") == 1; })) << air->link("t");
}

TEST_F(Tls, a_handshake_continues_only_when_a_whole_record_is_received) {
    TcpListener listener;
    TcpPeer client{listener.port()}, server;
    ASSERT_TRUE(wait_until([&] { return listener.accept(server); }));
    const auto context = anogate::TlsContext::read(
        {dir / "gateway.pem", dir / "gateway-key.pem", dir / "ca.pem", anogate::TlsVerify::peer},
        anogate::TlsContext::Side::listens);
    ASSERT_TRUE(context);
    const auto tls = (*context)->connection(server.fd(), {});
    ASSERT_TRUE(tls);
    pollfd readable{server.fd(), POLLIN, 0};
    const Bytes record = Bytes{22, 3, 1, 0, 100} + Bytes(100, 1);
    for (std::size_t i = 0; i < record.size(); ++i) {
        EXPECT_FALSE((*tls)->has_record()) << i;
        ASSERT_TRUE(client.send(std::span{record}.subspan(i, 1)));
        if (i >= 5 && i + 1 < record.size()) {
            EXPECT_EQ(::poll(&readable, 1, 0), 0) << "no event for byte " << i;
        }
    }
    EXPECT_EQ(::poll(&readable, 1, 10'000), 1);
    EXPECT_TRUE((*tls)->has_record());
}

TEST_F(Tls, a_connection_that_ends_within_a_record_is_reported_as_readable) {
    TcpListener listener;
    TcpPeer client{listener.port()}, server;
    ASSERT_TRUE(wait_until([&] { return listener.accept(server); }));
    const auto context = anogate::TlsContext::read(
        {dir / "gateway.pem", dir / "gateway-key.pem", dir / "ca.pem", anogate::TlsVerify::peer},
        anogate::TlsContext::Side::listens);
    ASSERT_TRUE(context);
    const auto tls = (*context)->connection(server.fd(), {});
    ASSERT_TRUE(tls);
    client.send(Bytes{22, 3, 1, 0, 100, 1});
    EXPECT_FALSE((*tls)->has_record());
    client.close();
    EXPECT_TRUE(wait_until([&] { return (*tls)->has_record(); }));
}

// Forwards each byte separately.
TEST_F(Tls, a_handshake_of_single_bytes_succeeds) {
    listen(ca());
    TcpListener between;
    std::atomic<bool> ends{false};
    std::thread relay{[&, port = ground->port("l")] {
        TcpPeer near, far{port};
        while (!ends && !between.accept(near)) std::this_thread::sleep_for(1ms);
        const auto pass = [&ends](TcpPeer& from, TcpPeer& to) {
            std::uint8_t byte;
            if (::recv(from.fd(), &byte, 1, MSG_DONTWAIT) != 1) return false;
            while (!ends && !to.send({&byte, 1})) std::this_thread::sleep_for(1ms);    // its buffer is full of single bytes
            return true;
        };
        while (!ends)
            if (!pass(near, far) && !pass(far, near)) std::this_thread::sleep_for(100us);
    }};
    air.emplace(loop,
                std::vector<std::string>{"tls:localhost:" + std::to_string(between.port()) + ",name=t" + pair("vehicle") + ca()});
    EXPECT_TRUE(air->until([&] { return air->count("t", "frames_in") > 10; })) << air->link("t");
    ends = true;
    relay.join();
}

TEST_F(Tls, a_server_that_sends_nothing_does_not_delay_the_stop) {
    TcpListener silent;
    Daemon daemon{ANOGATED, dir / "s", {"tls:127.0.0.1:" + std::to_string(silent.port()) + ",name=t,verify=none"}};
    ASSERT_TRUE(daemon.until_answers());
    TcpPeer accepted;
    ASSERT_TRUE(wait_until([&] { return silent.accept(accepted); }));
    ASSERT_TRUE(wait_until([&] { return !accepted.heard().empty(); }));
    const auto start = ano::Clock::now();
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_LT(ano::Clock::now() - start, 8s) << "the handshake is waited for 10 s";
}

// OpenSSL sends without MSG_NOSIGNAL.
TEST_F(Tls, a_peer_that_closes_does_not_end_anoctl_by_a_signal) {
    TcpListener silent;
    Process anoctl{ANOCTL, {"monitor", "tls:127.0.0.1:" + std::to_string(silent.port()) + ",verify=none"}};
    TcpPeer accepted;
    ASSERT_TRUE(wait_until([&] { return silent.accept(accepted); }));
    std::ifstream status{"/proc/" + std::to_string(anoctl.pid()) + "/status"};
    std::uint64_t ignored = 0;
    for (std::string word; status >> word;)
        if (word == "SigIgn:") status >> std::hex >> ignored;
    EXPECT_NE(ignored & (std::uint64_t{1} << (SIGPIPE - 1)), 0u);
}

TEST_F(Tls, files_that_become_unusable_are_reported_and_the_previous_ones_stay_in_use) {
    listen(ca());
    std::filesystem::permissions(dir / "gateway-key.pem", std::filesystem::perms{0644});
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("vehicle") + ca())});
    ASSERT_TRUE(air->until_up("t")) << air->link("t");
    ASSERT_TRUE(ground->until([&] { return ground->link("l").at("error_id") == "certificate_unusable"; }));
    const std::string error = ground->link("l").at("error");
    EXPECT_NE(error.find("chmod o="), std::string::npos) << error;
    EXPECT_NE(error.find("stay in use until this is corrected"), std::string::npos) << error;
    std::filesystem::permissions(dir / "gateway-key.pem", std::filesystem::perms{0600});
    EXPECT_TRUE(ground->until([&] { return ground->link("l").at("error") == ""; }));
}

TEST_F(Tls, files_that_become_unusable_while_the_link_is_up_are_logged_once) {
    LogLines log;
    int lines = 0;
    listen(ca());
    const auto logged = [&] {
        for (const std::string& line : log.pop_all()) lines += line.find("chmod o=") != line.npos;
        return lines;
    };
    ground->run_for(300ms);
    std::filesystem::permissions(dir / "gateway-key.pem", std::filesystem::perms{0644});
    ASSERT_TRUE(ground->until([&] { return ground->link("l").at("error_id") == "certificate_unusable"; }));
    EXPECT_TRUE(ground->until([&] { return logged() > 0; }));
    ground->run_for(2500ms);    // the files are checked once a second
    EXPECT_EQ(logged(), 1);
}

TEST_F(Tls, a_key_with_a_password_is_refused_with_the_command_that_removes_it) {
    ASSERT_EQ(std::system(
                  ("openssl pkey -aes256 -passout pass:secret -in " + (dir / "vehicle-key.pem") + " -out " + (dir / "locked.pem"))
                      .c_str()),
              0);
    std::filesystem::permissions(dir / "locked.pem", std::filesystem::perms{0600});
    const auto read = anogate::TlsContext::read({dir / "vehicle.pem", dir / "locked.pem", {}, {}},
                                                anogate::TlsContext::Side::connects);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().text.find("has a password; remove it: openssl pkey -in "), std::string::npos) << read.error().text;
}

TEST_F(Tls, a_peer_that_does_not_use_tls_is_named_so) {
    TcpListener plain;
    air.emplace(loop, std::vector<std::string>{"tls:" + plain.address() + ",name=t" + pair("vehicle") + ca()});
    TcpPeer peer;
    ASSERT_TRUE(air->until([&] { return plain.accept(peer); }));
    peer.send(vendor::i_am_an_mcu);
    ASSERT_TRUE(air->until([&] { return !air->link("t").at("error").get<std::string>().empty(); }));
    const std::string error = air->link("t").at("error");
    EXPECT_NE(error.find("the other end does not use TLS"), std::string::npos) << error;
}

TEST_F(Tls, a_certificate_that_is_not_valid_yet_and_one_of_an_authority_are_reported) {
    const auto fault_of = [&](const std::string& certificate, const std::string& key) {
        const auto read = anogate::TlsContext::read({dir / certificate, dir / key, {}, {}}, anogate::TlsContext::Side::connects);
        return read ? anogate::validity_trouble(**read).text : read.error().text;
    };
    EXPECT_EQ(fault_of("vehicle.pem", "vehicle-key.pem"), "");
    EXPECT_NE(fault_of("ca.pem", "ca-key.pem").find("is the certificate of an authority"), std::string::npos)
        << fault_of("ca.pem", "ca-key.pem");
    ASSERT_TRUE(postpone_validity(dir / "vehicle.pem", dir / "vehicle-key.pem"));
    EXPECT_NE(fault_of("vehicle.pem", "vehicle-key.pem").find("is not valid yet"), std::string::npos)
        << fault_of("vehicle.pem", "vehicle-key.pem");
}

TEST_F(Tls, a_port_is_down_while_its_certificate_is_unusable) {
    ground.emplace(loop, std::vector<std::string>{"tls-listen:127.0.0.1:0,name=l" + pair("later") + ca()});
    EXPECT_TRUE(ground->until([&] { return ground->link("l").at("error_id") == "tls"; })) << ground->link("l");
    EXPECT_FALSE(ground->up("l"));
    make("later", "ca", {{"localhost"}, {}});
    EXPECT_TRUE(ground->until_up("l"));
}

TEST_F(Tls, unusable_files_that_do_not_change_are_not_read_every_second) {
    std::ofstream{dir / "gateway.pem"} << "junk";
    const anogate::UniqueFd watch{::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)};
    ASSERT_GE(::inotify_add_watch(watch.get(), (dir / "gateway.pem").c_str(), IN_OPEN | IN_CLOSE), 0);
    const auto opened = [&] {
        std::size_t bytes = 0;
        std::array<char, 4096> events{};
        for (ssize_t n; (n = ::read(watch.get(), events.data(), events.size())) > 0;) bytes += static_cast<std::size_t>(n);
        return bytes / sizeof(inotify_event) / 2;    // one at the end of each
    };
    const auto began = std::chrono::steady_clock::now();
    ground.emplace(loop, std::vector<std::string>{"tls-listen:127.0.0.1:0,name=l" + pair("gateway") + ca()});
    ASSERT_TRUE(ground->until([&] { return ground->link("l").at("error_id") == "tls"; })) << ground->link("l");
    ground->run_for(4s);
    const std::size_t count = opened();
    EXPECT_GE(count, 1u);
    EXPECT_LE(static_cast<double>(count), 1 + (std::chrono::steady_clock::now() - began) / 10s);
    make("gateway", "ca", {{"localhost"}, {}});
    EXPECT_TRUE(ground->until_up("l")) << ground->link("l");
}

TEST_F(Tls, the_certificate_of_a_computer_is_no_authority) {
    using anogate::TlsContext;
    const auto fault_of = [&](const std::string& name) {
        const auto read = TlsContext::read({{}, {}, dir / (name + ".pem"), {}}, TlsContext::Side::connects);
        return read ? std::string{} : read.error().text;
    };
    EXPECT_EQ(fault_of("ca"), "");
    EXPECT_NE(fault_of("vehicle").find("is the certificate of a computer, not of an authority"), std::string::npos);
    ASSERT_TRUE(anogate::http::make_certificate({{"self"}, {}}, dir / "self.pem", dir / "self-key.pem"));
    EXPECT_EQ(fault_of("self"), "") << "it signed itself";
}

// The peer refuses the certificate after the handshake: the connection is lost as soon as it is open.
TEST_F(Tls, a_connection_that_is_refused_again_and_again_is_logged_once) {
    listen(ca());
    make("stranger", "other", {{"stranger"}, {}});
    LogLines log;
    std::vector<std::string> lines;
    const auto lines_of_link = [&] {
        for (const std::string& line : log.pop_all())
            if (line.starts_with("t: ")) lines.push_back(line);
        return lines.size();
    };
    air.emplace(loop, std::vector<std::string>{to("localhost", pair("stranger") + ca())});
    ASSERT_TRUE(air->until([&] { return lines_of_link() >= 2; }));
    const std::size_t before = lines_of_link();
    const auto failed = [&] { return ground->link("l").at("error").get<std::string>().find("5 connections were refused") == 0; };
    ASSERT_TRUE(ground->until(failed)) << ground->link("l");
    EXPECT_EQ(lines_of_link(), before) << testing::PrintToString(lines);
    make("stranger", "ca", {{"vehicle"}, {}});
    EXPECT_TRUE(air->until([&] { return lines_of_link() > before && lines.back() == "t: up"; })) << "when it stays up";
}

TEST_F(Tls, the_client_of_openssl_connects) {
    listen(ca());
    const std::string port = std::to_string(ground->port("l"));
    Process client{
        "/bin/sh",
        {"-c", "sleep 60 | exec timeout 60 openssl s_client -quiet -verify_return_error -connect localhost:" + port +
                   " -CAfile " + (dir / "ca.pem") + " -cert " + (dir / "vehicle.pem") + " -key " + (dir / "vehicle-key.pem")}};
    EXPECT_TRUE(ground->until([&] { return client.output().find("\xAB\xDC") != std::string::npos; })) << client.output();
}

// Security level 0, so that the client is able to use the older versions at all.
TEST_F(Tls, versions_1_2_and_1_3_are_accepted_and_older_ones_refused) {
    listen(ca());
    const std::string client = "timeout 10 openssl s_client -brief -cipher ALL:@SECLEVEL=0 -connect localhost:" +
                               std::to_string(ground->port("l")) + " -CAfile " + (dir / "ca.pem") + " -cert " +
                               (dir / "vehicle.pem") + " -key " + (dir / "vehicle-key.pem");
    for (const auto& [option, is_accepted] :
         {std::pair{"-tls1_1", false}, std::pair{"-tls1_2", true}, std::pair{"-tls1_3", true}}) {
        Process asks{"/bin/sh", {"-c", "sleep 60 | exec " + client + " " + option + " 2>&1"}};
        const std::string wanted = is_accepted ? "CONNECTION ESTABLISHED" : "alert protocol version";
        EXPECT_TRUE(ground->until([&] { return asks.output().find(wanted) != std::string::npos; })) << option << asks.output();
    }
}

TEST_F(Tls, connects_to_a_listening_socat) {
    const std::string listener = "OPENSSL-LISTEN:0,bind=127.0.0.1,cert=" + (dir / "gateway.pem") +
                                 ",key=" + (dir / "gateway-key.pem") + ",cafile=" + (dir / "ca.pem") + ",verify=1";
    Process socat{"/bin/sh", {"-c", "exec timeout 60 socat -dd " + listener + " EXEC:cat 2>&1"}};
    std::string port;
    ASSERT_TRUE(wait_until([&] {
        const std::string said = socat.output();
        const auto at = said.find("listening on AF=2 127.0.0.1:");
        if (at == std::string::npos || said.find('\n', at) == std::string::npos) return false;
        port = said.substr(at + 28, said.find('\n', at) - at - 28);
        return true;
    })) << socat.output();
    air.emplace(loop, std::vector<std::string>{"tls:localhost:" + port + ",name=t,hello=on" + pair("vehicle") + ca()});
    EXPECT_TRUE(air->until([&] { return air->count("t", "bytes_in") > 0; }))
        << air->link("t") << socat.output();    // the echo of the hello
}

TEST_F(Tls, devices_with_v7_are_translated) {
    listen(ca() + ",protocol=v7,v7_device=0xDD,v7_params=lx");
    air.emplace(loop, std::vector<std::string>{
                          "sim:lx,name=lx",
                          to("localhost", pair("vehicle") + ca() + ",protocol=v7,v7_role=host,v7_device=0xDD,v7_params=lx")});
    EXPECT_TRUE(ground->until([&] { return ground->count("l", "frames_in") > 10 && !ground->route("0xDD").is_null(); }))
        << ground->link("l") << air->link("t");
}

TEST_F(Tls, days_until_the_certificate_expires_are_counted) {
    using anogate::TlsContext;
    const auto none = TlsContext::read({}, TlsContext::Side::connects);
    ASSERT_TRUE(none);
    EXPECT_FALSE((*none)->validity().days_left);
    const auto one = TlsContext::read({dir / "vehicle.pem", dir / "vehicle-key.pem", {}, {}}, TlsContext::Side::connects);
    ASSERT_TRUE(one);
    EXPECT_NEAR(static_cast<double>((*one)->validity().days_left.value_or(0)), 823, 1);
}

}    // namespace
}    // namespace tls_tests
