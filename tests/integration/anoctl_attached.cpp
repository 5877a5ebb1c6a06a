// `anoctl monitor` without a LINK and `anoctl send`: through the control socket of a running gateway.
#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace anoctl_attached_tests {
namespace {

using namespace support;
using nlohmann::json;

const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

class AnoctlOfAGateway : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(gateway.until_answers()) << gateway.output(); }
    Process anoctl(std::vector<std::string> words) {
        words.insert(words.end(), {"--control", socket});
        return Process{ANOCTL, std::move(words)};
    }
    /// Sends frames until `monitor` shows something: it sees nothing before it is attached.
    bool until_shows(Process& monitor, const std::string& words, const Bytes& bytes = euler) {
        return wait_until([&] {
            a.send(gateway.port("a"), bytes);
            return monitor.output().find(words) != std::string::npos;
        });
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    UdpPeer a, b;
    Daemon gateway{ANOGATED, socket, {a.link("a"), b.link("b")}};
};

TEST_F(AnoctlOfAGateway, monitor_shows_both_directions_and_dropped_frames_with_their_cause) {
    Process monitor = anoctl({"monitor", "--direction", "in", "out", "dropped"});
    EXPECT_TRUE(until_shows(monitor, " in 0xDC 0xFF 0x03 euler rol=1.23 pit=0 yaw=0 fusion_sta=1\n")) << monitor.output();
    EXPECT_TRUE(until_shows(monitor, " out 0xDC 0xFF 0x03 euler ")) << monitor.output();
    EXPECT_TRUE(until_shows(monitor, " dropped no_route 0xDC 0x00 0x03 euler ", frame(0xDC, 0x00, 0x03, {0, 0, 0, 0, 0, 0, 1})))
        << monitor.output();
    monitor.signal(SIGINT);
    EXPECT_EQ(monitor.wait(), 0);
    EXPECT_NE(monitor.output().find(" frames shown\n"), std::string::npos) << monitor.output();
}

TEST_F(AnoctlOfAGateway, monitor_applies_filters_and_ends_after_a_number_of_frames) {
    Process monitor = anoctl({"monitor", "--json", "--direction", "out", "--link", "b", "--id", "euler", "--from", "0xDC", "--to",
                              "0xFF", "--count", "2"});
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), euler);
        return !monitor.is_running();
    }));
    EXPECT_EQ(monitor.wait(), 0) << monitor.output();
    std::istringstream lines{monitor.output()};
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    const json first = json::parse(line);
    EXPECT_EQ(first.at("link"), "b");
    EXPECT_EQ(first.at("direction"), "out");
    EXPECT_EQ(first.at("name"), "euler");
    ASSERT_TRUE(first.contains("peer")) << line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(json::parse(line).at("direction"), "out");
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(line, "anoctl: 2 frames shown");
}

TEST_F(AnoctlOfAGateway, monitor_reports_a_wrong_filter_and_the_end_of_the_gateway) {
    Process wrong = anoctl({"monitor", "--link", "c"});
    EXPECT_EQ(wrong.wait(), 2);
    EXPECT_NE(wrong.output().find("anoctl: there is no link 'c'"), std::string::npos) << wrong.output();
    Process monitor = anoctl({"monitor"});
    ASSERT_TRUE(until_shows(monitor, " in 0xDC")) << monitor.output();
    gateway.signal(SIGTERM);
    EXPECT_EQ(monitor.wait(), 1);
    EXPECT_NE(monitor.output().find("anoctl: the gateway closed the connection"), std::string::npos) << monitor.output();
    Process late = anoctl({"monitor"});
    EXPECT_EQ(late.wait(), 1);
    EXPECT_NE(late.output().find(socket), std::string::npos) << late.output();
}

TEST_F(AnoctlOfAGateway, send_reports_the_links_that_sent_the_frame) {
    Process send = anoctl({"send", "wind", "wind_x=1", "--from", "0xDD"});
    EXPECT_EQ(send.wait(), 0) << send.output();
    EXPECT_NE(send.output().find("sent on a (" + a.local().text() + ")\n"), std::string::npos) << send.output();
    EXPECT_NE(send.output().find("sent on b (" + b.local().text() + ")\n"), std::string::npos) << send.output();
    EXPECT_TRUE(wait_until([&] { return a.heard() == frame(0xDD, 0xFF, 0x09, {1, 0, 0, 0}); }));
    b.forget();
    Process hex = anoctl(
        {"send", "--json", "AB", "DC", "FF", "03", "07", "00", "7B", "00", "00", "00", "00", "00", "01", "0C", "AF"});
    ASSERT_EQ(hex.wait(), 0) << hex.output();
    EXPECT_EQ(json::parse(hex.output()).at("sent").size(), 2u) << hex.output();
}

TEST_F(AnoctlOfAGateway, send_reports_why_a_frame_was_not_sent) {
    Process nowhere = anoctl({"send", "wind", "--to", "0"});
    EXPECT_EQ(nowhere.wait(), 1);
    EXPECT_EQ(nowhere.output(), "anoctl: not sent: control: good frames that had no taker\n");
    Process misspelt = anoctl({"send", "wnd"});
    EXPECT_EQ(misspelt.wait(), 2);
    Process damaged = anoctl({"send", "AB", "DC", "FF", "03", "00", "00", "00", "00"});
    EXPECT_EQ(damaged.wait(), 2);
    EXPECT_NE(damaged.output().find("to find the fault: anoctl decode"), std::string::npos) << damaged.output();
    EXPECT_TRUE(a.heard().empty());
}

// Bytes that are valid text in both encodings: 模 or ģ, "caf茅" or "café".
TEST(AnoctlOfAGatewayTexts, are_decoded_with_the_encoding_that_the_gateway_uses_for_the_link) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    Daemon gateway{ANOGATED,
                   socket,
                   {"udp-listen:127.0.0.1:0,name=utf8,encoding=utf8", "udp-listen:127.0.0.1:0,name=gbk,encoding=gbk",
                    "udp-listen:127.0.0.1:0,name=vendor,profile=vendor"}};
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    const Bytes short_text{0, 0xC4, 0xA3}, with_letters{0, 'c', 'a', 'f', 0xC3, 0xA9};
    struct Case {
        std::string link;
        std::uint8_t address;
        Bytes data;
        std::string words;
    };
    for (const Case& one : {Case{"utf8", 0x11, short_text, "ģ"}, Case{"gbk", 0x12, with_letters, "caf茅"},
                            Case{"vendor", 0x13, with_letters, "caf茅"}}) {
        UdpPeer device;    // a new device, routed to this link from its first frame on
        for (const std::vector<std::string>& words :
             {std::vector<std::string>{"monitor", "--json"}, {"monitor"}, {"log"}, {"log", "--json"}}) {
            SCOPED_TRACE(one.link + " by " + words.front() + ' ' + words.back());
            Process shows{ANOCTL, [&] {
                              auto all = words;
                              all.insert(all.end(), {"--control", socket});
                              return all;
                          }()};
            EXPECT_TRUE(wait_until([&] {
                device.send(gateway.port(one.link), frame(one.address, 0xFE, 0xA0, one.data));
                return shows.output().find(one.words) != std::string::npos;
            })) << shows.output();
            shows.signal(SIGINT);
            shows.wait();
        }
    }
}

}    // namespace
}    // namespace anoctl_attached_tests
