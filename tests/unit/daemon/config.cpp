#include <gtest/gtest.h>
#include <ano_json/text.hpp>
#include <gateway/can_settings.hpp>
#include <link/pty_settings.hpp>
#include <link/serial_settings.hpp>
#include <link/sim_settings.hpp>
#include <link/udp_settings.hpp>
#include <support/random.hpp>
#include <support/sanitized.hpp>

#include <config/check_network.hpp>
#include <config/values.hpp>
#include <gateway/tunnel_policy.hpp>
#include <nlohmann/json.hpp>
#include <unit/daemon/faults.hpp>

namespace anogate {
namespace {

Settings settings_of(std::string_view json) {
    Draft draft = parse_config(json);
    EXPECT_EQ(lines(draft.errors), "");
    return draft.settings;
}

TEST(Config, nothing_said_is_the_defaults) {
    EXPECT_EQ(settings_of("{}"), Settings{});
    EXPECT_EQ(settings_of(R"({"$schema": "./anogate.schema.json"})"), Settings{}) << "a word for editors";
}

TEST(Config, every_section) {
    const Settings s = settings_of(R"(// comments
    {
        "gateway": {"id": 199, "name": "boat", "unknown": "fc", "forget_after": "5m"},
        "links": [
            {"kind": "serial", "name": "fc", "device": "/dev/ttyUSB0", "baud": 115200, "id": "0x01", "dtr": false},
            "udp-listen:0.0.0.0:12333,id=2", /* and more */
            {"kind": "udp-listen", "address": "[::]:0", "allow": ["10.0.0.0/8", "::1"]},
            {"kind": "udp-listen", "address": "[::]:1", "allow": "any"}
        ],
        "routes": [{"address": "0xDC", "link": "fc"}, {"address": 7, "link": "udp-listen-12333"}, {"address": "30-40", "link": "fc"}],
        "control": {"socket": "none"},
        "record": {"start": false, "folder": "/data", "format": "mcap", "message_encoding": "json", "direction": ["in", "dropped"], "id": ["euler", "0xF1-0xFA"],
                   "from": ["0xDC"], "to": ["30-40"], "link": ["fc"], "limit": {"euler": 10},
                   "rotate": {"size": "10MB", "time": "10m"}, "keep": {"size": "2GB", "age": "720h", "free": "1GB"},
                   "free": "100MB", "keep_last": "60s"},
        "log": {"level": "debug", "file": "/var/log/anogate.log", "rotate": 0}
    })");
    EXPECT_EQ(s.gateway, (GatewaySettings{199, "boat", Unknown::link, "fc", std::chrono::minutes{5}}));
    ASSERT_EQ(s.links.size(), 4u);
    EXPECT_EQ(s.links[0].as<SerialSettings>().baud, 115200u);
    EXPECT_EQ(s.links[0].id, 1);
    EXPECT_EQ(s.links[0].as<SerialSettings>().dtr, false);
    EXPECT_EQ(s.links[1].name, "udp-listen-12333");
    EXPECT_EQ(s.links[2].as<UdpListenSettings>().allow.size(), 2u);
    EXPECT_TRUE(s.links[3].as<UdpListenSettings>().allow_any);
    EXPECT_EQ(s.routes, (std::vector<RouteSettings>{{220, 220, "fc"}, {7, 7, "udp-listen-12333"}, {30, 40, "fc"}}));
    EXPECT_EQ(s.control.socket, "none");
    RecordSettings record;
    record.start = false;
    record.folder = "/data";
    record.format = "mcap";
    record.message_encoding = "json";
    record.direction = {"in", "dropped"};
    record.ids = {{3, 3}, {0xF1, 0xFA}};
    record.from = {{0xDC, 0xDC}};
    record.to = {{30, 40}};
    record.links = {"fc"};
    record.limit = {{3, 10}};
    record.rotate_size = 10'000'000;
    record.rotate_time = std::chrono::minutes{10};
    record.keep_size = 2'000'000'000;
    record.keep_age = std::chrono::hours{720};
    record.keep_free = 1'000'000'000;
    record.free = 100'000'000;
    record.keep_last = std::chrono::seconds{60};
    EXPECT_EQ(s.record, record);
    EXPECT_EQ(s.log, (LogSettings{"debug", "/var/log/anogate.log", 0}));
}

TEST(Config, without_a_section_for_it_records_nothing_by_itself) {
    EXPECT_FALSE(settings_of("{}").record.has_value());
    EXPECT_EQ(settings_of(R"({"record": {}})").record, RecordSettings{});
}

TEST(Config, faults_of_what_is_to_be_recorded_name_their_place) {
    EXPECT_EQ(faults_in(R"({"record": {"direction": ["in", "ot"]}})"),
              "/record/direction: 'direction' has 'ot', which is none of in, out and dropped (did you mean 'out'?)\n");
    EXPECT_EQ(faults_in(R"({"record": {"direction": []}})"),
              "/record/direction: 'direction' must name what is recorded: in, out, dropped\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "record": {"link": ["fx"]}})"),
              "/record/link/0: there is no link 'fx' (did you mean 'fc'?); give one of fc\n");
    EXPECT_EQ(
        faults_in(R"({"record": {"keep": {"free": "1MB"}}})"),
        "/record/keep/free: 'keep.free' must be at least 'free', 500MB: nothing would be written before anything is deleted\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"bytes": "1MB"}}})").substr(0, 19), "/record/keep/bytes:");
    EXPECT_EQ(faults_in(R"({"record": {"format": "csv"}})"), "/record/format: 'format' must be one of pcapng, mcap, not 'csv'\n");
    EXPECT_EQ(faults_in(R"({"record": {"message_encoding": "xml"}})"),
              "/record/message_encoding: 'message_encoding' must be one of cdr, json, not 'xml'\n");
}

TEST(Config, a_size_of_recordings_whose_unit_was_forgotten_is_refused) {
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": "20"}}})"),
              "/record/keep/size: 'keep.size' must be 0 or at least 100kB, not 20 bytes: give it a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": 99999}}})").substr(0, 18), "/record/keep/size:");
    EXPECT_EQ(faults_in(R"({"record": {"rotate": {"size": "9999"}}})"),
              "/record/rotate/size: 'rotate.size' must be 0 or at least 10kB, not 9999 bytes: give it a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"free": 500}, "free": 0}})"),
              "/record/keep/free: 'keep.free' must be 0 or at least 1MB, not 500 bytes: give it a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"free": "999kB"}})"),
              "/record/free: 'free' must be 0 or at least 1MB, not 999000 bytes: give it a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": "100kB", "free": "1MB"}, "rotate": {"size": 10000}, "free": 1000000}})"),
              "");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": 0, "free": 0}, "rotate": {"size": "0"}, "free": 0}})"), "");
}

TEST(Config, an_encoding_of_messages_without_mcap_is_warned_of) {
    const auto warnings_in = [](const std::string& record) {
        return lines(parse_config(R"({"links": ["sim:fc"], "record": )" + record + "}").warnings);
    };
    const std::string warned =
        "anogated: /record/message_encoding: warning: 'message_encoding' has no effect on what is recorded as pcapng: "
        "give 'format' \"mcap\", which alone has decoded messages\n";
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json"})"), warned);
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json", "format": "pcapng"})"), warned);
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json", "format": "mcap"})"), "");
    EXPECT_EQ(warnings_in(R"({"message_encoding": "cdr"})"), "");
}

TEST(Config, a_mistyped_key_is_named_by_its_pointer) {
    EXPECT_EQ(faults_in(R"({"link": []})"), "/link: unknown key 'link' (did you mean 'links'?)\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"nme": "x"}})"), "/gateway/nme: unknown key 'nme' (did you mean 'name'?)\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc", {"kind": "serial", "device": "/dev/x", "bauds": 9}]})"),
              "/links/1/bauds: unknown key 'bauds' (did you mean 'baud'?)\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "udp", "address": "1.2.3.4:5", "baud": 9}]})"),
              "/links/0/baud: 'baud' is not a key of udp, but of serial\n");
    EXPECT_EQ(faults_in(R"({"links": ["serial:/dev/x,bauds=9"]})"),
              "/links/0: LINK 'serial:/dev/x,bauds=9': unknown key 'bauds' (did you mean 'baud'?)\n");
    EXPECT_EQ(faults_in(R"({"a/b~c": 1})"), "/a~1b~0c: unknown key 'a/b~c'\n");
    EXPECT_EQ(faults_in(R"({"": 1})"), "/: unknown key ''\n");
}

TEST(Config, a_value_has_the_right_type) {
    const auto fault = [](const std::string& key_and_value) {
        return faults_in(R"({"links": [{"kind": "serial", "device": "/dev/x", )" + key_and_value + "}]}");
    };
    EXPECT_EQ(fault(R"("baud": "500000")"),
              "/links/0/baud: 'baud' must be a whole number from 1 to 4294967295, not the text \"500000\"\n");
    EXPECT_EQ(fault(R"("baud": 1.5)"), "/links/0/baud: 'baud' must be a whole number from 1 to 4294967295, not 1.5\n");
    EXPECT_EQ(fault(R"("baud": -9)"), "/links/0/baud: 'baud' must be a whole number from 1 to 4294967295, not '-9'\n");
    EXPECT_EQ(fault(R"("baud": 99999999999999999999)"),
              "/links/0/baud: 'baud' must be a whole number from 1 to 4294967295, not 1e+20\n");
    EXPECT_EQ(fault(R"("required": "yes")"), "/links/0/required: 'required' must be true or false, not the text \"yes\"\n");
    EXPECT_EQ(fault(R"("name": null)"), "/links/0/name: 'name' must be text of 1 to 64 bytes, not null\n");
    EXPECT_EQ(fault(R"("name": ["x"])"), "/links/0/name: 'name' must be text of 1 to 64 bytes, not a list\n");
    EXPECT_EQ(fault(R"("name": "a\u0000b")"), "/links/0/name: 'name' must be printable text in UTF-8, not 'a\\u0000b'\n");
    EXPECT_EQ(fault(R"("name": "a\u009bb")"), "/links/0/name: 'name' must be printable text in UTF-8, not 'a\\u009bb'\n");
    EXPECT_EQ(faults_in(std::string{"{\"links\": [\"sim:fc\"]}\n\0, broken", 31}), ": line 2: a byte 0, which no text has\n");
    EXPECT_EQ(fault(R"("parity": {})"), "/links/0/parity: 'parity' must be one of none, even, odd, not an object\n");
    EXPECT_EQ(fault(R"("id": true)"), "/links/0/id: 'id' must be an address from 1 to 20 (or in hex such as 0x05), not true\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"forget_after": 30}})"),
              "/gateway/forget_after: 'forget_after' must be a duration such as 500ms, 30s or 2m, from 1s to 24h, not 30\n");
    EXPECT_EQ(faults_in(R"({"links": {}})"), "/links: must be a list [...], not an object\n");
    EXPECT_EQ(faults_in(R"({"log": []})"), "/log: must be an object {...} of level, file, rotate, not a list\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "routes": ["0xDC=fc"]})"),
              "/routes/0: must be an object {...} of address, link, not the text \"0xDC=fc\"\n");
    EXPECT_EQ(faults_in("[]"), ": must be an object {...}, not a list\n");
}

TEST(Config, networks_are_a_list_of_texts_or_any) {
    const auto ok = [](const std::string& allow) {
        return faults_in(R"({"links": [{"kind": "udp-listen", "address": "0.0.0.0:1", "allow": )" + allow + "}]}").empty();
    };
    EXPECT_TRUE(ok(R"("any")"));
    EXPECT_TRUE(ok(R"(["10.0.0.0/8"])"));
    for (const char* allow : {"[]", R"("10.0.0.0/8")", R"(["any"])", R"(["10.0.0.0/8+1.2.3.4"])", "[5]", R"([""])", "true"})
        EXPECT_FALSE(ok(allow)) << allow;
    EXPECT_NE(faults_in(R"({"links": [{"kind": "udp-listen", "address": "[::]:1", "allow": ["any", "10.0.0.0/8"]}]})"), "");
}

TEST(Config, what_is_needed_and_missing_is_told) {
    EXPECT_EQ(faults_in(R"({"links": [{}]})"), "/links/0: 'kind' is missing, for example \"kind\": \"serial\"\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "serial"}]})"), "/links/0: 'device' is missing: path of the port\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "seral"}]})"),
              "/links/0/kind: unknown kind 'seral' (did you mean 'serial'?); the kinds are serial, udp-listen, udp, can, "
              "pty, sim, replay\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": 5}, 6]})"),
              "/links/0/kind: 'kind' must be text such as \"serial\", not 5\n/links/1: must be a LINK text or an object {...}, "
              "not 6\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "routes": [{"link": "fc"}]})"),
              "/routes/0: 'address' is missing: the address or range to pin\n");
}

TEST(Config, a_key_given_twice_is_a_fault) {
    EXPECT_EQ(faults_in(R"({"log": {"level": "info", "level": "debug"}})"), "/log/level: 'level' is given twice\n");
    EXPECT_EQ(
        faults_in(
            R"({"links": [{"kind": "sim", "device": "fc"}, {"kind": "sim", "id": 1, "device": "fc", "id": 2}], "links": []})"),
        "/links/1/id: 'id' is given twice\n/links: 'links' is given twice\n");
}

TEST(Config, routes_lead_somewhere) {
    const auto fault = [](const std::string& routes) {
        return faults_in(R"({"gateway": {"id": 99}, "links": ["sim:fc,id=3", "pty:/run/app"], "routes": [)" + routes + "]}");
    };
    EXPECT_EQ(fault(R"({"address": "0xDC", "link": "fc"}, {"address": "0xDC", "link": "app"})"), "");
    EXPECT_EQ(fault(R"({"address": 5, "link": "ap"})"),
              "/routes/0/link: there is no link 'ap' (did you mean 'app'?); give one of fc, app\n");
    EXPECT_EQ(fault(R"({"address": 99, "link": "fc"})"), "/routes/0/address: 'address' 0x63: 0x63 is the gateway's own id\n");
    EXPECT_EQ(fault(R"({"address": "1-9", "link": "fc"})"),
              "/routes/0/address: 'address' 1-9: 3 is the port id of 'fc' (/links/0: LINK 'sim:fc,id=3'), frames to it "
              "go there\n");
    for (const char* address : {"0", "255", "\"0x00\"", "\"0xFF\"", "\"200-255\"", "\"40-30\"", "\"host\"", "2.5"})
        EXPECT_NE(
            fault(R"({"link": "fc", "address": )" + std::string{address} + "}").find("/routes/0/address: 'address' must be"),
            std::string::npos)
            << address;
}

TEST(Config, unknown_names_a_link_that_is) {
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "app"}, "links": ["pty:/run/app"]})"), "");
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "flod"}, "links": ["pty:/run/app"]})"),
              "/gateway/unknown: there is no link 'flod' (did you mean 'flood'?); give flood, drop, or one of app\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "dorp"}})"),
              "/gateway/unknown: there is no link 'dorp' (did you mean 'drop'?); give flood, drop, or a link\n");
}

TEST(Config, ids_are_of_one_thing_each) {
    EXPECT_EQ(faults_in(R"({"gateway": {"id": 3}, "links": [{"kind": "sim", "device": "fc", "id": 3}]})"),
              "/links/0/id: 'id' 3 is the gateway's own id\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"id": 255}})"),
              "/gateway/id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not '255'\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"id": "0x00"}})"),
              "/gateway/id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not '0x00'\n");
}

TEST(Config, a_link_that_cannot_be_read_brings_no_faults_about_its_name) {
    EXPECT_EQ(
        faults_in(R"({"links": ["sim:plane,name=x"], "routes": [{"address": 5, "link": "x"}], "gateway": {"unknown": "y"}})"),
        "/links/0: LINK 'sim:plane,name=x': 'device' must be one of fc, imu, flow, radio, car, not 'plane'\n");
    const std::string beside_another = faults_in(
        R"({"links": ["bogus:fc,name=x", "pty:/tmp/y"], "routes": [{"address": 5, "link": "x"}]})");
    EXPECT_EQ(std::count(beside_another.begin(), beside_another.end(), '\n'), 1) << beside_another;
}

TEST(Config, one_fault_brings_no_others) {
    EXPECT_EQ(faults_in(R"({"links": {"a": "sim:fc"}, "routes": [{"address": 5, "link": "fc"}]})"),
              "/links: must be a list [...], not an object\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "can", "interface": "can0", "framing": 5, "tx": "0x7E0", "rx": "0x7E8"}]})"),
              "/links/0/framing: 'framing' must be one of stream, isotp, not 5\n");
}

TEST(Config, a_key_without_a_name_is_a_mistyped_one) {
    for (const std::string section : {"gateway", "control", "log"})
        EXPECT_EQ(faults_in("{\"" + section + "\": {\"\": {}}}"), "/" + section + "/: unknown key ''\n");
}

TEST(Config, a_long_text_is_cut_between_its_characters) {
    for (const std::string start : {"", "x"}) {
        std::string name = start;
        for (int i = 0; i < 5000; ++i) name += "\u00E9";
        const std::string told = lines(parse_config(R"({"gateway": {"name": ")" + name + "\"}}").errors);
        EXPECT_TRUE(ano::is_utf8(told)) << told;
        EXPECT_LT(told.size(), 400u);
    }
}

TEST(Config, text_that_is_no_json_is_told_with_line_and_column) {
    EXPECT_EQ(
        faults_in("{\"a\":\n  [1,}"),
        ": line 2, column 6: syntax error while parsing value - unexpected '}'; expected '[', '{', or a literal (is there a "
        "comma too many before it?)\n");
    for (const std::string& text :
         {std::string{}, std::string{"{"}, std::string{"\0\xFF\xAB", 3}, std::string{"{\"a\":\"\xFF\"}"}, std::string{"{} {}"}})
        EXPECT_EQ(faults_in(text).rfind(": line ", 0), 0u) << faults_in(text);
}

TEST(Config, nesting_without_end_is_refused) {
    const std::string brackets(1'000'000, '[');
    EXPECT_NE(faults_in(brackets).find("nested deeper than 32 levels\n"), std::string::npos);
    EXPECT_EQ(lines(parse_config(brackets).errors).find('\n'), lines(parse_config(brackets).errors).size() - 1);
    const auto nested = [](std::size_t levels) { return faults_in(std::string(levels, '[') + std::string(levels, ']')); };
    EXPECT_EQ(nested(32).find("nested deeper"), std::string::npos);
    EXPECT_NE(nested(33).find("nested deeper"), std::string::npos);
    std::string objects;
    for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
    EXPECT_NE(faults_in(objects).find("nested deeper than 32 levels\n"), std::string::npos);
}

TEST(Config, the_file_is_named_before_the_pointer) {
    EXPECT_EQ(lines(parse_config(R"({"x": 1})", "a.json").errors), "anogated: a.json: /x: unknown key 'x'\n");
    EXPECT_EQ(lines(parse_config("[]", "a.json").errors), "anogated: a.json: must be an object {...}, not a list\n");
}

// The link `control`.

TEST(Config, the_control_link_has_rules_as_every_link) {
    const Settings settings = settings_of(
        R"({"control": {"receive": {"deny": ["0x09"]}, "send": {"deny_sources": ["0xFE"]}, "limit": {"euler": 5}}})");
    EXPECT_EQ(settings.control.rules.receive.deny, (std::vector<ByteRange>{{0x09, 0x09}}));
    EXPECT_EQ(settings.control.rules.send.deny_sources, (std::vector<ByteRange>{{0xFE, 0xFE}}));
    EXPECT_EQ(settings.control.rules.limit, (std::vector<LimitRule>{{0x03, 5}}));
    EXPECT_TRUE(is_control_configured(settings));
    EXPECT_FALSE(is_control_configured(settings_of(R"({"control": {"socket": "/tmp/x"}})")));
}

TEST(Config, the_control_link_may_be_named_and_is_there_then) {
    EXPECT_TRUE(is_control_configured(settings_of(R"({"routes": [{"address": 30, "link": "control"}]})")));
    EXPECT_TRUE(is_control_configured(settings_of(R"({"gateway": {"unknown": "control"}})")));
    EXPECT_TRUE(is_control_configured(
        settings_of(R"({"gpio": [{"chip": "gpiochip0", "line": 1, "use": "inhibit", "links": ["control"]}]})")));
    for (const std::string name : {"control", "tunnel"}) {
        const std::string tunnel = name == "tunnel" ? R"("links": ["sim:fc"], "tunnel": {"links": ["fc"]}, )" : "";
        EXPECT_EQ(
            faults_in("{" + tunnel + R"("gpio": [{"chip": "gpiochip0", "line": 1, "use": "rs485", "link": ")" + name + "\"}]}"),
            "/gpio/0/link: 'link' '" + name + "' is not a serial port: rs485 is for those\n");
    }
}

// The tunnel.

TEST(Config, a_tunnel_has_its_defaults_and_is_none_without_the_key) {
    EXPECT_FALSE(settings_of("{}").tunnel);
    EXPECT_EQ(settings_of(R"({"tunnel": {}})").tunnel, TunnelSettings{});
    const TunnelSettings t;
    EXPECT_EQ(t.address, 0xE6);
    EXPECT_EQ(t.port, 12333);
    EXPECT_TRUE(t.bind.is_any() && !t.ip && t.deliver == Deliver::frames);
}

TEST(Config, a_tunnel_is_read_as_it_is_written) {
    const TunnelSettings t = *settings_of(R"({"links": ["serial:/dev/fc"], "tunnel": {"links": ["fc"], "address": "0xE7",
        "bind": "192.168.0.5", "port": 5, "ip": "203.0.113.9", "deliver": "tunnel", "allow": ["192.168.0.0/24", "127.0.0.0/8"],
        "wrap": [{"from": "192.168.0.0/24", "link": "fc", "as": "ip_tunnel_short", "source": 7, "to": "0xDC"}]}})")
                                  .tunnel;
    TunnelSettings expected;
    expected.links = {"fc"};
    expected.address = 0xE7;
    expected.bind = *IpAddress::parse("192.168.0.5");
    expected.port = 5;
    expected.ip = IpAddress::parse("203.0.113.9");
    expected.deliver = Deliver::tunnel;
    expected.allow = {*Network::parse("192.168.0.0/24"), *Network::parse("127.0.0.0/8")};
    expected.wrap = {{*Network::parse("192.168.0.0/24"), "fc", 0xB2, 7, 0xDC}};
    EXPECT_EQ(t, expected);
}

// For links whose peers are in the network, and for others.
TEST(Config, a_tunnel_relays_the_network_to_local_programs_only_where_that_is_said) {
    const auto faults = [](const std::string& link, const std::string& allow, const std::string& more = {}) {
        return faults_in("{\"links\": [\"" + link +
                         ",name=g\", \"sim:fc\"], \"tunnel\": {\"links\": [\"fc\", \"g\"], \"port\": 1, \"allow\": [" + allow +
                         "]" + more + "}}");
    };
    const std::string open = "udp-listen:0.0.0.0:12333";
    EXPECT_EQ(
        faults(open, R"("10.0.0.0/8", "127.0.0.0/8")"),
        "/tunnel/allow: 'allow' lists 127.0.0.0/8, which is this computer, and 'links' names 'g': its peers in the network would "
        "reach local programs by tunnel frames; take one of them away, or say \"relay\": true if they shall\n");
    for (const char* link : {"udp-listen:192.168.1.5:12333", "udp-listen:[::]:12333", "udp:192.168.1.20:6670"})
        EXPECT_NE(faults(link, R"("127.0.0.1/32")"), "") << link;
    EXPECT_EQ(faults(open, R"("127.0.0.0/8")", R"(, "relay": true)"), "");
    EXPECT_NE(faults(open, R"("127.0.0.0/8")", R"(, "relay": false)"), "");
    EXPECT_EQ(faults(open, R"("10.0.0.0/8")"), "");
    for (const char* link : {"serial:/dev/ttyUSB0", "pty:/run/x", "can:can0", "udp-listen:127.0.0.1:12333", "udp:127.0.0.1:6670"})
        EXPECT_EQ(faults(link, R"("127.0.0.0/8")"), "") << link << " has no peers in the network";
    EXPECT_EQ(
        faults_in(
            R"({"links": ["udp-listen:0.0.0.0:1,name=g", "sim:fc"], "tunnel": {"links": ["fc"], "allow": ["127.0.0.0/8"]}})"),
        "")
        << "its tunnel frames are not carried";
}

TEST(Config, a_check_knows_the_addresses_of_this_computer_too) {
    const auto faults = [](const std::string& allow, const std::string& relay = "false") {
        Draft draft = parse_config(R"({"links": ["udp-listen:0.0.0.0:1,name=g"], "tunnel": {"links": ["g"], "allow": [")" +
                                   allow + R"("], "relay": )" + relay + "}}");
        EXPECT_TRUE(draft.errors.empty());
        check_relay(draft, {*Network::parse("127.0.0.1/8"), *Network::parse("192.168.1.5/24")});
        return draft.errors.size();
    };
    EXPECT_EQ(faults("192.168.1.5/32"), 1u);
    EXPECT_EQ(faults("192.168.1.5/32", "true"), 0u);
    EXPECT_EQ(faults("192.168.1.0/24"), 0u) << "an own address counts only when it is listed by itself";
    EXPECT_EQ(faults("192.168.1.6/32"), 0u);
}

TEST(Config, faults_of_a_tunnel_name_their_place) {
    EXPECT_EQ(
        faults_in(R"({"links": ["serial:/dev/fc", "udp-listen:0.0.0.0:12333,name=g"], "tunnel": {"links": ["fd"], "bind": "::",
        "ip": "0.0.0.0", "delivers": "x", "allow": ["::1/128"], "wrap": [{"from": "fc", "as": "ip", "link": "tunnel"}, 5]}})"),
        "/tunnel/allow: 'allow' must be any, or networks such as 192.168.0.0/24, not '::1/128'\n"
        "/tunnel/bind: 'bind' must be an IPv4 address such as 192.168.0.5, not '::'\n"
        "/tunnel/delivers: unknown key 'delivers' (did you mean 'deliver'?)\n"
        "/tunnel/ip: 'ip' must be an IPv4 address such as 192.168.0.5 or auto, not '0.0.0.0'\n"
        "/tunnel/wrap/0/as: 'as' must be one of ip_tunnel, ip_tunnel_short, not 'ip'\n"
        "/tunnel/wrap/0/from: 'from' must be an IPv4 network such as 192.168.0.0/24, not 'fc'\n"
        "/tunnel/wrap/1: must be an object {...} of from, link, as, source, to, not 5\n"
        "/tunnel/links/0: there is no link 'fd' (did you mean 'fc'?); give one of fc, g\n"
        "/tunnel/wrap/0/link: there is no link 'tunnel'; give one of fc, g\n"
        "/tunnel/port: local port 12333 is used by 'g' (/links/1: LINK 'udp-listen:0.0.0.0:12333,name=g') already\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc,name=tunnel"], "tunnel": 5})"),
              "/tunnel: must be an object {...}, not 5\n/links/0: LINK 'sim:fc,name=tunnel': 'name' can't be 'tunnel', the word "
              "is taken\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {}, "routes": [{"address": 5, "link": "tunnel"}]})"), "");
}

// Traffic.

TEST(Config, rules_are_objects_in_objects) {
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

TEST(Config, faults_of_rules_name_their_place) {
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
    EXPECT_NE(fault(R"("limit": {"0x01": 0})").find("/links/0/limit/0x01: '0x01' must be a number of frames a second"),
              std::string::npos);
    EXPECT_NE(fault(R"("limit": {"0x01": "many"})").find("/links/0/limit/0x01: "), std::string::npos);
    EXPECT_NE(fault(R"("limit": {"eulr": 5})").find("(did you mean 'euler'?)"), std::string::npos);
    EXPECT_NE(fault(R"("limit": {"0x03": 5, "euler": 6})").find("0x03 has a limit already"), std::string::npos);
    EXPECT_NE(fault(R"("limit": 5)").find("/links/0/limit: must be an object"), std::string::npos);
    EXPECT_NE(fault(R"("age": {"control": "soon"})").find("/links/0/age/control: "), std::string::npos);
    EXPECT_NE(fault(R"("send.deny": ["0xB0"])").find("unknown key 'send.deny'"), std::string::npos);
}

TEST(Config, says_where_a_key_of_a_link_stands) {
    for (const std::string key : {"send", "limit", "baud", "age", "group"})
        EXPECT_EQ(faults_in(R"({"links": [], ")" + key + R"(": 1})"),
                  "/" + key + ": '" + key + "' is a key of a link: it stands in an object of \"links\"\n");
    EXPECT_EQ(faults_in(R"({"links": [], "id": 1})"), "/id: unknown key 'id'\n");
}

TEST(Config, what_is_dotted_in_a_link_text_is_nested_in_a_file) {
    const auto fault = [](const std::string& keys) {
        return faults_in(R"({"links": [{"kind": "sim", "device": "fc", )" + keys + "}]}");
    };
    EXPECT_EQ(fault(R"("send.deny": ["0xB0"])"),
              "/links/0/send.deny: unknown key 'send.deny': in a file it is \"send\": {\"deny\": ...}\n");
    EXPECT_EQ(fault(R"("limit.0x01": 5)"),
              "/links/0/limit.0x01: unknown key 'limit.0x01': in a file it is \"limit\": {\"0x01\": ...}\n");
    EXPECT_EQ(fault(R"("a.b": 5)"), "/links/0/a.b: unknown key 'a.b'\n");
}

TEST(Config, a_network_in_a_file_stands_in_a_list) {
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"], "allow": "10.8.0.0/24"}})"),
              "/tunnel/allow: 'allow' must be a list such as [\"10.8.0.0/24\"], not the text \"10.8.0.0/24\"\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"], "allow": "any"}})"), "");
}

TEST(Config, what_is_missing_is_told_with_its_choices) {
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "gpio": [{"line": "A", "link": "fc"}]})")
                  .rfind("/gpio/0: 'use' is missing, one of link_up, activity, power, reset, inhibit, rs485: on while", 0),
              0u);
}

TEST(Config, an_alias_is_one_id_of_one_device) {
    const auto fault = [](const std::string& aliases) {
        return faults_in(R"({"gateway": {"id": 199}, "links": ["sim:fc,id=5", "pty:/tmp/x"], "alias": [)" + aliases + "]}");
    };
    EXPECT_EQ(fault(R"({"link": "fc", "device": "0xDE", "as": 31}, {"link": "x", "device": "0xDE", "as": 32})"), "");
    EXPECT_NE(fault(R"({"link": "fcc", "device": "0xDE", "as": 31})").find("/alias/0/link: there is no link 'fcc'"),
              std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": "0xDE"})").find("/alias/0: 'as' is missing"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 31})").find("the id that the device has already"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 199})").find("the gateway's own id"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 31, "as": 5})").find("is the port id of 'fc'"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": "0xFE", "as": 31})").find("a host"), std::string::npos);
    EXPECT_NE(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "x", "device": 42, "as": 31})").find("is given at"),
              std::string::npos);
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 41, "as": 32})"),
              "/alias/1/device: 'device' 0x29 has the alias 0x1F already (/alias/0)\n");
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 31, "as": 32})"),
              "/alias/1/device: 'device' 0x1F is the alias of 0x29 (/alias/0): give 'as' there\n");
    EXPECT_EQ(fault(R"({"link": "fc", "device": 41, "as": 31}, {"link": "fc", "device": 42, "as": 41})"),
              "/alias/1/as: 'as' 0x29 is the id of a device on this link that has an alias itself (/alias/0)\n");
}

TEST(Config, present_as_is_an_address_and_no_port_id) {
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

TEST(Config, warns_of_a_device_whose_address_is_a_port_id) {
    const auto warnings = [](const std::string& from, const std::string& more = "") {
        return lines(parse_config(R"({"links": [{"kind": "sim", "device": "fc", "receive": {"allow_sources": [)" + from + "]}" +
                                  more + R"(}, "pty:/tmp/x,id=5"]})")
                         .warnings);
    };
    EXPECT_EQ(warnings("\"0xDC\", 4"), "");
    EXPECT_EQ(warnings("\"1-254\""), "") << "everybody";
    EXPECT_EQ(warnings("5"),
              "anogated: /links/0/receive/allow_sources: warning: a device with the address 5 can't be reached: it is "
              "the port id of 'x' (/links/1: LINK 'pty:/tmp/x,id=5'), frames to it go there; give one of them another\n");
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
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=115200").find("max_data_out 1144 keeps it under 100 ms"), std::string::npos);
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=5000").find("max_data_out 492"), std::string::npos);
    EXPECT_EQ(warnings("udp:127.0.0.1:5,rate=5000,max_data_out=492"), "") << "100 ms";
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=80").find("max_data_out 0 keeps it under 100 ms"), std::string::npos);
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,profile=vendor"), "") << "what leaves is meant, not what comes in";
    EXPECT_EQ(warnings("serial:/dev/ttyS0,baud=115200,max_data_out=1140"), "");
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=9600,profile=vendor").find("a frame of max_data_out 198 takes 214 ms"),
              std::string::npos);
    EXPECT_NE(warnings("serial:/dev/ttyS0,baud=9600,profile=vendor").find("max_data_out 88 keeps it under 100 ms"),
              std::string::npos);
    EXPECT_NE(warnings("udp:127.0.0.1:5,rate=79").find("even one without DATA takes more than 100 ms"), std::string::npos);
}

TEST(Config, speaks_first_only_where_that_can_be_done) {
    EXPECT_NE(faults_of({"udp-listen:0.0.0.0:12333,hello=on"})
                  .find("'hello' is not possible on udp-listen: it knows nobody to speak to"),
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

TEST(Config, warns_of_peers_that_may_take_more_memory_than_a_small_computer_spares) {
    const auto warnings = [](const std::string& link) { return lines(parse_config("{\"links\": [\"" + link + "\"]}").warnings); };
    EXPECT_EQ(warnings("udp-listen:0.0.0.0:1"), "");
    EXPECT_EQ(warnings("udp-listen:0.0.0.0:1,queue=1000000,max_peers=64"), "");
    EXPECT_NE(warnings("udp-listen:0.0.0.0:1,queue=1000001,max_peers=64").find("more than 64 MB: lower 'queue' or 'max_peers'"),
              std::string::npos);
    EXPECT_EQ(warnings("serial:/dev/ttyS0,queue=60000000"), "");
}

TEST(Config, warns_of_what_is_as_good_as_not_said) {
    const auto warnings = [](const std::string& json) { return lines(parse_config(json).warnings); };
    EXPECT_EQ(warnings("{}"), "anogated: warning: the configuration has no links: there is nothing to join\n");
    EXPECT_EQ(warnings(R"({"gateway": {"nme": "boat"}})"), "") << "what else was to be there is not known";
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "gateway": {"id": 199}, "tunnel": {"links": ["fc"]}})"), "");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "gateway": {"id": "0xFE"}})"),
              "anogated: warning: the gateway's own id 0xFE is the address of hosts: what is sent to them ends in the gateway; "
              "give it another, such as 199\n");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc,group=radio"]})"),
              "anogated: /links/0: LINK 'sim:fc,group=radio': warning: 'fc' is alone in the group 'radio': it is as without\n");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc,group=a", "pty:/tmp/x,group=a"]})"), "");
    EXPECT_EQ(warnings(R"({"links": ["sim:fc"], "tunnel": {}})"),
              "anogated: /tunnel/links: warning: no link's tunnel frames are carried: name the links of their devices\n");
}

// Printing.

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
    link.profile = random.of({Profile::none, Profile::vendor});
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

/// Random settings without faults.
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
        // No port twice.
        if (link.kind->name == "udp-listen") link.as<UdpListenSettings>().local.port = static_cast<std::uint16_t>(1000 + i);
        if (random.one_in(2)) link.id = static_cast<std::uint8_t>(i + 1 == s.gateway.id || i >= 20 ? 0 : i + 1);
        link.max_data = static_cast<std::uint16_t>(random.below(65536));
        link.queue = link.max_data + 8u + random.below(100'000u);
        give_devices(link, random);
        link.flood = random.one_in(2);
        link.broadcast = random.one_in(2);
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

TEST(Config, flexible_layouts_are_read_and_kept_for_the_tools) {
    const std::string layout = R"({"fields":[{"name":"t","scale":0.1,"type":"i16","unit":"°C"}],"id":"0xF1","source":30})";
    const Draft draft = parse_config(R"({"flexible": [)" + layout + "]}");
    EXPECT_TRUE(draft.errors.empty());
    EXPECT_EQ(draft.settings.flexible, (std::vector<ano::FlexibleSpec>{{0xF1, 30, {{"t", ano::Type::i16, 0.1, "°C"}}}}));
    EXPECT_EQ(nlohmann::json::parse(print_config(draft.settings))["flexible"].dump(), "[" + layout + "]");
    EXPECT_EQ(parse_config(print_config(draft.settings)).settings, draft.settings);
}

TEST(Config, faults_of_flexible_layouts_name_their_place) {
    const Draft draft = parse_config(
        R"({"flexible": [{"id": 240, "fields": [{"name": "a", "type": "u8"}]},
                         {"id": "0xF1", "fields": [{"name": "a", "type": "u9"}]}]})",
        "f");
    ASSERT_EQ(draft.errors.size(), 2u);
    EXPECT_EQ(draft.errors[0].where, "f: /flexible/0/id");
    EXPECT_EQ(draft.errors[1].where, "f: /flexible/1/fields/0/type");
}

TEST(PrintConfig, what_is_printed_means_the_same_and_prints_the_same) {
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

TEST(PrintConfig, leaves_out_what_is_not_set) {
    const std::string printed = print_config(settings_of(R"({"links": ["serial:/dev/x", "udp:1.2.3.4:5"]})"));
    for (const char* key :
         {"\"id\"", "\"dtr\"", "\"rts\"", "\"bind\"", "\"allow\"", "\"interface\"", "\"socket\"", "\"file\"", "\"\""})
        EXPECT_EQ(printed.find(key), std::string::npos) << key;
    for (const char* key : {"\"baud\": 500000", "\"name\": \"x\"", "\"unknown\": \"flood\""})
        EXPECT_NE(printed.find(key), std::string::npos) << key;
}

constexpr std::string_view gpio_links = R"("links": ["sim:fc", "udp-listen:0.0.0.0:1,name=ground", "serial:/dev/x,name=bus"])";

std::string with_gpio(std::string_view lines) {
    return "{" + std::string{gpio_links} + ", \"gpio\": [" + std::string{lines} + "]}";
}

TEST(ConfigGpio, every_use) {
    const Settings s = settings_of(with_gpio(R"(
        {"chip": "gpiochip0", "line": 17, "use": "link_up", "link": "fc"},
        {"line": "ACT_LED", "use": "activity", "link": "ground"},
        {"chip": "gpiochip0", "line": 22, "use": "reset", "link": "fc", "active_low": true, "pulse": "50ms", "when": "silent 10s"},
        {"chip": "gpiochip0", "line": "23", "use": "power", "pulse": "3s"},
        {"chip": "/dev/gpiochip1", "line": 24, "use": "inhibit", "links": ["ground", "fc"], "bias": "pull_up", "active_low": true},
        {"chip": "gpiochip0", "line": 25, "use": "rs485", "link": "bus"})"));
    using namespace std::chrono_literals;
    const auto bias = GpioBias::as_is;
    EXPECT_EQ(s.gpio, (std::vector<GpioSettings>{
                          {"gpiochip0", "17", GpioUse::link_up, "fc", {}, false, bias, {}, {}},
                          {"", "ACT_LED", GpioUse::activity, "ground", {}, false, bias, {}, {}},
                          {"gpiochip0", "22", GpioUse::reset, "fc", {}, true, bias, 50ms, 10s},
                          {"gpiochip0", "23", GpioUse::power, "", {}, false, bias, 3s, {}},
                          {"/dev/gpiochip1", "24", GpioUse::inhibit, "", {"ground", "fc"}, true, GpioBias::pull_up, {}, {}},
                          {"gpiochip0", "25", GpioUse::rs485, "bus", {}, false, bias, {}, {}},
                      }));
    EXPECT_EQ(settings_of(print_config(s)), s);
    EXPECT_NE(print_config(s).find("\"line\": 17,"), std::string::npos) << "a number stays one";
}

TEST(ConfigGpio, faults_name_their_place) {
    const auto fault = [](std::string_view line) { return faults_in(with_gpio(line)); };
    EXPECT_EQ(fault(R"({"chip": "c", "line": 1, "use": "link_up", "link": "fc", "active_lo": true})"),
              "/gpio/0/active_lo: unknown key 'active_lo' (did you mean 'active_low'?)\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "linkup", "link": "fc"})").substr(0, 17), "/gpio/0/use: 'use");
    EXPECT_NE(fault(R"({"line": "x", "use": "linkup", "link": "fc"})").find("did you mean 'link_up'?"), std::string::npos);
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fd"})"),
              "/gpio/0/link: there is no link 'fd' (did you mean 'fc'?); give one of fc, ground, bus\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit", "links": ["fc", "groud"]})"),
              "/gpio/0/links/1: there is no link 'groud' (did you mean 'ground'?); give one of fc, ground, bus\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fc", "pulse": "1s"})"),
              "/gpio/0/pulse: 'pulse' is not a key of link_up, but of power, reset\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fc", "kind": "serial"})"),
              "/gpio/0/kind: unknown key 'kind' (did you mean 'line'?)\n");
    EXPECT_EQ(fault(R"({"use": "power"})").substr(0, 27), "/gpio/0: 'line' is missing:");
    EXPECT_EQ(fault(R"({"line": "x"})").substr(0, 26), "/gpio/0: 'use' is missing,");
    EXPECT_EQ(fault(R"({"line": 17, "use": "power"})"), "/gpio/0/line: 'line' 17 is a number: 'chip' must say of which chip\n");
    EXPECT_EQ(fault(R"({"line": -1, "use": "power", "chip": "c"})"),
              "/gpio/0/line: 'line' must be a line's number such as 17 or its name such as \"GPIO17\", not -1\n");
    EXPECT_EQ(fault("7"), "/gpio/0: must be an object {...}, not 7\n");
    EXPECT_EQ(faults_in(R"({"gpio": {}})"), "/gpio: must be a list [...], not an object\n");
}

TEST(ConfigGpio, a_use_needs_what_it_works_on) {
    const auto fault = [](std::string_view line) { return faults_in(with_gpio(line)); };
    EXPECT_EQ(fault(R"({"line": "x", "use": "activity"})"), "/gpio/0: 'link' is missing: the name of the link it is for\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "rs485"})"), "/gpio/0: 'link' is missing: the name of the link it is for\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit"})"),
              "/gpio/0: 'links' is missing: the links whose control frames are kept off\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "reset", "when": "silent 10s"})"),
              "/gpio/0: 'link' is missing: the link whose silence is meant\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "reset"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "power"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit", "link": "ground"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "rs485", "link": "fc"})"),
              "/gpio/0/link: 'link' 'fc' is not a serial port: rs485 is for those\n");
}

TEST(ConfigGpio, when_is_a_silence) {
    const auto fault = [](std::string_view when) {
        return faults_in(with_gpio(R"({"line": "x", "use": "reset", "link": "fc", "when": ")" + std::string{when} + "\"}"));
    };
    EXPECT_EQ(fault("silent 10s"), "");
    const std::string must =
        "/gpio/0/when: 'when' must be \"silent\" and a duration such as \"silent 10s\", from 1s to 24h, not ";
    for (const std::string bad : {"10s", "silent", "silent 10", "silent  10s", "silent 1ms", "loud 10s"})
        EXPECT_EQ(fault(bad), must + "'" + bad + "'\n");
}

TEST(ConfigGpio, a_line_is_used_once) {
    EXPECT_EQ(faults_in(with_gpio(R"({"line": "x", "use": "power"}, {"line": "x", "use": "reset"})")),
              "/gpio/1/line: 'line' 'x' is used by /gpio/0 already\n");
    EXPECT_EQ(faults_in(with_gpio(
                  R"({"chip": "gpiochip0", "line": "x", "use": "power"}, {"chip": "gpiochip1", "line": "x", "use": "reset"})")),
              "");
    EXPECT_EQ(
        faults_in(with_gpio(R"({"line": "x", "use": "rs485", "link": "bus"}, {"line": "y", "use": "rs485", "link": "bus"})")),
        "/gpio/1/link: 'link' 'bus' has a line for rs485 by /gpio/0 already\n");
    EXPECT_EQ(
        faults_in(
            R"({"links": ["serial:/dev/x,name=bus,flow=hardware"], "gpio": [{"line": "x", "use": "rs485", "link": "bus"}]})"),
        "/gpio/0/link: 'link' 'bus' uses the RTS line by 'flow' or 'rts', which rs485 needs\n");
}

}    // namespace
}    // namespace anogate
