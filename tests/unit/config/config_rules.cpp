// Rules, aliases and foreign addresses of links in a configuration.
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_rules_tests {
namespace {

TEST(Config, rules_are_nested_objects) {
    const Draft draft = parse_config(R"({"links": [{"kind": "sim", "device": "fc", "age": {"control": "50ms"},
        "receive": {"deny": ["firmware", 1, "0x10-0x12"], "allow_sources": [254, "30-40"]},
        "send": {"allow": ["urgent"]}, "limit": {"inertial": 50, "0x03": 12.5}}]})");
    EXPECT_EQ(lines(draft.errors), "");
    const LinkSettings& link = draft.settings.links.at(0);
    EXPECT_EQ(link.age, (AgeLimits{std::chrono::milliseconds{50}}));
    EXPECT_EQ(link.rules.receive.deny, (std::vector<ByteRange>{{0xF0, 0xF0}, {1, 1}, {0x10, 0x12}}));
    EXPECT_EQ(link.rules.receive.allow_sources, (std::vector<ByteRange>{{254, 254}, {30, 40}}));
    EXPECT_TRUE(Filter{link.rules.send}.passes(0xDC, 0xFE, 0xE0));
    EXPECT_FALSE(Filter{link.rules.send}.passes(0xDC, 0xFE, 0x03));
    EXPECT_EQ(link.rules.limit, (std::vector<LimitRule>{{1, 50}, {3, 12.5}}));
}

TEST(Config, errors_in_rules_name_their_location) {
    const auto fault = [](const std::string& keys) {
        return faults_in(R"({"links": [{"kind": "sim", "device": "fc", )" + keys + "}]}");
    };
    EXPECT_EQ(fault(R"("send": {"denny": []})"), "/links/0/send/denny: unknown key 'send.denny' (did you mean 'send.deny'?)\n");
    EXPECT_EQ(fault(R"("send": ["0xB0"])"),
              "/links/0/send: must be an object {...} of allow, deny, allow_sources, deny_sources, allow_destinations, "
              "deny_destinations, not a list\n");
    EXPECT_NE(fault(R"("send": {"deny": ["firmwear"]})").find("(did you mean 'firmware'?)"), std::string::npos);
    EXPECT_EQ(fault(R"("receive": {"allow": "0x01"})"),
              "/links/0/receive/allow: 'receive.allow' must be a list such as [\"0x01\"], not the text \"0x01\"\n");
    EXPECT_EQ(faults_in(R"({"links": [5]})"), "/links/0: must be a LINK text or an object {...}, not 5\n");
    EXPECT_NE(fault(R"("limit": {"0x01": 0})").find("/links/0/limit/0x01: '0x01' must be a number of frames per second"),
              std::string::npos);
    EXPECT_NE(fault(R"("limit": {"0x01": "many"})").find("/links/0/limit/0x01: "), std::string::npos);
    EXPECT_NE(fault(R"("limit": {"eulr": 5})").find("(did you mean 'euler'?)"), std::string::npos);
    EXPECT_NE(fault(R"("limit": {"0x03": 5, "euler": 6})").find("0x03 already has a limit"), std::string::npos);
    EXPECT_NE(fault(R"("limit": 5)").find("/links/0/limit: must be an object"), std::string::npos);
    EXPECT_NE(fault(R"("age": {"control": "soon"})").find("/links/0/age/control: "), std::string::npos);
    EXPECT_NE(fault(R"("send.deny": ["0xB0"])").find("unknown key 'send.deny'"), std::string::npos);
}

TEST(Config, an_alias_is_one_id_of_one_device) {
    const auto fault = [](const std::string& aliases) {
        return faults_in(R"({"gateway": {"id": 199}, "links": ["sim:fc,id=5", "pty:/tmp/x"], "alias": [)" + aliases + "]}");
    };
    EXPECT_EQ(fault(R"({"link": "fc", "device": "0xDE", "as": 31}, {"link": "x", "device": "0xDE", "as": 32})"), "");
    EXPECT_NE(fault(R"({"link": "fcc", "device": "0xDE", "as": 31})").find("/alias/0/link: there is no link 'fcc'"),
              std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": "0xDE"})").find("/alias/0: 'as' is missing"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 31})").find("is already the id of the device"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 199})").find("the gateway's own id"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 5})").find("is the port id of 'fc'"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": "0xFE", "as": 31})").find("a host"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "x", "device": 42, "as": 31})").find("is also used at"),
              std::string::npos);
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 41, "as": 32})"),
              "/alias/1/device: 'device' 0x29 already has the alias 0x1F (/alias/0)\n");
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 31, "as": 32})"),
              "/alias/1/device: 'device' 0x1F is the alias of 0x29 (/alias/0): use 'as' there\n");
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 42, "as": 41})"),
              "/alias/1/as: 'as' 0x29 is the id of a device on this link that itself has an alias (/alias/0)\n");
}

TEST(Config, present_as_must_be_an_address_and_not_a_port_id) {
    const auto fault = [](const std::string& links) {
        return faults_in(R"({"gateway": {"id": 199}, "links": [)" + links + "]}");
    };
    EXPECT_EQ(fault(R"("sim:fc,present_as=0xFE", "pty:/tmp/x,present_as=31")"), "");
    EXPECT_NE(fault(R"("sim:fc,present_as=0xFF")").find("present_as"), std::string::npos);
    EXPECT_NE(fault(R"("sim:fc,present_as=0")").find("present_as"), std::string::npos);
    EXPECT_NE(fault(R"("sim:fc,present_as=5", "pty:/tmp/x,id=5")").find("'present_as' 0x05 is the port id of 'x'"),
              std::string::npos);
    EXPECT_EQ(fault(R"("sim:fc,group=a,present_as=0xFE", "pty:/tmp/x,group=a,present_as=0xFE", "pty:/tmp/y,group=b")"), "");
    EXPECT_NE(fault(R"("sim:fc,group=a,present_as=0xFE", "pty:/tmp/x,group=a")").find("must be the same on all links of a group"),
              std::string::npos);
    EXPECT_NE(fault(R"("sim:fc,group=a,manage", "pty:/tmp/x,group=a")").find("'manage' must be the same on all links of a group"),
              std::string::npos);
}

TEST(Config, a_class_applies_to_one_id_that_is_not_a_command) {
    const Draft draft = parse_config(R"({"classes": [{"id": "0xF5", "class": "control", "age": "150ms"},
        {"id": "flexible2", "class": "telemetry", "replaces": true}, {"id": "log", "class": "bulk"}]})");
    EXPECT_EQ(lines(draft.errors), "");
    const auto policy = [&](std::size_t i) { return policy_of(draft.settings.classes.at(i)); };
    EXPECT_EQ(policy(0), (QueuePolicy{TrafficClass::urgent, Replaces::same_id, AgeKind::control, 150}));
    EXPECT_EQ(policy(1), (QueuePolicy{TrafficClass::telemetry, Replaces::same_id, AgeKind::telemetry}));
    EXPECT_EQ(policy(2), (QueuePolicy{TrafficClass::bulk, Replaces::nothing, AgeKind::rest}));
    EXPECT_EQ(draft.settings.classes.at(1).id, 0xF2);

    const auto fault = [](const std::string& classes) { return faults_in(R"({"classes": [)" + classes + "]}"); };
    EXPECT_NE(fault(R"({"id": "flexibel5", "class": "control"})").find("/classes/0/id: "), std::string::npos);
    EXPECT_NE(fault(R"({"id": "flexibel5", "class": "control"})").find("(did you mean 'flexible5'?)"), std::string::npos);
    EXPECT_NE(fault(R"({"id": "0xF1-0xF5", "class": "control"})").find("which covers several"), std::string::npos);
    EXPECT_NE(fault(R"({"id": "0xC0", "class": "bulk"})").find("'0xC0' can't have another class"), std::string::npos);
    EXPECT_NE(fault(R"({"id": "0xB1", "class": "bulk"})").find("'0xB1' can't have another class"), std::string::npos);
    EXPECT_NE(fault(R"({"id": "0xF5"})").find("/classes/0: 'class' is missing"), std::string::npos);
    EXPECT_NE(fault(R"({"id": "0xF5", "class": "fast"})").find("/classes/0/class: "), std::string::npos);
    EXPECT_EQ(fault(R"({"id": "0xF5", "class": "bulk"}, {"id": "flexible5", "class": "control"})"),
              "/classes/1/id: 'id' 0xF5 already has a class at /classes/0\n");
}

}    // namespace
}    // namespace anogate::config_rules_tests
