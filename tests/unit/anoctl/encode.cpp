#include <gtest/gtest.h>

#include <string>

#include <support/anoctl.hpp>

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

TEST(Encode, negative_numbers_text_addresses_arrays_and_points) {
    EXPECT_EQ(anoctl({"encode", "wind", "wind_x=-1"}).out.substr(18, 12), "FF FF 00 00 ");
    EXPECT_EQ(anoctl({"encode", "log", "str=a=b, c"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "ip_tunnel", "dst_ip=10.0.0.1", "frames=[{\"name\": \"check\"}]"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "command_info", "val_type=1,4,0x7"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "command_info", "val_type=1"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "general_velocity", "speed_x=null"}).out.substr(18, 6), "00 80 ");
    EXPECT_EQ(anoctl({"encode", "log_value", "val=nan"}).exit, 0);
    EXPECT_EQ(anoctl({"encode", "ranging", "points=[{\"angle\": 1, \"dist\": 2}]"}).out.substr(18, 15),
              "64 64 00 02 00 ");
}

void expect_refused(const std::vector<std::string>& words, const std::string& said) {
    const auto result = anoctl(words);
    EXPECT_EQ(result.exit, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, "anoctl: " + said + "\n");
}

TEST(Encode, bad_input_gets_words_and_exit_code_2) {
    expect_refused({"encode", "eular"}, "there is no message 'eular' (did you mean 'euler'?)");
    expect_refused({"encode", "euler", "roll=1"}, "euler has no field 'roll' (did you mean 'rol'?)");
    expect_refused({"encode", "euler", "rol=400"}, "euler rol: '400' is out of range (i16, -327.68 to 327.67 °)");
    expect_refused({"encode", "euler", "rol=abc"}, "euler rol: 'abc' is not a number");
    expect_refused({"encode", "euler", "rol"}, "'rol' is not FIELD=VALUE");
    expect_refused({"encode", "euler", "rol=1", "rol=2"}, "'rol' is given twice");
    expect_refused({"encode", "euler", "--from", "256"}, "from: '256' is not a number from 0 to 255");
    expect_refused({"encode", "0x77", "a=1"}, "id 119 is not listed: only its data can be given");
    expect_refused({"encode", "0x77", "--data", "1"}, "data: '1' is not hex digits in pairs");
    expect_refused({"encode", "euler", "rol=1", "--data", "01"},
                   "--data is the whole of DATA: no FIELD=VALUE beside it");
    expect_refused({"encode", "flexible1", "a=1"},
                   "flexible1 has no layout in the configuration: only its data can be given");
    EXPECT_EQ(anoctl({"encode"}).exit, 2);
    EXPECT_EQ(anoctl({"encode", "ranging", "points=[{"}).exit, 2);
    EXPECT_EQ(anoctl({"encode", "-"}, "{\"name\": \"check\"}\n\n{\"name\": 5}\n").err,
              "anoctl: line 3: name: 5 is not text\n");
    EXPECT_EQ(anoctl({"encode", "-"}, "\xFF\x01").exit, 2);
}

TEST(Anoctl, help_and_version_are_fine_and_nothing_is_not) {
    EXPECT_EQ(anoctl({"--help"}).exit, 0);
    EXPECT_EQ(anoctl({"--version"}).out.substr(0, 7), "anoctl ");
    EXPECT_EQ(anoctl({"encode", "--help"}).exit, 0);
    EXPECT_EQ(anoctl({}).exit, 2);
    const auto unknown = anoctl({"--bogus"});
    EXPECT_EQ(unknown.exit, 2);
    EXPECT_EQ(unknown.err.substr(0, unknown.err.find('\n')), "anoctl: there is no option '--bogus'");
    const auto encoding = anoctl({"decode", "--encoding", "latin1", "AB"});
    EXPECT_EQ(encoding.exit, 2);
    EXPECT_EQ(encoding.err.substr(0, encoding.err.find('\n')), "anoctl: --encoding: 'latin1' is neither utf8 nor gbk");
}

}    // namespace
