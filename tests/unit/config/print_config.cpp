// A printed configuration has the same meaning.
#include <config/values.hpp>
#include <gateway/can_settings.hpp>
#include <gateway/tunnel/tunnel_policy.hpp>
#include <link/serial/pty_settings.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/sim_settings.hpp>
#include <link/udp/udp_settings.hpp>
#include <support/random.hpp>
#include <support/sanitized.hpp>
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::print_config_tests {
namespace {

EndpointSpec random_endpoint(support::Random& random, bool v6) {
    EndpointSpec endpoint;
    endpoint.address = *IpAddress::parse(v6 ? random.of({"::1", "fd00::5", "2001:db8::1:2"})
                                            : random.of({"127.0.0.1", "10.1.2.3", "255.255.255.255"}));
    endpoint.port = static_cast<std::uint16_t>(1 + random.below(65535));
    return endpoint;
}

void give_kind(LinkSettings& link, support::Random& random, const std::string& unique) {
    const std::string kind = random.of({"serial", "udp-listen", "udp", "pty", "sim"});
    link.kind = find_link_kind(kind);
    link.of_kind = link.kind->settings();
    const bool v6 = random.one_in(2);
    if (kind == "serial") {
        const auto line = [&] {
            return random.of({std::optional<bool>{}, std::optional<bool>{true}, std::optional<bool>{false}});
        };
        link.of_kind = SerialSettings{"/dev/" + unique,
                                      1 + random.below(UINT32_MAX),
                                      random.of({Parity::none, Parity::even, Parity::odd}),
                                      static_cast<std::uint8_t>(1 + random.below(2)),
                                      random.of({FlowControl::none, FlowControl::hardware}),
                                      random.one_in(2),
                                      random.of({Pace::automatic, Pace::on, Pace::off}),
                                      line(),
                                      line()};
    } else if (kind == "udp-listen") {
        auto& listen = link.as<UdpListenSettings>();
        listen.local = random_endpoint(random, v6);
        listen.interface = random.of({"", "wg0"});
        listen.peer_timeout = std::chrono::milliseconds{1000 + random.below(86'399'000)};
        listen.max_peers = static_cast<std::uint16_t>(1 + random.below(64));
        if (random.one_in(2)) listen.max_per_address = static_cast<std::uint16_t>(1 + random.below(64));
        listen.trusted_any = random.one_in(3);
        if (!listen.trusted_any && random.one_in(2)) listen.trusted.push_back({random_endpoint(random, false).address, 24});
        listen.allow_any = random.one_in(3);
        for (unsigned i = listen.allow_any ? 0 : random.below(4u); i > 0; --i)
            listen.allow.push_back({random_endpoint(random, i % 2 == 0).address, static_cast<std::uint8_t>(random.below(33))});
    } else if (kind == "udp") {
        auto& udp = link.as<UdpSettings>();
        udp.peer = random_endpoint(random, v6);
        if (random.one_in(2)) udp.bind = EndpointSpec{{*IpAddress::parse(v6 ? "::" : "0.0.0.0"), 0}};
        udp.interface = random.of({"", "wg0"});
    } else if (kind == "can") {
        auto& can = link.as<CanSettings>();
        can.interface = "can" + unique;
        can.fd = random.one_in(2);
        can.brs = random.one_in(2);
        can.extended = random.one_in(2);
        if (random.one_in(2)) {
            can.framing = CanFraming::isotp;
            can.tx = random.below(0x800u);
            can.rx = 0x7FF - *can.tx;
        } else if (random.one_in(2)) {
            can.base = random.below(8u) * (can.extended ? 0x40000 : 0x100);
        }
    } else if (kind == "pty") {
        link.as<PtySettings>().path = "/tmp/ü " + unique;
    } else {
        link.as<SimSettings>().hz = static_cast<std::uint16_t>(1 + random.below(100));
    }
}

RuleSettings random_rules(support::Random& random) {
    RuleSettings rules;
    for (FilterSettings* filter : {&rules.receive, &rules.send}) {
        for (auto* ranges : {&filter->allow, &filter->deny, &filter->allow_sources, &filter->deny_sources,
                             &filter->allow_destinations, &filter->deny_destinations}) {
            for (unsigned i = random.below(3u); i > 0; --i) {
                const auto first = static_cast<std::uint8_t>(random.below(256));
                ranges->push_back({first, static_cast<std::uint8_t>(first + random.below(256u - first))});
            }
        }
    }
    const unsigned limits = random.below(3u);
    for (unsigned i = 0; i < limits; ++i)
        rules.limit.push_back({static_cast<std::uint8_t>(i * 80), random.of({0.001, 12.5, 1.0 / 3, 1e6})});
    return rules;
}

void give_devices(LinkSettings& link, support::Random& random) {
    link.profile = random.of({Profile::none, Profile::vendor, Profile::old});
    if (random.one_in(2)) link.max_data_out = static_cast<std::uint16_t>(random.below(link.max_data + 1u));
    if (random.one_in(2)) link.value_type_7 = random.of({ValueType7::f32, ValueType7::u64});
    if (random.one_in(2)) link.encoding = random.of({TextEncoding::utf8, TextEncoding::gbk});
    if (link.kind->name != "udp-listen" && random.one_in(2))
        link.hello = random.of<Duration>({Duration{}, LinkSettings::usual_hello, std::chrono::milliseconds{1500}});
}

void give_traffic(LinkSettings& link, support::Random& random) {
    const auto duration = [&](unsigned most) { return std::chrono::milliseconds{1 + random.below(most)}; };
    link.group = random.of({"", "vehicle", "飞"});
    link.present_as = link.group.empty() ? random.of<std::uint8_t>({0, 0xFE, 31}) : std::uint8_t{0};
    link.age = {duration(5000), duration(5000), duration(86'400'000)};
    link.rules = random_rules(random);
    if (link.kind->name == "sim") return;
    if (random.one_in(2)) link.frame_gap = duration(10'000);
    if (link.kind->name != "udp-listen") link.gap = random.of<Duration>({Duration{}, duration(1000)});
    link.rate = random.of<std::uint32_t>({0, 1, 5000, 1'000'000'000});
    link.latency = duration(1000);
    if (link.kind->name != "udp" && link.kind->name != "udp-listen") return;
    link.pack = random.one_in(2);
    link.mtu = static_cast<std::uint16_t>(64 + random.below(65444));
}

TunnelSettings random_tunnel(support::Random& random, const std::vector<LinkSettings>& links) {
    const auto address = [&] { return random_endpoint(random, false).address; };
    const auto network = [&] { return Network{address(), static_cast<std::uint8_t>(random.below(33))}; };
    const auto id = [&] { return static_cast<std::uint8_t>(1 + random.below(254)); };
    const auto name = [&] { return links[random.below(links.size())].name; };
    TunnelSettings t;
    for (unsigned i = random.below(4u); i > 0; --i) t.links.push_back(name());
    t.address = id();
    if (random.one_in(2)) t.bind = address();
    t.port = static_cast<std::uint16_t>(random.of({0, 12333, 65535}));
    if (random.one_in(2)) t.ip = address();
    t.deliver = random.of({Deliver::frames, Deliver::tunnel});
    for (unsigned i = random.below(4u); i > 0; --i)
        t.wrap.push_back({network(), name(), random.of<std::uint8_t>({0xB1, 0xB2}), id(), id()});
    for (unsigned i = random.below(4u); i > 0; --i) t.allow.push_back(network());
    t.relay = listed_loopback(t.allow) || random.one_in(2);
    t.rules = random_rules(random);
    return t;
}

/// Random settings without errors.
Settings random_settings(support::Random& random) {
    Settings s;
    s.gateway.id = random.of<std::uint8_t>({0, 21, 199, 254});
    s.gateway.name = random.of({"anogate", "飞机", "a\"b\\c"});
    s.gateway.unknown = random.of({Unknown::flood, Unknown::drop});
    s.gateway.forget_after = std::chrono::milliseconds{1000 + random.below(86'399'000)};
    const unsigned links = random.below(21u);
    for (unsigned i = 0; i < links; ++i) {
        LinkSettings link;
        link.name = random.of({"link ", "链路", "a/b,c=d"}) + std::to_string(i);
        give_kind(link, random, std::to_string(i));
        // No duplicate port.
        if (link.kind->name == "udp-listen") link.as<UdpListenSettings>().local.port = static_cast<std::uint16_t>(1000 + i);
        if (random.one_in(2)) link.id = static_cast<std::uint8_t>(i + 1 == s.gateway.id || i >= 20 ? 0 : i + 1);
        link.max_data = static_cast<std::uint16_t>(random.below(65536));
        link.queue = link.max_data + 8u + random.below(100'000u);
        give_devices(link, random);
        if (random.one_in(2)) link.flood = random.one_in(2);
        if (random.one_in(2)) link.broadcast = random.one_in(2);
        link.required = random.one_in(2);
        give_traffic(link, random);
        s.links.push_back(link);
    }
    for (unsigned i = links == 0 ? 0 : random.below(4u); i > 0; --i) {
        const auto first = static_cast<std::uint8_t>(22 + random.below(100));
        s.routes.push_back({first, static_cast<std::uint8_t>(first + random.below(20)), s.links[random.below(links)].name});
    }
    for (unsigned i = links == 0 ? 0 : random.below(4u); i > 0; --i)
        s.aliases.push_back(
            {s.links[random.below(links)].name, static_cast<std::uint8_t>(150 + i), static_cast<std::uint8_t>(160 + i)});
    for (unsigned i = random.below(4u); i > 0; --i) {
        const auto of_id = static_cast<std::uint8_t>(0xF0 + i);
        ClassSettings& added = s.classes.emplace_back(
            ClassSettings{of_id, random.of({FrameClass::control, FrameClass::telemetry, FrameClass::bulk})});
        if (random.one_in(2)) added.replaces = random.one_in(2);
        if (random.one_in(2)) added.age = std::chrono::milliseconds{1 + random.below(5000u)};
    }
    if (links != 0 && random.one_in(3)) {
        s.gateway.unknown = Unknown::link;
        s.gateway.unknown_link = s.links[0].name;
    }
    if (links != 0 && random.one_in(2)) s.tunnel = random_tunnel(random, s.links);
    s.control.socket = random.of({"", "none", "/tmp/c.sock"});
    if (random.one_in(2)) {
        RecordSettings& record = s.record.emplace();
        record.start = random.one_in(2);
        record.format = random.of({"pcapng", "mcap"});
        record.message_encoding = random.of({"cdr", "json"});
        record.direction = random.one_in(2) ? std::vector<std::string>{"in"} : std::vector<std::string>{"out", "dropped"};
        if (random.one_in(2)) record.ids = {{3, 7}};
        if (links != 0 && random.one_in(2)) record.links = {s.links[0].name};
        record.rotate_size = random.of<std::uint64_t>({0, 10'000, 1'000'000'000});
        if (random.one_in(2)) record.keep_last = std::chrono::seconds{1 + random.below(3600u)};
    }
    s.log.level = random.of({"trace", "debug", "info", "warn", "error"});
    s.log.file = random.of({"", "/var/log/x"});
    s.log.rotate = random.of<std::uint64_t>({0, 1, 1000, 1024, 10'000'000, 3 << 20});
    return s;
}

TEST(PrintConfig, prints_a_configuration_that_reads_back_and_prints_the_same) {
    for (std::uint64_t seed = 0; seed < (support::sanitized ? 100 : 1000); ++seed) {
        support::Random random{seed};
        const Settings settings = random_settings(random);
        const std::string printed = print_config(settings);
        const Draft read = parse_config(printed);
        ASSERT_EQ(lines(read.errors), "") << "seed " << seed << "\n" << printed;
        ASSERT_EQ(read.settings, settings) << "seed " << seed << "\n" << printed;
        ASSERT_EQ(print_config(read.settings), printed) << "seed " << seed;
    }
}

TEST(PrintConfig, leaves_out_keys_that_are_not_set) {
    const std::string printed = print_config(settings_of(R"({"links": ["serial:/dev/x", "udp:1.2.3.4:5"]})"));
    for (const char* key :
         {"\"id\"", "\"dtr\"", "\"rts\"", "\"bind\"", "\"allow\"", "\"interface\"", "\"socket\"", "\"file\"", "\"\""})
        EXPECT_EQ(printed.find(key), std::string::npos) << key;
    for (const char* key : {"\"baud\": 500000", "\"name\": \"x\"", "\"unknown\": \"flood\""})
        EXPECT_NE(printed.find(key), std::string::npos) << key;
}

}    // namespace
}    // namespace anogate::print_config_tests
