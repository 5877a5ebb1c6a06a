#include "faults.hpp"

#include <config/difference.hpp>

#include <gtest/gtest.h>

namespace anogate::difference_tests {
namespace {

using Lines = std::vector<std::string>;

Settings settings(const std::string& json) {
    Draft draft = parse_config(json);
    EXPECT_TRUE(draft.errors.empty()) << lines(draft.errors);
    return std::move(draft.settings);
}

Difference between(const std::string& before, const std::string& after) { return difference(settings(before), settings(after)); }

/// "fc changed: baud: 1 -> 2", one line per link.
std::string format_difference(const Difference& difference) {
    std::string all;
    for (const LinkDifference& link : difference.links) {
        all += link.name + " " + std::string{text(link.change)};
        for (const std::string& line : link.differences) all += "; " + line;
        all += "\n";
    }
    return all;
}

TEST(Difference, of_identical_configurations_is_empty) {
    const std::string config = R"({"gateway": {"id": 199}, "links": ["sim:fc", "serial:/dev/x,limit.0x01=50,send.deny=firmware"],
        "routes": [{"address": 3, "link": "fc"}], "tunnel": {"links": ["x"]}, "alias": [{"link": "x", "device": 5, "as": 31}]})";
    const Difference d = between(config, config);
    EXPECT_TRUE(d.is_none());
    EXPECT_EQ(format_difference(d), "fc same\nx same\ntunnel same\n");
    EXPECT_TRUE(d.needs_restart.empty());
}

TEST(Difference, is_reported_link_by_link) {
    const Difference d = between(
        R"({"links": ["serial:/dev/a,baud=500000,name=fc", "sim:fc,name=sim", "serial:/dev/b,name=gps"]})",
        R"({"links": ["pty:/run/x,name=app", "sim:fc,name=sim", "serial:/dev/a,baud=115200,name=fc"]})");
    EXPECT_EQ(format_difference(d), "app added\nsim same\nfc changed; baud: 500000 -> 115200\ngps removed\n");
    EXPECT_FALSE(d.is_none());
    EXPECT_EQ(d.of("app"), Change::added);
    EXPECT_EQ(d.of("gps"), Change::removed);
    EXPECT_EQ(d.of("sim"), Change::same);
    EXPECT_EQ(d.of("nobody"), Change::same);
}

TEST(Difference, names_keys_as_in_the_configuration) {
    const auto of_link = [](const std::string& before, const std::string& after) {
        const Difference d = between("{\"links\": [\"" + before + "\"]}", "{\"links\": [\"" + after + "\"]}");
        return d.links.front().differences;
    };
    EXPECT_EQ(of_link("serial:/dev/x", "serial:/dev/x,id=3"), (Lines{"id: not set -> 3"}));
    EXPECT_EQ(of_link("serial:/dev/x,dtr=on", "serial:/dev/x"), (Lines{"dtr: true -> not set"}));
    EXPECT_EQ(of_link("serial:/dev/x,name=a", "serial:/dev/x,name=a,limit.0x01=50,send.deny=0xB0+0xB1"),
              (Lines{"send.deny: not set -> 0xB0, 0xB1", "limit.0x01: not set -> 50"}));
    EXPECT_EQ(of_link("udp-listen:0.0.0.0:1,name=a,peer_timeout=60s", "udp-listen:0.0.0.0:1,name=a,peer_timeout=2m"),
              (Lines{"peer_timeout: 1m -> 2m"}));
    const Lines kind = of_link("sim:fc,name=a", "pty:/run/a,name=a");
    EXPECT_EQ(kind.front(), "kind: sim -> pty");
}

TEST(Difference, assigns_aliases_and_the_transceiver_to_their_links) {
    const std::string links = R"("links": ["serial:/dev/x,name=bus", "sim:fc"])";
    const Difference alias = between("{" + links + "}",
                                     "{" + links + R"(, "alias": [{"link": "bus", "device": "0xDE", "as": 31}]})");
    EXPECT_EQ(format_difference(alias), "bus changed; alias of 0xDE: not set -> 0x1F\nfc same\n");
    const Difference rs485 = between(
        "{" + links + "}", "{" + links + R"(, "gpio": [{"chip": "gpiochip0", "line": 25, "use": "rs485", "link": "bus"}]})");
    EXPECT_EQ(rs485.of("bus"), Change::changed);
    EXPECT_EQ(rs485.of("fc"), Change::same);
    EXPECT_EQ(rs485.gateway.size(), 1u) << "and the line is new";
    const Difference lamp = between(
        "{" + links + "}", "{" + links + R"(, "gpio": [{"chip": "gpiochip0", "line": 25, "use": "link_up", "link": "bus"}]})");
    EXPECT_EQ(lamp.of("bus"), Change::same);
    EXPECT_EQ(lamp.gateway.size(), 1u);
}

TEST(Difference, of_the_tunnel_is_reported_like_that_of_a_link) {
    const auto with = [](const std::string& more) { return R"({"links": ["sim:fc", "sim:fc,name=two"])" + more + "}"; };
    EXPECT_EQ(between(with(""), with(R"(, "tunnel": {"links": ["fc"]})")).of("tunnel"), Change::added);
    EXPECT_EQ(between(with(R"(, "tunnel": {"links": ["fc"]})"), with("")).of("tunnel"), Change::removed);
    const Difference d = between(with(R"(, "tunnel": {"links": ["fc"]})"),
                                 with(R"(, "tunnel": {"links": ["fc", "two"], "port": 7})"));
    EXPECT_EQ(format_difference(d), "fc same\ntwo same\ntunnel changed; links: fc -> fc, two; port: 12333 -> 7\n");
    EXPECT_EQ(between(with(R"(, "tunnel": {"links": ["fc"]})"), with(R"(, "tunnel": {"links": ["fc"]}, "gateway": {"id": 9})"))
                  .of("tunnel"),
              Change::changed)
        << "tunnel frames to the gateway's id are for it";
    const Difference larger = between(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"]}})",
                                      R"({"links": ["sim:fc,max_data=9000"], "tunnel": {"links": ["fc"]}})");
    EXPECT_EQ(larger.of("tunnel"), Change::changed) << "frames of that size must have room in it";
    const Difference smaller = between(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"]}})",
                                       R"({"links": ["sim:fc,max_data=90"], "tunnel": {"links": ["fc"]}})");
    EXPECT_EQ(smaller.of("tunnel"), Change::same);
}

TEST(Difference, lists_other_changes_that_need_a_restart) {
    const Difference d = between(
        R"({"links": ["sim:fc"], "routes": [{"address": 3, "link": "fc"}, {"address": 4, "link": "fc"}], "log": {"level": "info"}})",
        R"({"links": ["sim:fc"], "routes": [{"address": 4, "link": "fc"}, {"address": 5, "link": "fc"}],
            "gateway": {"forget_after": "1m"}, "control": {"socket": "/run/x"}, "log": {"level": "debug", "file": "/var/log/anogate/x"}})");
    EXPECT_EQ(d.gateway, (Lines{"gateway.forget_after: 30s -> 1m", R"(routes: removed {"address":"0x03","link":"fc"})",
                                R"(routes: added {"address":"0x05","link":"fc"})", "log.level: info -> debug"}));
    EXPECT_EQ(d.needs_restart, (Lines{"control.socket: not set -> /run/x", "log.file: not set -> /var/log/anogate/x"}));
    EXPECT_FALSE(d.is_none());
    EXPECT_TRUE(between(R"({"links": ["sim:fc"]})", R"({"links": ["sim:fc"], "control": {"socket": "/run/x"}})").is_none())
        << "nothing to do while it runs";
}

TEST(Difference, in_recording_settings_takes_effect_at_once) {
    EXPECT_EQ(between("{}", R"({"record": {"keep_last": "5s"}})").needs_restart, Lines{});
    EXPECT_EQ(
        between(R"({"record": {"keep_last": "5s"}})", R"({"record": {"keep_last": "6s", "rotate": {"size": "1MB"}}})").gateway,
        (Lines{"record.rotate.size: 1GB -> 1MB", "record.keep_last: 5s -> 6s"}));
    EXPECT_FALSE(between(R"({"record": {}})", "{}").is_none());
    EXPECT_TRUE(between(R"({"record": {}})", R"({"record": {"start": true}})").is_none());
}

TEST(Difference, reports_a_changed_order_only_for_links) {
    EXPECT_EQ(between(R"({"links": ["sim:fc", "sim:fc,name=b"]})", R"({"links": ["sim:fc,name=b", "sim:fc,name=fc"]})").gateway,
              Lines{"links: another order"});
    EXPECT_TRUE(between(R"({"links": ["sim:fc"], "routes": [{"address": 3, "link": "fc"}, {"address": 4, "link": "fc"}]})",
                        R"({"links": ["sim:fc"], "routes": [{"address": 4, "link": "fc"}, {"address": 3, "link": "fc"}]})")
                    .is_none());
}

TEST(Difference, keeps_running_settings_that_need_a_restart) {
    const Settings running = settings(R"({"control": {"socket": "/run/a"}, "log": {"file": "/var/log/a", "level": "info"}})");
    const Settings wanted = settings(
        R"({"links": ["sim:fc"], "control": {"socket": "/run/b"}, "log": {"file": "/var/log/b", "rotate": 5, "level": "debug"}})");
    const Settings now = without_restart(running, wanted);
    EXPECT_EQ(now.links, wanted.links);
    EXPECT_EQ(now.control, running.control);
    EXPECT_EQ(now.log.file, "/var/log/a");
    EXPECT_EQ(now.log.rotate, running.log.rotate);
    EXPECT_EQ(now.log.level, "debug");
}

}    // namespace
}    // namespace anogate::difference_tests
