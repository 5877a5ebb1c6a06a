// A gateway whose settings change while frames pass.
#include <config/difference.hpp>
#include <support/numbered_frames.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

namespace change_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::Settings;

constexpr std::uint8_t host = 0xFE, fc = 0xDC, gps = 0xDD;

class Change : public testing::Test {
protected:
    void start(const Settings& settings) { gateway = std::make_unique<RunningGateway>(settings); }
    void begin_change(const Settings& settings, anogate::Duration limit = 300ms) {
        changed = false;
        gateway->gateway().change(settings, anogate::difference(gateway->gateway().settings(), settings), limit,
                                  [this] { changed = true; });
    }
    void change(const Settings& settings) {
        begin_change(settings);
        EXPECT_TRUE(gateway->until([this] { return changed; }));
    }
    bool receives(UdpPeer& peer, const Bytes& bytes) {
        return gateway->until([&] {
            const Bytes& all = peer.heard();
            return std::search(all.begin(), all.end(), bytes.begin(), bytes.end()) != all.end();
        });
    }
    std::vector<std::string> names() {
        std::vector<std::string> names;
        const auto now = gateway->status();
        for (const auto& link : now.at("links")) names.push_back(link.at("name"));
        return names;
    }

    TempDir dir;
    std::unique_ptr<RunningGateway> gateway;
    bool changed = false;
};

// A command for a device that was known before its link was changed is sent there, not to the only other device.
TEST_F(Change, commands_for_a_device_of_a_changed_link_do_not_reach_others) {
    constexpr std::uint8_t other_device = 0x21;
    PtyDevice device{dir / "fc"}, old{dir / "old"};
    UdpPeer ground;
    Settings settings = settings_of({serial("fc", device.path()), serial("old", old.path()), udp_listen("ground")});
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("old"));
    device.write(numbered(fc, host, 1));
    old.write(numbered(other_device, host, 1));
    ASSERT_TRUE(gateway->until([&] { return !gateway->route("0xDC").is_null() && !gateway->route("0x21").is_null(); }));
    const auto command = [&](std::uint8_t to, std::uint8_t number) { return frame(host, to, 0xC0, {1, 2, 3, number}); };
    const auto gets = [&](PtyDevice& who, const Bytes& bytes) {
        return gateway->until([&] {
            const Bytes all = who.heard();
            return std::search(all.begin(), all.end(), bytes.begin(), bytes.end()) != all.end();
        });
    };
    const auto remake = [&](auto change_link) {
        change_link(settings.links[0]);
        change(settings);
        ASSERT_TRUE(gateway->until_up(settings.links[0].name));
    };
    std::uint8_t number = 0;
    for (const auto& changed_link : std::vector<std::function<void(anogate::LinkSettings&)>>{
             [](auto& link) { link.template as<anogate::SerialSettings>().baud = 115200; },
             [](auto& link) { link.name = "vehicle"; }, [](auto& link) { link.latency = 50ms; }}) {
        remake(changed_link);
        const auto sent = gateway->count("old", "frames_out");
        ++number;
        ground.send(gateway->port("ground"), command(fc, number));
        EXPECT_TRUE(gets(device, command(fc, number))) << int{number};
        EXPECT_EQ(gateway->count("old", "frames_out"), sent) << int{number};
    }
    // This includes the silent old device: a command for an unknown address does not reach it.
    settings.links[1].latency = 50ms;
    change(settings);
    ASSERT_TRUE(gateway->until_up("old"));
    ground.send(gateway->port("ground"), command(0x44, 1));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("ground", "no_route") == 1; }));
    EXPECT_EQ(gateway->count("old", "frames_out"), 0u);
}

// 10,000 numbered frames each way between a serial port and a listening peer, while all other links change 50 times.
TEST_F(Change, unchanged_links_lose_no_frame_in_fifty_changes) {
    constexpr int frames = 10'000, changes = 50;
    stay_on_one_processor();
    PtyDevice device{dir / "fc"};
    PtyDevice other{dir / "other"};
    auto port = serial("fc", device.path());
    port.as<anogate::SerialSettings>().pace = anogate::Pace::off;
    auto ground = udp_listen("ground");
    ground.queue = port.queue = 1 << 20;
    Settings settings = settings_of({port, ground});
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("ground"));
    UdpPeer peer;
    const auto to = gateway->port("ground");
    Stream up{fc, host}, down{host, fc};
    Bytes rest;
    int changes_begun = 0;
    const auto exchange = [&] {
        for (int i = 0; i < 20 && up.may_go_on(frames); ++i) {
            const Bytes next = up.next();
            ASSERT_EQ(device.write(next), next.size());
        }
        for (int i = 0; i < 20 && down.may_go_on(frames); ++i) peer.send(to, down.next());
        up.take(peer.frames());
        down.take(frames_of(device, rest));
    };
    peer.send(to, down.next());    // registered as a peer from here on
    ASSERT_TRUE(gateway->until([&] { return gateway->count("ground", "frames_in") == 1; }));
    changed = true;
    ASSERT_TRUE(gateway->until(
        [&] {
            exchange();
            if (changed && changes_begun < changes && up.came() >= changes_begun * (frames / changes)) {
                const int n = ++changes_begun;
                settings.links = n % 3 == 0 ? std::vector{ground, port} : std::vector{port, ground};
                if (n % 2) settings.links.insert(settings.links.begin(), serial("other" + std::to_string(n % 4), other.path()));
                if (n % 5 < 3) settings.links.push_back(udp("udp" + std::to_string(n), peer.local().text()));
                if (n % 7 < 3) settings.links.push_back(pty("app", dir / ("app" + std::to_string(n % 7))));
                settings.routes.clear();
                if (n % 2) settings.routes.push_back({30, 40, "other" + std::to_string(n % 4)});
                settings.gateway.id = static_cast<std::uint8_t>(100 + n);
                begin_change(settings, 50ms);
            }
            return up.came() == frames && down.came() == frames && changes_begun == changes && changed;
        },
        120s))
        << up.came() << " and " << down.came() << ", " << changes_begun;
    EXPECT_EQ(gateway->count("fc", "frames_in"), frames) << "counters go on";
    EXPECT_EQ(gateway->count("ground", "frames_in"), frames);
    EXPECT_EQ(gateway->count("fc", "frames_out"), frames);
    EXPECT_EQ(gateway->link("ground").at("channels").size(), 1u);
    EXPECT_EQ(gateway->route("0xDC").at("links"), nlohmann::json::array({"fc"}));
    EXPECT_EQ(gateway->status().at("conflicts").size(), 0u);
    EXPECT_TRUE(gateway->counters_add_up());
}

TEST_F(Change, a_changed_link_starts_again_and_a_removed_one_is_forgotten) {
    PtyDevice device{dir / "fc"}, other{dir / "gps"};
    UdpPeer peer;
    Settings settings = settings_of(
        {serial("fc", device.path()), serial("gps", other.path()), udp("ground", peer.local().text())});
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("gps"));
    device.write(numbered(fc, host, 1));
    other.write(numbered(gps, host, 1));
    ASSERT_TRUE(gateway->until([&] { return !gateway->route("0xDC").is_null() && !gateway->route("0xDD").is_null(); }));
    settings.links[0].as<anogate::SerialSettings>().baud = 115200;
    settings.links.erase(settings.links.begin() + 1);
    change(settings);
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "ground"}));
    EXPECT_EQ(gateway->link("fc").at("baud"), 115200);
    EXPECT_EQ(gateway->count("fc", "frames_in"), 0u);
    EXPECT_TRUE(gateway->route("0xDC").is_null());
    EXPECT_TRUE(gateway->route("0xDD").is_null());
    ASSERT_TRUE(gateway->until_up("fc"));
    device.write(numbered(fc, host, 2));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("fc", "frames_in") == 1; }));
    settings.links.push_back(serial("again", other.path()));
    change(settings);
    ASSERT_TRUE(gateway->until_up("again")) << "the port was given back";
    other.write(numbered(gps, host, 3));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("again", "frames_in") == 1; }));
}

TEST_F(Change, two_links_can_swap_their_ports) {
    PtyDevice one{dir / "one"}, two{dir / "two"};
    auto a = udp_listen("a"), b = udp_listen("b");
    Settings settings = settings_of({serial("s1", one.path()), serial("s2", two.path()), a, b});
    start(settings);
    ASSERT_TRUE(gateway->until_up("s1") && gateway->until_up("s2") && gateway->until_up("a") && gateway->until_up("b"));
    const auto at_a = gateway->port("a"), at_b = gateway->port("b");
    const auto at = [](std::uint16_t port) { return endpoint("127.0.0.1:" + std::to_string(port)); };
    settings.links[2].as<anogate::UdpListenSettings>().local = at(at_b);
    settings.links[3].as<anogate::UdpListenSettings>().local = at(at_a);
    std::swap(settings.links[0].as<anogate::SerialSettings>().device, settings.links[1].as<anogate::SerialSettings>().device);
    change(settings);
    EXPECT_TRUE(gateway->until_up("s1") && gateway->until_up("s2") && gateway->until_up("a") && gateway->until_up("b"));
    EXPECT_EQ(gateway->port("a"), at_b);
    two.write(numbered(fc, host, 1));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("s1", "frames_in") == 1; }));
}

TEST_F(Change, frames_queued_on_a_removed_link_are_sent_first) {
    PtyDevice slow{dir / "slow"};
    auto port = serial("slow", slow.path());
    port.as<anogate::SerialSettings>().baud = 9600;    // 1 kB/s: sending takes a while
    UdpPeer peer;
    Settings settings = settings_of({port, udp_listen("ground")});
    start(settings);
    ASSERT_TRUE(gateway->until_up("slow") && gateway->until_up("ground"));
    for (int i = 0; i < 10; ++i)
        peer.send(gateway->port("ground"), frame(host, 0xFF, 0xF1, Bytes(100, static_cast<std::uint8_t>(i))));
    ASSERT_TRUE(gateway->until([&] { return gateway->count("ground", "frames_in") == 10; }));
    EXPECT_GT(gateway->count("slow", "waiting"), 0u);
    settings.links.erase(settings.links.begin());
    std::size_t came = 0;
    Bytes rest;
    begin_change(settings, 5s);
    EXPECT_TRUE(gateway->until([&] {
        came += frames_of(slow, rest).size();
        return changed;
    }));
    EXPECT_TRUE(gateway->until([&] { return (came += frames_of(slow, rest).size()) == 10; })) << came;
    EXPECT_TRUE(rest.empty());
}

TEST_F(Change, a_removed_link_that_accepts_nothing_is_not_waited_for_long) {
    PtyDevice stuck{dir / "stuck"};
    auto port = serial("stuck", stuck.path());
    port.as<anogate::SerialSettings>().pace = anogate::Pace::off;
    UdpPeer peer;
    Settings settings = settings_of(
        {port, udp_listen("ground"), serial("absent", dir / "absent"), pty("unread", dir / "unread")});
    start(settings);
    ASSERT_TRUE(gateway->until_up("stuck") && gateway->until_up("ground"));
    PortUser user{dir / "unread"};
    ASSERT_TRUE(gateway->until_up("unread"));
    ASSERT_TRUE(gateway->until([&] {
        for (int i = 0; i < 20; ++i) peer.send(gateway->port("ground"), frame(host, 0xFF, 0xA0, Bytes(200, 1)));
        return gateway->count("stuck", "waiting") > 0 && gateway->count("unread", "waiting") > 0;
    }));
    settings.links = {settings.links[1]};
    const auto begin = anogate::Clock::now();
    change(settings);
    EXPECT_LT(anogate::Clock::now() - begin, 5s);
    EXPECT_EQ(names(), std::vector<std::string>{"ground"});
    EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(dir / "unread")));
    const auto came = gateway->count("ground", "frames_in");
    peer.send(gateway->port("ground"), numbered(host, 0xFF, 1));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("ground", "frames_in") == came + 1; }));
}

TEST_F(Change, half_a_frame_received_before_a_change_is_completed_after_it) {
    PtyDevice device{dir / "fc"};
    UdpPeer peer;
    Settings settings = settings_of({serial("fc", device.path()), udp("ground", peer.local().text())});
    settings.links[0].as<anogate::SerialSettings>().baud = 110;    // at this rate half a frame is not overdue soon
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc"));
    const Bytes whole = numbered(fc, host, 7);
    device.write(std::span{whole}.first(9));
    ASSERT_TRUE(gateway->until([&] { return gateway->count("fc", "bytes_in") == 9; }));
    settings.links.push_back(sim("sim"));
    settings.links.back().flood = false;
    change(settings);
    settings.links.pop_back();
    change(settings);
    device.write(std::span{whole}.subspan(9));
    EXPECT_TRUE(receives(peer, whole));
    device.write(std::span{whole}.first(9));    // and one on a removed link has no effect on the others
    ASSERT_TRUE(gateway->until([&] { return gateway->count("fc", "bytes_in") == whole.size() + 9; }));
    settings.links[0].max_data = 100;
    change(settings);
    ASSERT_TRUE(gateway->until_up("fc"));
    const Bytes next = numbered(fc, host, 8);
    device.write(next);
    EXPECT_TRUE(receives(peer, next));
    EXPECT_EQ(gateway->count("fc", "skipped_bytes"), 0u);
}

TEST_F(Change, a_changed_link_waits_for_its_new_device) {
    Settings settings = settings_of({serial("fc", dir / "old")});
    start(settings);
    ASSERT_TRUE(gateway->until_waiting("fc"));
    settings.links[0] = serial("fc", dir / "new");
    change(settings);
    PtyDevice old{dir / "old"};
    PtyDevice device{dir / "new"};
    EXPECT_TRUE(gateway->until_up("fc"));
    EXPECT_EQ(gateway->link("fc").at("device"), device.path());
}

TEST_F(Change, a_link_counts_as_required_at_the_start_only) {
    Settings settings = settings_of({sim("fc")});
    settings.links[0].required = true;
    start(settings);
    settings.links.push_back(serial("late", dir / "absent"));
    settings.links.back().required = true;
    change(settings);
    EXPECT_EQ(gateway->missing(), "");
    gateway->run_for(100ms);
    EXPECT_EQ(gateway->missing(), "");
}

TEST_F(Change, routes_aliases_and_unknown_follow_the_links) {
    UdpPeer a, b;
    PtyDevice device{dir / "flow"};
    Settings settings = settings_of({udp("a", a.local().text()), udp("b", b.local().text()), serial("flow", device.path())}, {},
                                    {{50, 60, "a"}});
    settings.gateway.unknown = anogate::Unknown::link;
    settings.gateway.unknown_link = "a";
    start(settings);
    ASSERT_TRUE(gateway->until_up("flow"));
    const auto goes_to = [&](std::uint8_t address, UdpPeer& peer, UdpPeer& not_peer) {
        static int number = 100;
        const Bytes f = numbered(gps, address, ++number);
        device.write(f);
        return receives(peer, f) && not_peer.frames().empty();
    };
    EXPECT_TRUE(goes_to(55, a, b));
    EXPECT_TRUE(goes_to(70, a, b));
    settings.routes = {{50, 52, "a"}, {55, 60, "b"}};
    settings.gateway.unknown_link = "b";
    change(settings);
    a.frames(), b.frames();
    EXPECT_TRUE(goes_to(51, a, b));
    EXPECT_TRUE(goes_to(55, b, a));
    EXPECT_TRUE(goes_to(70, b, a));
    settings.links[1].mtu = 500;    // changed: a different link with the same name
    change(settings);
    a.frames(), b.frames();
    EXPECT_TRUE(goes_to(55, b, a));
    EXPECT_TRUE(goes_to(70, b, a));
    settings.aliases = {{"flow", gps, 31}};
    change(settings);
    ASSERT_TRUE(gateway->until_up("flow"));
    EXPECT_EQ(gateway->route("0x1F").at("via"), "pinned");
    device.write(numbered(gps, 51, 1));
    EXPECT_TRUE(receives(a, numbered(31, 51, 1)));
    settings.aliases.clear();
    change(settings);
    ASSERT_TRUE(gateway->until_up("flow"));
    EXPECT_TRUE(gateway->route("0x1F").is_null());
    a.frames();
    device.write(numbered(gps, 51, 2));
    EXPECT_TRUE(receives(a, numbered(gps, 51, 2)));
}

TEST_F(Change, links_share_a_group_exactly_if_their_group_names_are_equal) {
    UdpPeer a, b, c;
    PtyDevice device{dir / "fc"};
    Settings settings = settings_of({serial("fc", device.path()), udp("a", a.local().text()), udp("b", b.local().text())});
    settings.links[1].group = settings.links[2].group = "one";
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc"));
    const auto number_of = [&](const std::string& name) {
        for (std::uint8_t n = 1; n < 10; ++n)
            for (const auto id : gateway->gateway().forwarder().router().group(n))
                if (gateway->gateway().link(id).name() == name) return int{n};
        return 0;
    };
    const int one = number_of("a");
    EXPECT_EQ(number_of("b"), one);
    settings.links.push_back(udp("c", c.local().text()));
    settings.links.back().group = "two";
    change(settings);
    EXPECT_NE(number_of("c"), one);
    settings.links[1].group = settings.links[2].group = settings.links[3].group = "three";
    change(settings);
    EXPECT_EQ(number_of("a"), number_of("c"));
    EXPECT_EQ(number_of("b"), number_of("c"));
    for (int i = 0; i < 100; ++i) {    // the numbers of links are reused
        settings.links[1].group = "name" + std::to_string(i);
        begin_change(settings, 0ms);
        ASSERT_TRUE(gateway->until([this] { return changed; }));
    }
    EXPECT_LT(number_of("a"), 5);
    EXPECT_GT(number_of("a"), 0);
}

TEST_F(Change, the_tunnel_stays_or_restarts) {
    PtyDevice device{dir / "fc"}, other{dir / "radio"};
    UdpPeer peer;
    Settings settings = settings_of({serial("fc", device.path())});
    anogate::TunnelSettings& tunnel = settings.tunnel.emplace();
    tunnel.links = {"fc"};
    tunnel.port = 0;
    tunnel.bind = *anogate::IpAddress::parse("127.0.0.1");
    tunnel.allow = {*anogate::Network::parse("127.0.0.0/8")};
    tunnel.relay = true;
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("tunnel"));
    int number = 100;    // a number forwarded before would be a copy
    const auto carry = [&](PtyDevice& from) {
        const std::uint16_t port = peer.port();
        const Bytes inner = numbered(gps, host, ++number);
        peer.forget();
        from.write(frame(
            fc, 0xE6, 0xB1,
            Bytes{0, 0, 0, 0, 127, 0, 0, 1, static_cast<std::uint8_t>(port), static_cast<std::uint8_t>(port >> 8)} + inner));
        return receives(peer, inner);
    };
    ASSERT_TRUE(carry(device));
    const auto port = gateway->port("tunnel");
    settings.links.push_back(serial("radio", other.path()));
    change(settings);
    EXPECT_EQ(gateway->port("tunnel"), port) << "the same socket";
    ASSERT_TRUE(gateway->until_up("radio"));
    EXPECT_TRUE(carry(device));
    settings.links[0].max_data_out = 200;    // the link that receives the frames is replaced
    change(settings);
    EXPECT_EQ(gateway->port("tunnel"), port);
    ASSERT_TRUE(gateway->until_up("fc"));
    EXPECT_TRUE(carry(device));
    settings.tunnel->links = {"radio"};
    change(settings);
    ASSERT_TRUE(gateway->until_up("tunnel"));
    EXPECT_TRUE(carry(other));
    settings.tunnel.reset();
    change(settings);
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "radio"}));
    EXPECT_EQ(gateway->gateway().tunnel(), nullptr);
    other.write(numbered(gps, host, 6));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("radio", "frames_in") == 2; }));
}

TEST_F(Change, gpio_lines_are_added_and_removed) {
    PtyDevice device{dir / "fc"};
    UdpPeer peer;
    Settings settings = settings_of({serial("fc", device.path()), udp_listen("ground")});
    anogate::GpioSettings lock;    // its chip does not exist, so it counts as on
    lock.chip = "no-such-chip";
    lock.line = "4";
    lock.use = anogate::GpioUse::inhibit;
    lock.links = {"ground"};
    settings.gpio = {lock};
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("ground"));
    const Bytes command = frame(host, 0xFF, 0xC0, {1, 2, 3});
    const auto inhibited = [&] {
        const auto before = gateway->count("ground", "inhibited"), in = gateway->count("ground", "frames_in");
        peer.send(gateway->port("ground"), command);
        EXPECT_TRUE(gateway->until([&] { return gateway->count("ground", "frames_in") > in; }));
        return gateway->count("ground", "inhibited") > before;
    };
    EXPECT_TRUE(inhibited());
    settings.links[1].mtu = 600;
    change(settings);
    ASSERT_TRUE(gateway->until_up("ground"));
    EXPECT_TRUE(inhibited()) << "the switch is for the link of this name";
    anogate::GpioSettings lamp = lock;
    lamp.use = anogate::GpioUse::link_up;
    lamp.line = "5";
    lamp.links.clear();
    lamp.link = "fc";
    settings.gpio = {lamp, lock};
    change(settings);
    EXPECT_TRUE(inhibited());
    EXPECT_EQ(gateway->status().at("gpio").size(), 2u);
    settings.gpio = {lamp};
    change(settings);
    EXPECT_FALSE(inhibited());
    settings.gpio = {};
    change(settings);
    EXPECT_EQ(gateway->status().at("gpio").size(), 0u);
}

TEST_F(Change, a_new_link_gets_a_channel_even_if_peers_use_them_all) {
    PtyDevice device{dir / "fc"};
    std::vector<anogate::LinkSettings> listening;
    for (const char* name : {"a", "b", "c", "d"}) {
        listening.push_back(udp_listen(name));
        listening.back().as<anogate::UdpListenSettings>().max_peers = 24;    // a quarter is reserved
        listening.back().broadcast = listening.back().flood = false;
    }
    Settings settings = settings_of(listening);
    start(settings);
    ASSERT_TRUE(gateway->until_up("d"));
    std::vector<std::unique_ptr<UdpPeer>> peers;
    for (int i = 0; i < 64; ++i) {
        peers.push_back(std::make_unique<UdpPeer>());
        peers.back()->send(gateway->port(listening[static_cast<std::size_t>(i % 4)].name), numbered(host, 0xFF, i));
    }
    ASSERT_TRUE(gateway->until([&] { return gateway->gateway().forwarder().channels().size() == 64; }));
    settings.links.push_back(serial("fc", device.path()));
    change(settings);
    ASSERT_TRUE(gateway->until_up("fc"));
    device.write(numbered(fc, host, 1));
    EXPECT_TRUE(gateway->until([&] { return gateway->count("fc", "frames_in") == 1; }));
}

TEST_F(Change, a_stop_while_links_are_removed_ends_the_gateway_without_finishing_the_change) {
    PtyDevice stuck{dir / "stuck"};
    UdpPeer peer;
    Settings settings = settings_of({serial("stuck", stuck.path()), udp_listen("ground")});
    start(settings);
    ASSERT_TRUE(gateway->until_up("stuck") && gateway->until_up("ground"));
    ASSERT_TRUE(gateway->until([&] {
        for (int i = 0; i < 20; ++i) peer.send(gateway->port("ground"), frame(host, 0xFF, 0xA0, Bytes(200, 1)));
        return gateway->count("stuck", "waiting") > 0;
    }));
    settings.links.erase(settings.links.begin());
    begin_change(settings, 10s);
    gateway->run_for(20ms);
    gateway->stop(50ms);
    EXPECT_FALSE(changed);
}

// The port is readable and writable when the link is removed: one of these calls is queued after the change.
TEST_F(Change, a_queued_callback_of_a_removed_link_still_finds_its_link) {
    PtyDevice device{dir / "fc"};
    auto port = serial("fc", device.path());
    port.as<anogate::SerialSettings>().pace = anogate::Pace::off;
    UdpPeer peer;
    Settings settings = settings_of({port, udp_listen("ground")});
    start(settings);
    ASSERT_TRUE(gateway->until_up("fc") && gateway->until_up("ground"));
    ASSERT_TRUE(gateway->until([&] {
        for (int i = 0; i < 20; ++i) peer.send(gateway->port("ground"), frame(host, 0xFF, 0xF1, Bytes(200, 1)));
        return gateway->count("fc", "waiting") > 0;
    }));
    settings.links.erase(settings.links.begin());
    begin_change(settings, 0ms);
    device.heard();
    device.write(numbered(fc, host, 1));
    std::this_thread::sleep_for(30ms);    // until the change is due as well
    EXPECT_TRUE(gateway->until([this] { return changed; }));
    gateway->run_for(5ms);
    EXPECT_EQ(names(), std::vector<std::string>{"ground"});
}

// Calls that the loop still holds for a removed link must access no destroyed object; all are due at once.
TEST_F(Change, pending_callbacks_of_removed_links_access_no_destroyed_object) {
    PtyDevice device{dir / "fc"};
    UdpPeer peer, listener;
    Settings without = settings_of({udp_listen("stays")});
    start(without);
    ASSERT_TRUE(gateway->until_up("stays"));
    for (int round = 0; round < 60; ++round) {
        Settings with = without;
        with.links.push_back(serial("fc", device.path()));
        with.links.push_back(udp("udp", listener.local().text()));
        with.links.push_back(udp_listen("ground"));
        with.links.push_back(pty("app", dir / "app"));
        with.links.push_back(sim("sim", 100));
        for (auto& link : with.links) link.rate = 2000;
        with.links[0].rate = 0;
        with.links.back().rate = 0;
        with.tunnel.emplace().port = 0;
        with.tunnel->links = {"fc"};
        change(with);
        PortUser user{dir / "app"};
        gateway->until([&] { return gateway->up("fc") && gateway->up("ground"); });
        const auto port = gateway->port("ground");
        for (int i = 0; i < 30; ++i) {    // all of them wait in the kernel when the links are removed
            peer.send(port, frame(host, 0xFF, 0xA0, Bytes(60, 1)));
            device.write(numbered(fc, 0xFF, i));
            user.write(numbered(gps, 0xFF, i));
            listener.send(gateway->port("stays"), numbered(gps, host, i));
        }
        if (round % 3 == 0) gateway->run_for(1ms);
        if (round % 4 == 0) device.unplug();
        if (round % 5 == 0) user.close();
        begin_change(without, round % 2 ? 0ms : 20ms);
        if (round % 3 == 1) gateway->run_for(1ms);
        ASSERT_TRUE(gateway->until([this] { return changed; }));
        if (round % 4 == 0) device.plug();
    }
    EXPECT_EQ(names(), std::vector<std::string>{"stays"});
    EXPECT_TRUE(gateway->counters_add_up());
}

}    // namespace
}    // namespace change_tests
