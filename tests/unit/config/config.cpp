// The meaning of a configuration in JSON, and the messages for its errors.
#include <ano_json/text.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/udp/udp_settings.hpp>
#include <nlohmann/json.hpp>
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_tests {
namespace {

TEST(Config, an_empty_configuration_has_the_defaults) {
    EXPECT_EQ(settings_of("{}"), Settings{});
    EXPECT_EQ(settings_of(R"({"$schema": "./anogate.schema.json"})"), Settings{}) << "a word for editors";
}

TEST(Config, reads_every_section) {
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

TEST(Config, a_value_must_have_the_right_type) {
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
    EXPECT_EQ(faults_in(std::string{"{\"links\": [\"sim:fc\"]}\n\0, broken", 31}), ": line 2: contains a NUL byte\n");
    EXPECT_EQ(fault(R"("parity": {})"), "/links/0/parity: 'parity' must be one of none, even, odd, not an object\n");
    EXPECT_EQ(fault(R"("id": true)"), "/links/0/id: 'id' must be an address from 1 to 20 (or in hex such as 0x05), not true\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"forget_after": 30}})"),
              "/gateway/forget_after: 'forget_after' must be a duration such as 30s or 2m, from 1s to 24h, not 30\n");
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

TEST(Config, a_missing_required_key_is_reported) {
    EXPECT_EQ(faults_in(R"({"links": [{}]})"), "/links/0: 'kind' is missing, for example \"kind\": \"serial\"\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "serial"}]})"), "/links/0: 'device' is missing: path of the port\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "seral"}]})"),
              "/links/0/kind: unknown kind 'seral' (did you mean 'serial'?); the kinds are serial, hid, udp-listen, udp, tcp, "
              "tcp-listen, tls, tls-listen, can, "
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

TEST(Config, routes_must_lead_to_an_existing_link) {
    const auto fault = [](const std::string& routes) {
        return faults_in(R"({"gateway": {"id": 99}, "links": ["sim:fc,id=3", "pty:/run/app"], "routes": [)" + routes + "]}");
    };
    EXPECT_EQ(fault(R"({"address": "0xDC", "link": "fc"}, {"address": "0xDC", "link": "app"})"), "");
    EXPECT_EQ(fault(R"({"address": 5, "link": "ap"})"),
              "/routes/0/link: there is no link 'ap' (did you mean 'app'?); use one of fc, app\n");
    EXPECT_EQ(fault(R"({"address": 99, "link": "fc"})"), "/routes/0/address: 'address' 0x63: 0x63 is the gateway's own id\n");
    EXPECT_EQ(fault(R"({"address": "1-9", "link": "fc"})"),
              "/routes/0/address: 'address' 1-9: 3 is the port id of 'fc' (/links/0: LINK 'sim:fc,id=3'), and frames to it "
              "go there\n");
    for (const char* address : {"0", "255", "\"0x00\"", "\"0xFF\"", "\"200-255\"", "\"40-30\"", "\"host\"", "2.5"})
        EXPECT_NE(
            fault(R"({"link": "fc", "address": )" + std::string{address} + "}").find("/routes/0/address: 'address' must be"),
            std::string::npos)
            << address;
}

TEST(Config, unknown_must_name_an_existing_link) {
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "app"}, "links": ["pty:/run/app"]})"), "");
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "flod"}, "links": ["pty:/run/app"]})"),
              "/gateway/unknown: there is no link 'flod' (did you mean 'flood'?); use flood, drop, or one of app\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"unknown": "dorp"}})"),
              "/gateway/unknown: there is no link 'dorp' (did you mean 'drop'?); use flood, drop, or a link\n");
}

TEST(Config, ids_must_be_unique_and_in_range) {
    EXPECT_EQ(faults_in(R"({"gateway": {"id": 3}, "links": [{"kind": "sim", "device": "fc", "id": 3}]})"),
              "/links/0/id: 'id' 3 is the gateway's own id\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"id": 255}})"),
              "/gateway/id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not '255'\n");
    EXPECT_EQ(faults_in(R"({"gateway": {"id": "0x00"}})"),
              "/gateway/id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not '0x00'\n");
}

TEST(Config, an_invalid_link_causes_no_errors_about_its_name) {
    EXPECT_EQ(
        faults_in(R"({"links": ["sim:plane,name=x"], "routes": [{"address": 5, "link": "x"}], "gateway": {"unknown": "y"}})"),
        "/links/0: LINK 'sim:plane,name=x': 'device' must be one of fc, imu, flow, radio, car, lx, not 'plane'\n");
    const std::string beside_another = faults_in(
        R"({"links": ["bogus:fc,name=x", "pty:/tmp/y"], "routes": [{"address": 5, "link": "x"}]})");
    EXPECT_EQ(std::count(beside_another.begin(), beside_another.end(), '\n'), 1) << beside_another;
}

TEST(Config, one_error_causes_no_further_errors) {
    EXPECT_EQ(faults_in(R"({"links": {"a": "sim:fc"}, "routes": [{"address": 5, "link": "fc"}]})"),
              "/links: must be a list [...], not an object\n");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "can", "interface": "can0", "framing": 5, "tx": "0x7E0", "rx": "0x7E8"}]})"),
              "/links/0/framing: 'framing' must be one of stream, isotp, not 5\n");
}

TEST(Config, an_empty_key_is_reported_as_unknown) {
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

TEST(Config, invalid_json_is_reported_with_line_and_column) {
    EXPECT_EQ(faults_in("{\"a\":\n  [1,}"),
              ": line 2, column 6: syntax error while parsing value - unexpected '}'; expected '[', '{', or a literal (is there "
              "an extra comma before it?)\n");
    for (const std::string& text :
         {std::string{}, std::string{"{"}, std::string{"\0\xFF\xAB", 3}, std::string{"{\"a\":\"\xFF\"}"}, std::string{"{} {}"}})
        EXPECT_EQ(faults_in(text).rfind(": line ", 0), 0u) << faults_in(text);
}

TEST(Config, nesting_deeper_than_32_levels_is_rejected) {
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

TEST(Config, the_control_link_has_rules_like_every_link) {
    const Settings settings = settings_of(
        R"({"control": {"receive": {"deny": ["0x09"]}, "send": {"deny_sources": ["0xFE"]}, "limit": {"euler": 5}}})");
    EXPECT_EQ(settings.control.rules.receive.deny, (std::vector<ByteRange>{{0x09, 0x09}}));
    EXPECT_EQ(settings.control.rules.send.deny_sources, (std::vector<ByteRange>{{0xFE, 0xFE}}));
    EXPECT_EQ(settings.control.rules.limit, (std::vector<LimitRule>{{0x03, 5}}));
    EXPECT_TRUE(is_control_configured(settings));
    EXPECT_FALSE(is_control_configured(settings_of(R"({"control": {"socket": "/tmp/x"}})")));
}

TEST(Config, the_control_link_is_configured_when_it_is_named) {
    EXPECT_TRUE(is_control_configured(settings_of(R"({"routes": [{"address": 30, "link": "control"}]})")));
    EXPECT_TRUE(is_control_configured(settings_of(R"({"gateway": {"unknown": "control"}})")));
    EXPECT_TRUE(is_control_configured(
        settings_of(R"({"gpio": [{"chip": "gpiochip0", "line": 1, "use": "inhibit", "links": ["control"]}]})")));
    for (const std::string name : {"control", "tunnel"}) {
        const std::string tunnel = name == "tunnel" ? R"("links": ["sim:fc"], "tunnel": {"links": ["fc"]}, )" : "";
        EXPECT_EQ(
            faults_in("{" + tunnel + R"("gpio": [{"chip": "gpiochip0", "line": 1, "use": "rs485", "link": ")" + name + "\"}]}"),
            "/gpio/0/link: 'link' '" + name + "' is not a serial port: rs485 needs one\n");
    }
}

TEST(Config, explains_where_a_link_key_belongs) {
    for (const std::string key : {"send", "limit", "baud", "age", "group"})
        EXPECT_EQ(faults_in(R"({"links": [], ")" + key + R"(": 1})"),
                  "/" + key + ": '" + key + "' is a key of a link: put it into an object in \"links\"\n");
    EXPECT_EQ(faults_in(R"({"links": [], "id": 1})"), "/id: unknown key 'id'\n");
}

TEST(Config, dotted_keys_of_a_link_text_must_be_nested_in_a_file) {
    const auto fault = [](const std::string& keys) {
        return faults_in(R"({"links": [{"kind": "sim", "device": "fc", )" + keys + "}]}");
    };
    EXPECT_EQ(fault(R"("send.deny": ["0xB0"])"),
              "/links/0/send.deny: unknown key 'send.deny': in a file, write \"send\": {\"deny\": ...}\n");
    EXPECT_EQ(fault(R"("limit.0x01": 5)"),
              "/links/0/limit.0x01: unknown key 'limit.0x01': in a file, write \"limit\": {\"0x01\": ...}\n");
    EXPECT_EQ(fault(R"("a.b": 5)"), "/links/0/a.b: unknown key 'a.b'\n");
}

TEST(Config, a_network_in_a_file_must_be_in_a_list) {
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"], "allow": "10.8.0.0/24"}})"),
              "/tunnel/allow: 'allow' must be a list such as [\"10.8.0.0/24\"], not the text \"10.8.0.0/24\"\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "tunnel": {"links": ["fc"], "allow": "any"}})"), "");
}

TEST(Config, a_missing_key_is_reported_with_its_choices) {
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "gpio": [{"line": "A", "link": "fc"}]})")
                  .rfind("/gpio/0: 'use' is missing, one of link_up, activity, power, reset, inhibit, rs485: on while", 0),
              0u);
}

TEST(Config, flexible_layouts_are_read_and_kept_for_the_tools) {
    const std::string layout = R"({"fields":[{"name":"t","scale":0.1,"type":"i16","unit":"°C"}],"id":"0xF1","source":30})";
    const Draft draft = parse_config(R"({"flexible": [)" + layout + "]}");
    EXPECT_TRUE(draft.errors.empty());
    EXPECT_EQ(draft.settings.flexible, (std::vector<ano::FlexibleSpec>{{0xF1, 30, {{"t", ano::Type::i16, 0.1, "°C"}}}}));
    EXPECT_EQ(nlohmann::json::parse(print_config(draft.settings))["flexible"].dump(), "[" + layout + "]");
    EXPECT_EQ(parse_config(print_config(draft.settings)).settings, draft.settings);
}

TEST(Config, errors_in_flexible_layouts_name_their_location) {
    const Draft draft = parse_config(
        R"({"flexible": [{"id": 240, "fields": [{"name": "a", "type": "u8"}]},
                         {"id": "0xF1", "fields": [{"name": "a", "type": "u9"}]}]})",
        "f");
    ASSERT_EQ(draft.errors.size(), 2u);
    EXPECT_EQ(draft.errors[0].where, "f: /flexible/0/id");
    EXPECT_EQ(draft.errors[1].where, "f: /flexible/1/fields/0/type");
}

}    // namespace
}    // namespace anogate::config_tests
