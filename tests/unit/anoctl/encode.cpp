#include <gtest/gtest.h>

#include <string>

#include <support/anoctl.hpp>

namespace encode_tests {
namespace {

using support::anoctl;

TEST(Encode, prints_hex_or_bytes_or_json) {
    const auto hex = anoctl({"encode", "parameter_command", "cmd=0x10", "val=0xAA", "--from", "254", "--to", "0xDB"});
    EXPECT_EQ(hex.out, "AB FE DB E0 03 00 10 AA 00 21 C3\n");
    EXPECT_EQ(hex.exit, 0);
    EXPECT_EQ(anoctl({"encode", "parameter_command", "cmd=0x10", "val=0xAA", "--to", "219", "--json"}).out,
              "{\"hex\":\"abfedbe0030010aa0021c3\"}\n");
    EXPECT_EQ(anoctl({"encode", "check", "--raw"}).out.size(), 11u);
}

TEST(Encode, accepts_negative_numbers_text_addresses_arrays_and_points) {
    EXPECT_EQ(anoctl({"encode", "wind", "wind_x=-1"}).out.substr(18, 12), "FF FF 00 00 ");
    EXPECT_EQ(anoctl({"encode", "log", "str=a=b, c"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "ip_tunnel", "dst_ip=10.0.0.1", "frames=[{\"name\": \"check\"}]"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "command_info", "val_type=1,4,0x7"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "command_info", "val_type=1"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "general_velocity", "speed_x=null"}).out.substr(18, 6), "00 80 ");
    EXPECT_EQ(anoctl({"encode", "log_value", "val=nan"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "ranging", "points=[{\"angle\": 1, \"dist\": 2}]"}).out.substr(18, 15), "64 64 00 02 00 ");
}

void expect_refused(const std::vector<std::string>& words, const std::string& said) {
    const auto result = anoctl(words);
    EXPECT_EQ(result.exit, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, "anoctl: " + said + "\n");
}

TEST(Encode, reports_bad_input_with_exit_code_2) {
    expect_refused({"encode", "eular"}, "there is no message 'eular' (did you mean 'euler'?)");
    expect_refused({"encode", "euler", "roll=1"}, "euler has no field 'roll' (did you mean 'rol'?)");
    expect_refused({"encode", "euler", "rol=400"}, "euler rol: '400' is out of range (i16, -327.68 to 327.67 °)");
    expect_refused({"encode", "euler", "rol=abc"}, "euler rol: 'abc' is not a number");
    expect_refused({"encode", "euler", "rol"}, "'rol' is not FIELD=VALUE");
    expect_refused({"encode", "euler", "rol=1", "rol=2"}, "'rol' is given twice");
    expect_refused({"encode", "euler", "--from", "256"}, "from: '256' is not a number from 0 to 255");
    expect_refused({"encode", "euler", "--to", "DC"}, "to: 'DC' is not an address from 0 to 255 (did you mean '0xDC'?)");
    expect_refused({"encode", "E0", "--data", "00"}, "there is no message 'E0' (did you mean '0xE0'?)");
    expect_refused({"encode", "check", "id_get=E0"}, "check id_get: 'E0' is not a number (did you mean '0xE0'?)");
    EXPECT_EQ(anoctl({"encode", "-"}, "{\"id\": \"E0\"}\n").err,
              "anoctl: line 1: id: 'E0' is not a number from 0 to 255 (did you mean '0xE0'?)\n");
    EXPECT_EQ(anoctl({"encode", "check", "--to", "12"}).out, anoctl({"encode", "check", "--to", "0x0C"}).out) << "decimal";
    expect_refused({"encode", "0x77", "a=1"}, "id 0x77 is not listed: only its data can be given");
    expect_refused({"encode", "0x77", "--data", "1"}, "data: '1' is not hex digits in pairs");
    expect_refused({"encode", "euler", "rol=1", "--data", "01"},
                   "--data gives the complete DATA and cannot be combined with FIELD=VALUE");
    expect_refused({"encode", "flexible1", "a=1"}, "flexible1 has no layout in the configuration: only its data can be given");
    expect_refused({"encode", "heartbeat"}, "there is no message 'heartbeat'; to list them: anoctl messages");
    EXPECT_EQ(anoctl({"encode"}).exit, 2);
    const auto first_line = [](const std::vector<std::string>& words) {
        return support::anoctl(words).err.substr(0, support::anoctl(words).err.find('\n'));
    };
    EXPECT_EQ(first_line({"encode"}), "anoctl: missing NAME");
    EXPECT_EQ(first_line({"waypoint"}), "anoctl: missing ACTION; choices: get or put");
    EXPECT_EQ(first_line({"param"}), "anoctl: missing ACTION; choices: list, get, set, save, reset, export, import or diff");
    EXPECT_EQ(first_line({"calibrate"}), "anoctl: missing WHAT; choices: accelerometer or compass");
    EXPECT_EQ(first_line({"convert", "a.mcap"}), "anoctl: missing OUT_FILE");
    EXPECT_EQ(first_line({"recordings", "--secs"}), "anoctl: unknown option '--secs' (did you mean '--seconds'?)");
    EXPECT_EQ(first_line({"encode", "check", "--rwa"}), "anoctl: unknown option '--rwa' (did you mean '--raw'?)");
    EXPECT_EQ(first_line({"encode", "check", "--to"}), "anoctl: --to: missing value");
    EXPECT_EQ(anoctl({"encode", "ranging", "points=[{"}).exit, 2);
    EXPECT_EQ(anoctl({"encode", "-"}, "{\"name\": \"check\"}\n\n{\"name\": 5}\n").err, "anoctl: line 3: name: 5 is not text\n");
    EXPECT_EQ(anoctl({"encode", "-"}, "\xFF\x01").exit, 2);
}

TEST(Encode, accepts_the_value_names_that_are_shown) {
    EXPECT_EQ(anoctl({"encode", "parameter_command", "cmd=action", "val=save", "--to", "0xDC"}).out,
              "AB FE DC E0 03 00 10 AB 00 23 CC\n");
    EXPECT_EQ(anoctl({"encode", "log", "color=green"}).out, anoctl({"encode", "log", "color=2"}).out);
    EXPECT_EQ(anoctl({"encode", "parameter_info", "par_type=f32"}).out, anoctl({"encode", "parameter_info", "par_type=8"}).out);
    EXPECT_EQ(anoctl({"encode", "command_info", "val_type=u16,i32"}).out, anoctl({"encode", "command_info", "val_type=3,6"}).out);
    EXPECT_EQ(anoctl({"encode", "check", "--from", "flight controller", "--to", "host"}).out,
              anoctl({"encode", "check", "--from", "0xDC", "--to", "0xFE"}).out);
    expect_refused({"encode", "log", "color=grene"},
                   "log color: 'grene' is not a number, nor default, red, green, blue (did you mean 'green'?)");
}

TEST(Encode, accepts_values_with_their_types) {
    EXPECT_EQ(anoctl({"encode", "parameter_value", "par_id=3", "value=f32:1.5", "--to", "0xDC"}).out,
              "AB FE DC E1 06 00 03 00 00 00 C0 3F 6E 70\n");
    EXPECT_EQ(anoctl({"encode", "command", "cid0=1", "cid2=1", "values=u16:100,i32:-5", "--to", "0xDC"}).out,
              "AB FE DC C0 09 00 01 00 01 64 00 FB FF FF FF AC C6\n");
    EXPECT_EQ(anoctl({"encode", "parameter_value", "value=string:a,b"}).exit, 0);
    expect_refused({"encode", "command", "values=u8:300"}, "command values: '300' is out of range (u8, 0 to 255)");
}

TEST(Encode, rejects_a_parameter_value_shorter_than_its_type) {
    const std::string behind =
        "; a device would store check bytes of the frame with it: write it with its type, such as f32:1.5 or string:abc";
    expect_refused({"encode", "parameter_value", "par_id=1"}, "parameter_value value: it is empty" + behind);
    expect_refused({"encode", "parameter_value", "value=0000c0"},
                   "parameter_value value: '0000c0' is 3 bytes, as no number is" + behind);
    expect_refused({"encode", "parameter_value", "value=0000", "par_type=f32"},
                   "parameter_value value: '0000' is 2 bytes, f32 has 4" + behind);
    EXPECT_EQ(anoctl({"encode", "-"}, "{\"name\": \"parameter_value\", \"fields\": {\"par_id\": 1}}\n").exit, 2);
}

TEST(Anoctl, accepts_json_before_the_command) {
    EXPECT_EQ(anoctl({"--json", "encode", "check"}).out, anoctl({"encode", "check", "--json"}).out);
    EXPECT_EQ(anoctl({"--json", "messages", "euler"}).out, anoctl({"messages", "euler", "--json"}).out);
    EXPECT_EQ(anoctl({"--json", "decode", "AB"}).exit, 1);
    EXPECT_EQ(anoctl({"--json", "messages", "--lua"}).exit, 2);
    EXPECT_EQ(anoctl({"--json", "--help"}).exit, 0);
    EXPECT_EQ(anoctl({"--json"}).err,
              "anoctl: --json requires a command; commands: decode, encode, messages, monitor, ports, setup, status, links, "
              "routes, metrics, reload, flexible, send, devices, param, command, waypoint, flash, calibrate, log, alarms, image, "
              "terminal, top, record, "
              "recordings, info, convert, replay, plot-udp, web, certificate\n");
    EXPECT_EQ(anoctl({"--json", "encod"}).err.rfind("anoctl: unknown command 'encod' (did you mean 'encode'?)", 0), 0u);
}

TEST(Anoctl, names_the_place_of_an_option_of_a_command) {
    EXPECT_EQ(anoctl({"--yes", "command", "LAND"}).err, "anoctl: place --yes after the command: anoctl command --yes ...\n");
    EXPECT_EQ(anoctl({"--json", "--device=0xDC", "param", "list"}).err,
              "anoctl: place --device after the command: anoctl param --device=0xDC ...\n");
    EXPECT_EQ(anoctl({"--device", "0xDC", "param", "list"}).err,
              "anoctl: place --device after the command: anoctl param --device ...\n");
    EXPECT_EQ(anoctl({"--yes"}).exit, 2);
}

TEST(Anoctl, help_of_a_command_lists_only_the_options_that_it_accepts) {
    EXPECT_NE(anoctl({"--help"}).out.find("--json"), std::string::npos);
    for (const char* words : {"Devices:", "Recordings:", "Gateway:", "Examples:"})
        EXPECT_NE(anoctl({"--help"}).out.find(words), std::string::npos) << words;
    EXPECT_NE(anoctl({"param", "--help"}).out.find("anoctl param diff backup.json"), std::string::npos);
    EXPECT_EQ(anoctl({"-V"}).out, anoctl({"--version"}).out);
    EXPECT_EQ(anoctl({"-V"}).exit, 0);
    for (const char* word : {"status", "start", "stop"}) {
        const auto ran = anoctl({"record", word});
        EXPECT_EQ(ran.exit, 2);
        EXPECT_NE(ran.err.find("anoctl recordings "), std::string::npos) << ran.err;
    }
    EXPECT_NE(anoctl({"status", "--help"}).out.find("--json"), std::string::npos);
    EXPECT_EQ(anoctl({"top", "--help"}).out.find("--json"), std::string::npos) << anoctl({"top", "--help"}).out;
    EXPECT_EQ(anoctl({"decode", "--help"}).out.find("--control"), std::string::npos);
}

TEST(Anoctl, explains_how_to_monitor_a_link_of_the_gateway) {
    const auto refused = anoctl({"monitor", "fc"});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_TRUE(refused.err.ends_with("; for a link of the gateway, give its name: monitor --link 'fc'\n")) << refused.err;
    EXPECT_EQ(anoctl({"monitor", "/dev/ttyUSB0"}).err.find("--link"), std::string::npos);
}

TEST(Anoctl, rejects_a_count_that_is_not_a_positive_number) {
    for (const char* count : {"0", "-1", "many", "1.5"}) {
        const auto result = anoctl({"monitor", "pty:/no/such/folder/x", std::string{"--count="} + count});
        EXPECT_EQ(result.exit, 2) << count;
        EXPECT_EQ(result.err.substr(0, result.err.find('\n')),
                  "anoctl: --count: '" + std::string{count} + "' is not a number of frames, 1 or more");
    }
    EXPECT_EQ(anoctl({"monitor", "pty:/no/such/folder/x", "--count", "-1"}).exit, 2);
}

TEST(Anoctl, disables_colours_according_to_the_environment) {
    EXPECT_TRUE(anoctl::use_color(nullptr, "xterm"));
    EXPECT_TRUE(anoctl::use_color("", "xterm"));    // by the rule of no-color.org
    EXPECT_FALSE(anoctl::use_color("1", "xterm"));
    EXPECT_FALSE(anoctl::use_color("0", "xterm"));
    EXPECT_FALSE(anoctl::use_color(nullptr, "dumb"));
    EXPECT_FALSE(anoctl::use_color(nullptr, nullptr));
}

TEST(Anoctl, accepts_help_and_version_but_not_an_empty_command_line) {
    EXPECT_EQ(anoctl({"--help"}).exit, 0);
    EXPECT_EQ(anoctl({"--version"}).out.substr(0, 7), "anoctl ");
    EXPECT_EQ(anoctl({"encode", "--help"}).exit, 0);
    EXPECT_EQ(anoctl({}).exit, 2);
    const auto unknown = anoctl({"--bogus"});
    EXPECT_EQ(unknown.exit, 2);
    EXPECT_EQ(unknown.err.substr(0, unknown.err.find('\n')), "anoctl: unknown option '--bogus'");
    const auto encoding = anoctl({"decode", "--encoding", "latin1", "AB"});
    EXPECT_EQ(encoding.exit, 2);
    EXPECT_EQ(encoding.err.substr(0, encoding.err.find('\n')), "anoctl: --encoding: 'latin1' is neither utf8 nor gbk");
}

TEST(Anoctl, treats_a_negative_number_as_a_value) {
    const auto ran = anoctl({"encode", "wind", "-1.5"});
    EXPECT_EQ(ran.exit, 2);
    EXPECT_EQ(ran.err.find("anoctl: '-1.5' "), 0u) << ran.err;
    EXPECT_EQ(ran.err.find("unknown option"), std::string::npos) << ran.err;
    EXPECT_EQ(anoctl({"encode", "wind", "-x"}).err.find("anoctl: unknown option '-x'"), 0u);
}

// --- Version 7

TEST(EncodeV7, makes_the_vendors_frames) {
    EXPECT_EQ(anoctl({"encode", "--v7", "command", "cid=0x10", "cmd1=5", "values=u16:150"}).out,
              "AA FF E0 0B 10 00 05 96 00 00 00 00 00 00 00 3F 59\n");
    EXPECT_EQ(anoctl({"encode", "--v7", "parameter_read", "par_id=10", "--to", "flight controller"}).out,
              "AA 05 E1 02 0A 00 9C B3\n");
    EXPECT_EQ(anoctl({"encode", "--v7", "power", "voltage=16.3", "current=2.5", "--to", "host"}).out.substr(0, 11),
              "AA AF 0D 04");
    EXPECT_EQ(anoctl({"encode", "--v7", "0xF2", "--data", "01 00004842"}).out, "AA FF F2 05 01 00 00 48 42 2B 85\n");
}

TEST(EncodeV7, refuses_what_version_7_does_not_have) {
    expect_refused({"encode", "--v7", "parameter_reed"},
                   "version 7 has no message 'parameter_reed' (did you mean 'parameter_read'?)");
    expect_refused({"encode", "--v7", "ranging", "type=1"}, "ranging has no field 'type'");
    expect_refused({"encode", "--v7", "0xC1", "cmd=1"}, "id 0xC1 is not listed: only its data can be given");
    EXPECT_EQ(anoctl({"encode", "--v7", "firmware"}).exit, 2);
    EXPECT_EQ(anoctl({"encode", "--v7", "euler", "--from", "1"}).exit, 2);
}

}    // namespace
}    // namespace encode_tests
