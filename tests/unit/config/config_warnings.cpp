// Valid configurations that are probably not intended.
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_warnings_tests {
namespace {

TEST(Config, warns_of_a_device_whose_address_is_a_port_id) {
    const auto warnings = [](const std::string& from, const std::string& more = "") {
        return lines(parse_config(R"({"links": [{"kind": "sim", "device": "fc", "receive": {"allow_sources": [)" + from + "]}" +
                                  more + R"(}, "pty:/tmp/x,id=5"]})")
                         .warnings);
    };
    EXPECT_EQ(warnings("\"0xDC\", 4"), "");
    EXPECT_EQ(warnings("\"1-254\""), "") << "everybody";
    EXPECT_EQ(warnings("5"),
              "anogated: /links/0/receive/allow_sources: warning: a device with the address 5 can't be reached: it is also the "
              "port id of 'x' (/links/1: LINK 'pty:/tmp/x,id=5'), and frames to it go there; change one of them\n");
    EXPECT_NE(warnings("\"1-20\""), "");
    EXPECT_EQ(
        lines(
            parse_config(R"({"links": [{"kind": "sim", "device": "fc", "id": 5, "receive": {"allow_sources": [5]}}]})").warnings),
        "")
        << "frames to it go to this very link";
}

TEST(Config, warns_of_frames_that_block_a_slow_line) {
    const auto warnings = [](const std::string& link) { return lines(parse_config("{\"links\": [\"" + link + "\"]}").warnings); };
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=500000"), "");
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,max_data=1140"), "");
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,pace=off"), "");
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=115200").find("takes 356 ms at 11520 bytes/s"), std::string::npos);
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=115200").find("a frame of max_data_out 4096 takes"), std::string::npos);
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=115200,max_data_out=4096").find("max_data_out 1144 keeps"), std::string::npos);
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=115200").find("max_data_out 1144 keeps this below 100 ms"), std::string::npos);
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=5000").find("max_data_out 492"), std::string::npos);
    EXPECT_EQ(warnings("udp:127.0.0.1:5,rate=5000,max_data_out=492"), "") << "100 ms";
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=80").find("max_data_out 0 keeps this below 100 ms"), std::string::npos);
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,profile=vendor"), "") << "what leaves is meant, not what comes in";
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,max_data_out=1140"), "");
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=9600,profile=vendor").find("a frame of max_data_out 198 takes 214 ms"),
              std::string::npos);
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=9600,profile=vendor").find("max_data_out 88 keeps this below 100 ms"),
              std::string::npos);
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=79").find("even a frame without DATA takes more than 100 ms"), std::string::npos);
}

TEST(Config, allows_hello_only_where_it_is_possible) {
    EXPECT_NE(
        faults_of({"udp-listen:0.0.0.0:12333,hello=on"}).find("'hello' is not possible on udp-listen, which learns its peers"),
        std::string::npos);
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:12333,hello=off"}), "");
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:12333,profile=vendor"}), "");
    const Draft draft = parse_config(
        R"({"links": ["serial:/dev/x,broadcast=no,hello=on", "serial:/dev/y,broadcast=no,profile=vendor"]})");
    EXPECT_EQ(draft.errors.size(), 0u);
    ASSERT_EQ(draft.warnings.size(), 1u);
    EXPECT_NE(draft.warnings[0].what.find("broadcast=no keeps off this link"), std::string::npos);
    EXPECT_EQ(lines(parse_config(R"({"links": ["serial:/dev/x,broadcast=no,hello=off"]})").warnings), "");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "serial", "device": "/dev/x", "hello": true}]})"), "");
    EXPECT_NE(faults_in(R"({"links": [{"kind": "serial", "device": "/dev/x", "hello": 2}]})")
                  .find("'hello' must be off, on, or a duration"),
              std::string::npos);
}

TEST(Config, warns_of_peers_that_may_use_too_much_memory_for_a_small_computer) {
    const auto warnings = [](const std::string& link) { return lines(parse_config("{\"links\": [\"" + link + "\"]}").warnings); };
    EXPECT_EQ(warnings("udp-listen:0.0.0.0:1"), "");
    EXPECT_EQ(warnings("udp-listen:0.0.0.0:1,queue=1000000,max_peers=64"), "");
    EXPECT_NE(warnings("udp-listen:0.0.0.0:1,queue=1000001,max_peers=64").find("more than 64 MB: reduce 'queue' or 'max_peers'"),
              std::string::npos);
    EXPECT_EQ(warnings("serial:/dev/ttyS0,queue=60000000"), "");
}

TEST(Config, warns_of_more_peers_than_channels) {
    const auto warnings = [](const std::string& links) { return lines(parse_config("{\"links\": [" + links + "]}").warnings); };
    const std::string half = R"("tcp-listen:127.0.0.1:1,max_peers=32")", other = R"("udp-listen:127.0.0.1:2,max_peers=31")";
    EXPECT_EQ(warnings(half + ", " + other + ", \"sim:fc\""), "");
    const std::string text = warnings(half + ", " + other + R"(, "sim:fc", "sim:imu")");
    EXPECT_NE(text.find("LINK 'tcp-listen:127.0.0.1:1,max_peers=32': "), std::string::npos) << text;
    EXPECT_NE(text.find("the links may have 65 channels together, and the gateway has 64"), std::string::npos) << text;
}

TEST(Config, warns_of_a_listening_link_of_a_group_without_trusted_peers) {
    const auto warns = [](const std::string& link) {
        const auto config = parse_config("{\"links\": [\"sim:fc,group=a\", \"" + link + "\"]}");
        return lines(config.warnings).find("without 'trusted', no peer of this link is in the group") != std::string::npos;
    };
    for (const std::string kind : {"udp-listen", "tcp-listen"}) {
        EXPECT_TRUE(warns(kind + ":127.0.0.1:1,group=a"));
        EXPECT_FALSE(warns(kind + ":127.0.0.1:1,group=a,trusted=10.0.0.7"));
        EXPECT_FALSE(warns(kind + ":127.0.0.1:1,group=a,trusted=any"));
        EXPECT_FALSE(warns(kind + ":127.0.0.1:1"));
    }
    EXPECT_FALSE(warns("udp:10.0.0.7:1,group=a"));
    EXPECT_TRUE(warns("tls-listen:127.0.0.1:1,group=a,certificate=a,key=b,verify=none"));
    EXPECT_FALSE(warns("tls-listen:127.0.0.1:1,group=a,certificate=a,key=b,ca=c")) << "its peers have certificates";
}

TEST(Config, warns_of_more_peers_per_address_than_peers) {
    for (const std::string kind : {"udp-listen", "tcp-listen"}) {
        const auto warnings = [&](const std::string& keys) {
            return lines(parse_config("{\"links\": [\"" + kind + ":127.0.0.1:1," + keys + "\"]}").warnings);
        };
        EXPECT_NE(warnings("max_peers=2,max_per_address=3").find("'max_per_address' 3 has no effect"), std::string::npos) << kind;
        EXPECT_EQ(warnings("max_peers=3,max_per_address=3"), "") << kind;
    }
}

TEST(Config, warns_of_settings_without_a_useful_effect) {
    const auto warnings = [](const std::string& json) { return lines(parse_config(json).warnings); };
    EXPECT_EQ(warnings("{}"), "anogated: warning: the configuration has no links, so no frames will be forwarded\n");
    EXPECT_EQ(warnings(R"({"gateway": {"nme": "boat"}})"), "") << "what else was to be there is not known";
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "gateway": {"id": 199}, "tunnel": {"links": ["fc"]}})"), "");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "gateway": {"id": "0xFE"}})"),
              "anogated: warning: the gateway's own id 0xFE is the address of hosts: the gateway would consume frames to hosts; "
              "choose another id, such as 199\n");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc,group=radio"]})"),
              "anogated: /links/0: LINK 'sim:fc,group=radio': warning: 'fc' is the only link in the group 'radio': the group has "
              "no effect\n");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc,group=a", "pty:/tmp/x,group=a"]})"), "");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "tunnel": {}})"),
              "anogated: /tunnel/links: warning: no tunnel frames are carried: add the links of the devices\n");
}

}    // namespace
}    // namespace anogate::config_warnings_tests
