// Restart of a service: its ports stay open, and its peers and devices stay known.
#include <support/numbered_frames.hpp>
#include <support/pty_device.hpp>
#include <support/service_manager.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <thread>

namespace restart_tests {
namespace {

using namespace support;
using nlohmann::json;

constexpr std::uint8_t host = 0xFE, fc = 0xDC, other = 0xDD;

bool is_open_elsewhere(const std::multimap<std::string, anogate::UniqueFd>& stored, const std::string& path) {
    struct stat named {
    }, open{};
    if (::stat(path.c_str(), &named) != 0) return false;
    for (const auto& [name, fd] : stored)
        if (::fstat(fd.get(), &open) == 0 && open.st_rdev == named.st_rdev && S_ISCHR(open.st_mode)) return true;
    return false;
}

class Restart : public testing::Test {
protected:
    void configure(const json& links, const json& more = json::object()) {
        json all = more;
        all["links"] = links;
        dir.write("anogate.json", all.dump());
    }
    testing::AssertionResult start() {
        service = manager.start(ANOGATED, dir / "control", {"--config", dir / "anogate.json"},
                                {"STATE_DIRECTORY=" + (dir / "state")});
        if (service->until_answers()) return testing::AssertionSuccess();
        return testing::AssertionFailure() << service->output();
    }
    testing::AssertionResult restart() {
        if (const int status = manager.stop(*service); status != 0)
            return testing::AssertionFailure() << "it ended with " << status << ": " << service->output();
        return start();
    }
    anogate::Endpoint ground() { return endpoint("127.0.0.1:" + std::to_string(service->port("ground"))); }
    json route(const std::string& address) const {
        const json now = service->status();
        for (const json& route : now.at("routes"))
            if (route.at("address") == address) return route;
        return {};
    }
    json links_of(const std::string& address) const {
        const json known = route(address);
        return known.is_null() ? json::array() : known.at("links");
    }
    bool knows(const std::string& address) {
        return wait_until([&] { return !route(address).is_null(); });
    }
    static bool receives(PtyDevice& device, const Bytes& bytes) {
        return wait_until([&] {
            const Bytes& all = device.heard();
            return std::search(all.begin(), all.end(), bytes.begin(), bytes.end()) != all.end();
        });
    }
    static bool receives(UdpPeer& peer, const Bytes& bytes) {
        return wait_until([&] {
            const Bytes& all = peer.heard();
            return std::search(all.begin(), all.end(), bytes.begin(), bytes.end()) != all.end();
        });
    }

    TempDir dir;
    ServiceManager manager{dir / "notify"};
    std::unique_ptr<Daemon> service;
};

TEST_F(Restart, five_times_loses_none_of_ten_thousand_frames_each_way) {
    constexpr int frames = 10'000, restarts = 5;
    stay_on_one_processor();
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc,pace=off,queue=1000000,age.rest=1m",
               "udp-listen:127.0.0.1:0,name=ground,queue=1000000,age.rest=1m"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    const anogate::Endpoint to = ground();
    UdpPeer peer;
    Stream up{fc, host}, down{host, fc};
    Bytes rest;
    peer.send(to, down.next());    // registered as a peer from here on
    ASSERT_TRUE(wait_until([&] { return service->count("ground", "frames_in") == 1; }));
    int restarted = 0;
    const auto exchange = [&] {
        for (int i = 0; i < 20 && up.may_go_on(frames); ++i) {
            const Bytes next = up.next();
            ASSERT_EQ(device.write(next), next.size());
        }
        for (int i = 0; i < 20 && down.may_go_on(frames); ++i) peer.send(to, down.next());
        up.take(peer.frames());
        down.take(frames_of(device, rest));
    };
    ASSERT_TRUE(wait_until([&] {
        exchange();
        if (restarted < restarts && up.came() >= (restarted + 1) * frames / (restarts + 1)) {
            ++restarted;
            EXPECT_TRUE(restart());
            EXPECT_EQ(service->port("ground"), to.port) << "of port 0 the kernel made this one";
        }
        return HasFailure() || (up.came() == frames && down.came() == frames);
    })) << up.came()
        << " and " << down.came() << " of " << frames << ", " << restarted << " restarts";
    EXPECT_EQ(restarted, restarts);
}

TEST_F(Restart, a_peer_that_only_listens_is_still_served) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    UdpPeer listener;
    listener.send(ground(), frame(host, 0xFF, 0x05));
    device.write(frame(fc, 0xFF, 0x06));
    ASSERT_TRUE(knows("0xFE") && knows("0xDC"));
    ASSERT_TRUE(restart());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    EXPECT_EQ(route("0xDC").at("links"), json{"fc"}) << "before anybody has spoken";
    EXPECT_EQ(route("0xFE").at("links"), json{"ground"});
    const Bytes news = frame(fc, host, 0x03, Bytes(7));
    device.write(news);
    EXPECT_TRUE(receives(listener, news));
}

TEST_F(Restart, a_copy_on_another_link_of_the_group_is_still_recognized) {
    PtyDevice device{dir / "fc"}, radio{dir / "radio"}, cable{dir / "cable"};
    configure({"serial:" + device.path() + ",name=fc", "serial:" + radio.path() + ",name=radio,group=vehicle",
               "serial:" + cable.path() + ",name=cable,group=vehicle"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("radio") && service->until_up("cable"));
    const Bytes command = frame(host, 0xFF, 0xC0, {1, 2, 3}), next = frame(host, 0xFF, 0xC0, {4, 5, 6});
    radio.write(command);
    ASSERT_TRUE(receives(device, command));
    ASSERT_EQ(manager.stop(*service), 0);
    cable.write(command);    // it waits on the wire
    ASSERT_TRUE(start());
    ASSERT_TRUE(wait_until([&] { return service->count("cable", "duplicate") == 1; }));
    cable.write(next);
    ASSERT_TRUE(receives(device, next));
    EXPECT_EQ(device.heard(), command + next) << "carried out once";
}

TEST_F(Restart, a_learned_address_is_not_flooded) {
    PtyDevice device{dir / "fc"}, second{dir / "second"};
    configure({"serial:" + device.path() + ",name=fc", "serial:" + second.path() + ",name=second",
               "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("second") && service->until_up("ground"));
    device.write(frame(fc, 0xFF, 0x06));
    second.write(frame(other, 0xFF, 0x06));
    ASSERT_TRUE(knows("0xDC") && knows("0xDD"));
    ASSERT_TRUE(restart());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("second") && service->until_up("ground"));
    UdpPeer peer;
    const Bytes to_first = frame(host, fc, 0xE1, Bytes(6)), to_second = frame(host, other, 0xE1, Bytes(6));
    peer.send(ground(), to_first);
    peer.send(ground(), to_second);
    EXPECT_TRUE(receives(second, to_second));
    EXPECT_TRUE(receives(device, to_first));
    const Bytes& all = second.heard();
    EXPECT_EQ(std::search(all.begin(), all.end(), to_first.begin(), to_first.end()), all.end());
}

TEST_F(Restart, a_half_received_frame_is_completed_afterwards) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    UdpPeer peer;
    peer.send(ground(), frame(host, 0xFF, 0x05));
    ASSERT_TRUE(knows("0xFE"));
    const Bytes first = frame(fc, 0xFF, 0x06), whole = frame(fc, host, 0xF1, Bytes(40, 7));
    device.write(first + Bytes{whole.begin(), whole.begin() + 20});
    ASSERT_TRUE(receives(peer, first));
    ASSERT_EQ(manager.stop(*service), 0);
    device.write(Bytes{whole.begin() + 20, whole.end()});
    ASSERT_TRUE(start());
    EXPECT_TRUE(receives(peer, whole));
}

// Bytes that wait on a wire may be as old as the restart. A wire that was silent has no old bytes.
TEST_F(Restart, the_first_frame_on_a_silent_line_is_not_treated_as_old) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground,age.rest=50ms"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    UdpPeer peer;
    peer.send(ground(), frame(host, 0xFF, 0x05));
    ASSERT_TRUE(knows("0xFE"));
    ASSERT_TRUE(restart());
    ASSERT_TRUE(service->until_up("fc"));
    std::this_thread::sleep_for(std::chrono::milliseconds{100});    // too old, if its age were counted from the start
    const Bytes first = frame(fc, host, 0xF1, Bytes(20, 7));
    device.write(first);
    EXPECT_TRUE(receives(peer, first));
}

TEST_F(Restart, a_good_frame_after_a_false_header_is_forwarded_without_more_bytes) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc,age.rest=1m", "udp-listen:127.0.0.1:0,name=ground,age.rest=1m"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    UdpPeer peer;
    peer.send(ground(), frame(host, 0xFF, 0x05));
    ASSERT_TRUE(knows("0xFE"));
    const Bytes first = frame(fc, 0xFF, 0x06), good = frame(fc, host, 0xF1, Bytes(20, 7));
    device.write(first + Bytes{0xAB, fc, host, 0x03, 0xC8, 0x00} + good);
    ASSERT_TRUE(receives(peer, first));
    ASSERT_TRUE(restart());
    EXPECT_TRUE(receives(peer, good));
}

TEST_F(Restart, the_original_link_of_a_device_can_still_regain_its_address) {
    PtyDevice home{dir / "home"}, thief{dir / "thief"};
    configure({"serial:" + home.path() + ",name=home", "serial:" + thief.path() + ",name=thief"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("home") && service->until_up("thief"));
    home.write(frame(fc, 0xFF, 0x06));
    ASSERT_TRUE(knows("0xDC"));
    const auto leads_to = [&](const char* link) { return links_of("0xDC") == json::array({link}); };
    ASSERT_TRUE(wait_until([&] {
        thief.write(frame(fc, 0xFF, 0x06));
        return leads_to("thief");
    })) << "its holder does not answer";
    ASSERT_TRUE(restart());
    ASSERT_TRUE(service->until_up("home") && service->until_up("thief"));
    EXPECT_TRUE(leads_to("thief"));
    EXPECT_TRUE(wait_until([&] {
        home.write(frame(fc, 0xFF, 0x06));
        return leads_to("home");
    }));
}

TEST_F(Restart, devices_of_a_port_that_was_swapped_are_forgotten) {
    PtyDevice left{dir / "a"}, right{dir / "b"};
    std::filesystem::create_symlink(left.terminal(), dir / "left");
    std::filesystem::create_symlink(right.terminal(), dir / "right");
    configure({"serial:" + (dir / "left") + ",name=left", "serial:" + (dir / "right") + ",name=right"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("left") && service->until_up("right"));
    left.write(frame(fc, 0xFF, 0x06));
    ASSERT_TRUE(knows("0xDC"));
    ASSERT_EQ(manager.stop(*service), 0);
    for (const char* name : {"left", "right"}) std::filesystem::remove(dir / name);
    std::filesystem::create_symlink(right.terminal(), dir / "left");
    std::filesystem::create_symlink(left.terminal(), dir / "right");
    ASSERT_TRUE(start());
    ASSERT_TRUE(manager.stored().empty()) << "or the ports are in use";
    ASSERT_TRUE(service->until_up("left") && service->until_up("right"));
    EXPECT_TRUE(route("0xDC").is_null());
    left.write(frame(fc, 0xFF, 0x06));
    EXPECT_TRUE(wait_until([&] { return links_of("0xDC") == json::array({"right"}); }));
}

TEST_F(Restart, does_not_store_the_socket_of_a_multicast_group) {
    const std::string port = std::to_string(UdpPeer{}.port());
    configure({"udp:239.9.9.1:" + port + ",bind=127.0.0.1:" + port + ",name=group"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("group"));
    ASSERT_EQ(manager.stop(*service), 0);
    EXPECT_EQ(manager.stored().count("wire"), 0u);
}

// Within TimeoutStopSec= of the unit.
TEST_F(Restart, a_service_manager_that_does_not_answer_delays_the_stop_only_briefly) {
    json links = json::array();
    for (int i = 0; i < 40; ++i) links.push_back("udp-listen:127.0.0.1:0,name=l" + std::to_string(i));
    configure(links);
    ASSERT_TRUE(start());
    service->signal(SIGTERM);
    EXPECT_EQ(service->wait(std::chrono::seconds{5}), 0);
}

TEST_F(Restart, stored_ports_that_are_no_longer_configured_are_closed) {
    PtyDevice device{dir / "fc"};
    configure(
        {"serial:" + device.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground", "pty:" + (dir / "app") + ",name=app"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    const anogate::Endpoint old = ground();
    ASSERT_EQ(manager.stop(*service), 0);
    EXPECT_EQ(manager.stored().size(), 3u) << "a pty is not stored, what is known is";
    EXPECT_TRUE(is_open_elsewhere(manager.stored(), device.path()));
    configure({"sim:fc"});
    ASSERT_TRUE(start());
    EXPECT_TRUE(manager.stored().empty()) << "taken out, used or not";
    EXPECT_TRUE(wait_until([&] { return anogate::open_udp(endpoint(old.text()), false).has_value(); }));
    char byte = 0;
    EXPECT_TRUE(wait_until([&] { return ::read(device.fd(), &byte, 1) < 0 && errno == EIO; })) << "nobody has the port open";
}

TEST_F(Restart, a_stored_port_is_not_used_for_another_device) {
    PtyDevice before{dir / "before"};
    std::filesystem::create_symlink(before.terminal(), dir / "fc");
    configure({"serial:" + (dir / "fc") + ",name=fc", "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    ASSERT_EQ(manager.stop(*service), 0);
    PtyDevice now{dir / "now"};
    std::filesystem::remove(dir / "fc");
    std::filesystem::create_symlink(now.terminal(), dir / "fc");
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("ground"));
    UdpPeer peer;
    peer.send(ground(), frame(host, 0xFF, 0x05));
    EXPECT_TRUE(receives(now, frame(host, 0xFF, 0x05)));
    EXPECT_TRUE(before.heard().empty());
}

TEST_F(Restart, a_port_that_was_unplugged_meanwhile_is_reopened) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc"));
    ASSERT_EQ(manager.stop(*service), 0);
    device.unplug();
    device.plug();
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc"));
    device.write(frame(fc, 0xFF, 0x06));
    EXPECT_TRUE(knows("0xDC"));
}

TEST_F(Restart, applies_the_current_settings) {
    PtyDevice device{dir / "fc"};
    UdpPeer peer;
    const std::string to_peer = "udp:" + peer.local().text() + ",name=peer";
    configure({"serial:" + device.path() + ",name=fc,baud=115200", to_peer + ",rate=1000", "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("peer") && service->until_up("ground"));
    EXPECT_EQ(service->link("fc").at("baud"), 115200);
    const auto port = service->port("peer");
    const anogate::Endpoint before = ground();
    std::uint16_t free_port = 0;
    { free_port = UdpPeer{}.port(); }
    configure({"serial:" + device.path() + ",name=fc,baud=57600,stop_bits=2", to_peer,
               "udp-listen:127.0.0.1:" + std::to_string(free_port) + ",name=ground"});
    ASSERT_TRUE(restart());
    ASSERT_TRUE(service->until_up("fc") && service->until_up("peer") && service->until_up("ground"));
    EXPECT_EQ(service->link("fc").at("baud"), 57600);
    EXPECT_NE(device.settings().c_cflag & CSTOPB, 0u);
    EXPECT_EQ(service->port("peer"), port) << "the same socket";
    EXPECT_EQ(service->port("ground"), free_port) << "another one";
    EXPECT_TRUE(manager.stored().empty());
    EXPECT_TRUE(anogate::open_udp(endpoint(before.text()), false));
}

TEST_F(Restart, invalid_stored_state_is_ignored) {
    PtyDevice device{dir / "fc"};
    configure({"serial:" + device.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground"});
    for (const char* junk : {"", "null", "[]", R"({"format": 1})", R"({"format": 2, "unread_since": [0, 0, 0], "links": []})",
                             R"({"format": 1, "unread_since": [0, 0, 0], "links": [{"name": "fc"}]})",
                             R"({"format": 1, "unread_since": [0, 0, 0], "links": [{"name": "fc", "rest": "zz", "peers": [],
                                 "channels": [{"peer": "x", "addresses": [[300, -1]]}]}]})"}) {
        manager.forget();
        manager.stored().emplace("state", anogate::UniqueFd{::open(dir.write("junk", junk).c_str(), O_RDONLY | O_CLOEXEC)});
        manager.stored().emplace("wire", anogate::UniqueFd{::open("/dev/null", O_RDWR | O_CLOEXEC)});
        manager.stored().emplace("wire", anogate::UniqueFd{::open("/", O_RDONLY | O_CLOEXEC)});
        manager.stored().emplace("of another program", anogate::UniqueFd{::socket(AF_UNIX, SOCK_STREAM, 0)});
        ASSERT_TRUE(start()) << junk;
        EXPECT_TRUE(service->until_up("fc") && service->until_up("ground")) << junk;
        EXPECT_TRUE(manager.stored().empty());
        EXPECT_EQ(manager.stop(*service), 0);
    }
}

}    // namespace
}    // namespace restart_tests
