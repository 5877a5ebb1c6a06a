#include <gtest/gtest.h>

#include <anoctl/text/frame_printer.hpp>

#include <sstream>
#include <string>
#include <vector>

#include <support/anoctl.hpp>
#include <support/bytes.hpp>
#include <support/temp_dir.hpp>
#include <support/v7_vectors.hpp>
#include <support/vectors.hpp>

namespace decode_tests {
namespace {

using support::anoctl;

const std::string log_hex = "AB DB FE A0 0C 00 02 74 65 73 74 46 75 6E 20 4F 4B 21 F6 1C";

std::string raw(const std::string& hex) {
    const auto bytes = ano::from_hex(hex).value();
    return {bytes.begin(), bytes.end()};
}

TEST(Decode, reads_hex_from_one_argument_or_many) {
    const std::string line = "0xDB 0xFE 0xA0 log color=2 str=\"testFun OK!\"\n";
    EXPECT_EQ(anoctl({"decode", log_hex}).out, line);
    std::vector<std::string> words{"decode"};
    for (std::size_t i = 0; i < log_hex.size(); i += 3) words.push_back(log_hex.substr(i, 2));
    EXPECT_EQ(anoctl(words).out, line);
    EXPECT_EQ(anoctl(words).exit, 0);
    EXPECT_EQ(anoctl(words).err, "");
}

TEST(Decode, reads_bytes_from_standard_input_and_from_a_file) {
    const support::TempDir folder;
    const std::string file = folder.write("frames.bin", raw(log_hex) + raw(log_hex));
    const std::string line = "0xDB 0xFE 0xA0 log color=2 str=\"testFun OK!\"\n";
    EXPECT_EQ(anoctl({"decode", file}).out, line + line);
    EXPECT_EQ(anoctl({"decode", "-"}, raw(log_hex)).out, line);
    EXPECT_EQ(anoctl({"decode"}, raw(log_hex)).out, line);
}

TEST(Decode, turns_every_golden_vector_into_json_that_encode_turns_back) {
    std::string bytes;
    std::string expected;
    std::string hex;
    for (const auto& v : support::golden_vectors()) {
        bytes.append(v.bytes.begin(), v.bytes.end());
        hex += ano::spaced_hex(v.bytes) + "\n";
    }
    const auto decoded = anoctl({"decode", "--json", "-"}, bytes);
    EXPECT_EQ(decoded.exit, 1);    // some are malformed
    const auto encoded = anoctl({"encode", "-"}, decoded.out);
    EXPECT_EQ(encoded.exit, 0) << encoded.err;
    EXPECT_EQ(encoded.out, hex);
    EXPECT_EQ(anoctl({"encode", "--raw", "-"}, decoded.out).out, bytes);
}

TEST(Decode, reports_the_offset_of_damaged_bytes) {
    std::string broken = raw(log_hex);
    broken[10] = 'X';
    const auto result = anoctl({"decode", "-"}, "abc" + raw(log_hex) + broken + raw(log_hex) + raw(log_hex).substr(0, 9));
    EXPECT_EQ(result.exit, 1);
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 2);
    EXPECT_EQ(result.err,
              "anoctl: offset 0: 3 bytes outside any frame: no frame starts here\n"
              "anoctl: offset 23: 20 bytes outside any frame: wrong checksum F6 1C, expected DA 3C\n"
              "anoctl: offset 63: 9 bytes outside any frame: truncated frame\n");
}

TEST(Decode, shows_the_expected_checksum) {
    const auto one = anoctl({"decode", "ABFEFFE00300000000 8B3C"});
    EXPECT_EQ(one.exit, 1);
    EXPECT_EQ(one.err, "anoctl: offset 0: 11 bytes outside any frame: wrong checksum 8B 3C, expected 8B 3B\n");
    EXPECT_EQ(anoctl({"decode", "ABFEFFE003000000008B3B"}).exit, 0);

    const auto several = anoctl({"decode", "00 ABFEFFE00300000000AAAA ABFEFFE00300000000BBBB" + log_hex});
    EXPECT_EQ(several.err,
              "anoctl: offset 0: 1 byte outside any frame: no frame starts here\n"
              "anoctl: offset 1: 11 bytes outside any frame: wrong checksum AA AA, expected 8B 3B\n"
              "anoctl: offset 12: 11 bytes outside any frame: wrong checksum BB BB, expected 8B 3B\n");
    EXPECT_NE(several.out, "");
}

TEST(Decode, shows_the_expected_checksum_in_json_too) {
    const auto json = anoctl({"decode", "--json", log_hex + "ABFEFFE003000000008B3C"});
    EXPECT_NE(json.out.find("\n{\"fault\":\"check\",\"offset\":20,\"hex\":\"abfeffe003000000008b3c\",\"check\":\"8b3c\",\"right_"
                            "check\":\"8b3b\"}\n"),
              std::string::npos)
        << json.out;
    EXPECT_EQ(anoctl({"encode", "-"}, json.out).out, log_hex + "\n") << "it is no frame";
}

TEST(Decode, keeps_no_more_of_a_long_gap_than_it_needs) {
    const std::string wrong = raw("ABFEFFE003000000008B3C");
    std::string junk(3 << 20, 'x');
    EXPECT_EQ(anoctl({"decode", "-"}, junk + wrong + raw(log_hex) + wrong).err,
              "anoctl: offset 0: 3145739 bytes outside any frame: wrong checksum\n"
              "anoctl: offset 3145759: 11 bytes outside any frame: wrong checksum 8B 3C, expected 8B 3B\n");
}

TEST(Decode, prints_a_short_payload_as_data_and_reports_it_on_stderr) {
    const auto result = anoctl({"encode", "euler", "--data", "0102", "--raw"});
    const auto decoded = anoctl({"decode", "-"}, result.out);
    EXPECT_EQ(decoded.exit, 1);
    EXPECT_EQ(decoded.out, "0xFE 0xFF 0x03 euler data=\"0102\"\n");
    EXPECT_EQ(decoded.err, "anoctl: offset 0: malformed euler: 2 bytes of data, expected at least 7\n");
}

TEST(Decode, reports_a_length_that_no_layout_has) {
    const auto result = anoctl({"decode", "-"}, anoctl({"encode", "euler", "--data", "000000000000000000", "--raw"}).out);
    EXPECT_EQ(result.exit, 0);
    EXPECT_EQ(result.out, "0xFE 0xFF 0x03 euler data=\"000000000000000000\"\n");
    EXPECT_EQ(result.err, "anoctl: offset 0: unknown layout of euler, LEN 9\n");
}

// Received frames have no line on standard error: their own line gives the reason for showing bytes.
TEST(Decode, reports_a_length_that_no_layout_has_in_the_line_of_a_received_frame) {
    const auto frame = support::frame(0xDC, 0xFE, 0x03, support::Bytes(9));
    for (const bool is_terminal : {false, true}) {
        std::ostringstream out, err;
        anoctl::Streams streams{-1, out, err, is_terminal};
        streams.width = 200;
        anoctl::FramePrinter printer{streams, {}};
        anoctl::Passage passage;
        passage.link = "fc";
        printer.print(ano::FrameView{frame}, passage);
        const std::string line = out.str();
        EXPECT_NE(line.find("unknown layout, LEN 9"), std::string::npos) << line;
        EXPECT_LT(line.find("unknown layout"), line.find("data")) << "before what a narrow terminal cuts off";
        out.str({});
        const auto known = support::frame(0xDC, 0xFE, 0x77, {1});
        printer.print(ano::FrameView{known}, passage);
        EXPECT_EQ(out.str().find("unknown"), std::string::npos) << out.str();
    }
}

TEST(Decode, accepts_an_unknown_id) {
    const auto decoded = anoctl({"decode", "-"}, anoctl({"encode", "0x77", "--data", "01", "--raw"}).out);
    EXPECT_EQ(decoded.exit, 0);
    EXPECT_EQ(decoded.out, "0xFE 0xFF 0x77 - data=\"01\"\n");
}

TEST(Decode, reports_bad_input_with_the_right_exit_code) {
    EXPECT_EQ(anoctl({"decode", "AB D"}).exit, 2);
    EXPECT_EQ(anoctl({"decode", "ABC"}).err, "anoctl: odd number of hex digits (3): a byte is two\n");
    EXPECT_EQ(anoctl({"decode", "/no/such/file"}).exit, 2);
    EXPECT_NE(anoctl({"decode", "/no/such/file"}).err.find("'/no/such/file'"), std::string::npos);
    EXPECT_EQ(anoctl({"decode", "-"}, "").exit, 1);
    EXPECT_EQ(anoctl({"decode", "-"}, std::string(10000, '\xAB')).exit, 1);
    EXPECT_EQ(anoctl({"decode", "-"}, std::string(100000, '\0')).out, "");
    EXPECT_EQ(anoctl({"decode", "/"}).exit, 1);
    EXPECT_EQ(anoctl({"decode", "--jsn"}).exit, 2);
}

TEST(Decode, reads_gbk_on_request) {
    const auto frame = anoctl({"encode", "--raw", "--encoding", "gbk", "log", "str=解锁"});
    EXPECT_EQ(frame.out.size(), 13u);
    EXPECT_EQ(anoctl({"decode", "-", "--encoding", "gbk"}, frame.out).out,
              "0xFE 0xFF 0xA0 log color=0 str=\"解锁\" data=\"00bde2cbf8\"\n");
}

TEST(Decode, uses_flexible_layouts_from_a_configuration) {
    const support::TempDir folder;
    const std::string config = folder.write("anogate.json", R"({// layouts
        "links": [], "flexible": [{"id": "0xF1", "fields": [{"name": "volts", "type": "i16", "scale": 0.01, "unit": "V"}]}]})");
    const auto frame = anoctl({"encode", "--config", config, "flexible1", "volts=-1.5", "--raw"});
    EXPECT_EQ(frame.exit, 0) << frame.err;
    EXPECT_EQ(anoctl({"decode", "--config", config}, frame.out).out, "0xFE 0xFF 0xF1 flexible1 volts=-1.5\n");
    EXPECT_EQ(anoctl({"decode"}, frame.out).out, "0xFE 0xFF 0xF1 flexible1 data=\"6aff\"\n");
    const std::string faulty = folder.write("faulty.json", R"({"flexible": [{"id": 5, "fields": []}]})");
    const auto refused = anoctl({"decode", "--config", faulty, log_hex});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_NE(refused.err.find("/flexible/0/id: a flexible message has an id from 0xF1 to 0xFA"), std::string::npos);
    EXPECT_EQ(anoctl({"decode", "--config", (folder.path() / "none").string(), log_hex}).exit, 2);
    EXPECT_EQ(anoctl({"decode", "--config", folder.write("no.json", "{"), log_hex}).exit, 2);
    const auto no_file = anoctl({"decode", "--config", folder.path().string(), log_hex});
    EXPECT_EQ(no_file.exit, 2);
    EXPECT_EQ(no_file.err, "anoctl: --config " + folder.path().string() + ": cannot read: Is a directory\n");
    EXPECT_EQ(anoctl({"decode", "--config", "/dev/zero", log_hex}).err,
              "anoctl: --config /dev/zero: not a regular file, but a pipe, socket or device\n");
}

TEST(Decode, shows_columns_units_and_meanings_on_a_terminal_and_no_control_characters) {
    const auto mode = anoctl({"encode", "--raw", "mode", "sflag=2", "--from", "0xDC", "--to", "254"});
    EXPECT_EQ(anoctl({"decode"}, mode.out, true).out,
              "0xDC flight controller → 0xFE host              0x06 mode               mode 0         sflag 2 (airborne) "
              "cid 0         cmd0 0         cmd1 0        \n");
    const auto colored = anoctl({"decode"}, mode.out, true, true).out;
    EXPECT_NE(colored.find("\x1b["), std::string::npos);
    const auto euler = anoctl({"encode", "--raw", "euler", "rol=1.5"});
    EXPECT_NE(anoctl({"decode"}, euler.out, true).out.find("rol 1.5 °"), std::string::npos);
    const auto hostile = anoctl({"encode", "--raw", "log", "str=\x1b[2J\xC2\x9B"});
    EXPECT_EQ(anoctl({"decode"}, hostile.out, true).out.find('\x1b'), std::string::npos);
    EXPECT_EQ(anoctl({"decode"}, hostile.out).out, "0xFE 0xFF 0xA0 log color=0 str=\"\\u001b[2J\\u009b\"\n");
}

TEST(Decode, accepts_0x_before_bytes) {
    const std::string line = "0xDB 0xFE 0xA0 log color=2 str=\"testFun OK!\"\n";
    std::string prefixed;
    for (std::size_t i = 0; i < log_hex.size(); i += 3) prefixed += "0x" + log_hex.substr(i, 2) + ", ";
    EXPECT_EQ(anoctl({"decode", prefixed}).out, line);
    EXPECT_EQ(anoctl({"decode", "0x" + ano::hex(ano::from_hex(log_hex).value())}).out, line);
    EXPECT_EQ(anoctl({"decode", "0xAB", "0xAB"}).exit, 1);
    EXPECT_EQ(anoctl({"decode", "0xABC"}).err, "anoctl: odd number of hex digits (3): a byte is two\n");
    EXPECT_EQ(anoctl({"decode", "0xAB", "zz"}).err, "anoctl: 'zz' is neither hex digits (two per byte) nor a file\n");
}

TEST(Decode, reads_hex_text_from_standard_input_and_from_a_file) {
    const support::TempDir folder;
    const std::string line = "0xDB 0xFE 0xA0 log color=2 str=\"testFun OK!\"\n";
    const std::string file = folder.write("frames.txt", log_hex + "\n\n" + log_hex + "\r\n");
    EXPECT_EQ(anoctl({"decode", file}).out, line + line);
    EXPECT_EQ(anoctl({"decode", file}).exit, 0);
    EXPECT_EQ(anoctl({"decode", "-"}, "0xAB" + log_hex.substr(2)).out, line);
    // Offsets count bytes, not characters.
    const auto junk = anoctl({"decode"}, "12 34\n" + log_hex);
    EXPECT_EQ(junk.out, line);
    EXPECT_EQ(junk.err, "anoctl: offset 0: 2 bytes outside any frame: no frame starts here\n");
    const auto broken = anoctl({"decode", "-"}, log_hex + "\n" + log_hex + "\nsome words\n");
    EXPECT_EQ(broken.exit, 1);
    EXPECT_EQ(broken.out, line + line);
    EXPECT_EQ(broken.err,
              "anoctl: standard input: line 3: the input started as hex digits, but this line contains other characters\n");
}

TEST(Decode, names_the_characters_that_are_not_hex) {
    EXPECT_EQ(anoctl({"decode", "AB", "FX"}).err, "anoctl: 'FX' is neither hex digits (two per byte) nor a file\n");
    for (const char separator : {':', '-'}) {
        const std::string word = std::string{"AB"} + separator + "FE";
        EXPECT_EQ(anoctl({"decode", word}).err, "anoctl: '" + word + "': bytes are not separated by '" + separator +
                                                    "': write spaces, commas or nothing between them\n");
    }
}

TEST(Decode, reports_text_that_was_read_as_raw_bytes) {
    const auto words = anoctl({"decode", "-"}, "AB FE\nsome words\n");
    EXPECT_EQ(words.exit, 1);
    EXPECT_NE(words.err.find("anoctl: standard input: line 2 is not hex text"), std::string::npos) << words.err;
    EXPECT_EQ(anoctl({"decode", "-"}, "some words\n" + raw(log_hex)).err.find("no hex text"), std::string::npos)
        << "frames were in it";
    EXPECT_EQ(anoctl({"decode", "-"}, std::string("\1\2\3", 3)).err.find("no hex text"), std::string::npos) << "no text";
    EXPECT_EQ(anoctl({"decode", "-"}, std::string(100, '\xAB')).err.find("no hex text"), std::string::npos)
        << "headers of frames";
}

TEST(Decode, reads_text_that_is_not_utf8_as_gbk) {
    const std::string gbk = "AB DC FE A0 05 00 00 BD E2 CB F8 8C 2A";
    EXPECT_EQ(anoctl({"decode", gbk}).out, "0xDC 0xFE 0xA0 log color=0 str=\"解锁\" data=\"00bde2cbf8\"\n");
    EXPECT_NE(anoctl({"decode", "--json", gbk}).out.find("\"str\":\"解锁\""), std::string::npos);
    EXPECT_NE(anoctl({"decode", "--encoding", "utf8", gbk}).out.find("\xEF\xBF\xBD"), std::string::npos);
    const auto utf8 = anoctl({"encode", "log", "str=解锁", "--raw"});
    EXPECT_EQ(anoctl({"decode"}, utf8.out).out, "0xFE 0xFF 0xA0 log color=0 str=\"解锁\"\n");
    EXPECT_NE(anoctl({"decode", "--encoding", "gbk"}, utf8.out).out.find("瑙ｉ攣"), std::string::npos);
}

TEST(Decode, shows_ids_and_addresses_in_hex) {
    EXPECT_EQ(anoctl({"decode", "AB DC FE 00 03 00 E1 62 3F 0A 8A"}).out,
              "0xDC 0xFE 0x00 check id_get=0xE1 sc_get=0x62 ac_get=0x3F\n");
    const std::string device = "AB DC FE E3 0C 00 DC 64 00 40 9C 00 00 20 03 54 4B 5A AC CB";
    EXPECT_NE(anoctl({"decode", device}).out.find("device_info dev_id=0xDC hw_ver=100"), std::string::npos);
    const auto tunnel = anoctl({"encode", "--raw", "ip_tunnel", "frames=[{\"name\": \"check\", \"fields\": {\"id_get\": 225}}]"});
    const std::string shown = anoctl({"decode"}, tunnel.out).out;
    EXPECT_NE(
        shown.find(
            "frames=[{\"from\":\"0xFE\",\"to\":\"0xFF\",\"id\":\"0x00\",\"name\":\"check\",\"fields\":{\"id_get\":\"0xE1\""),
        std::string::npos)
        << shown;
    // The output is valid input for encode.
    const std::string frames = shown.substr(shown.find("frames="), shown.size() - shown.find("frames=") - 1);
    EXPECT_EQ(anoctl({"encode", "--raw", "ip_tunnel", frames}).out, tunnel.out);
    // In JSON they remain numbers.
    EXPECT_NE(anoctl({"decode", "--json"}, tunnel.out).out.find("\"frames\":[{\"from\":254,\"to\":255,\"id\":0,"),
              std::string::npos);
}

TEST(Decode, reads_the_parameter_info_of_old_devices) {
    EXPECT_EQ(anoctl({"decode",
                      "AB DC FE E2 22 00 05 00 00 00 00 00 E8 03 00 00 50 49 44 5F 50 00 00 00 00 00 00 00 00 "
                      "00 00 00 00 00 00 00 67 61 69 6E A4 AE"})
                  .out,
              "0xDC 0xFE 0xE2 parameter_info par_id=5 min=0 max=1000 name=\"PID_P\" info=\"gain\"\n");
}

TEST(Decode, shows_the_value_types_of_a_command_on_a_terminal) {
    const auto info = anoctl({"encode", "--raw", "command_info", "val_type=3,7,0,10"});
    const auto shown = [&](std::vector<std::string> words) {
        words.insert(words.begin(), "decode");
        return anoctl(words, info.out, true).out;
    };
    EXPECT_NE(shown({}).find("val_type [3,7,0,10,0,0,0,0] (u16, f32, f64)"), std::string::npos) << shown({});
    EXPECT_NE(shown({"--value-type-7", "u64"}).find("(u16, u64, f64)"), std::string::npos);
    const auto refused = anoctl({"decode", "--value-type-7", "i64"}, info.out);
    EXPECT_EQ(refused.exit, 2);
    EXPECT_EQ(refused.err.substr(0, refused.err.find('\n')), "anoctl: --value-type-7: 'i64' is neither f32 nor u64");
    const auto made = anoctl({"encode", "command_info", "val_type=u16,u64", "--value-type-7", "u64"});
    EXPECT_EQ(made.out, anoctl({"encode", "command_info", "val_type=3,7"}).out);
}

TEST(Decode, distinguishes_battery_and_controller_supply_on_a_terminal) {
    const auto power = anoctl({"encode", "--raw", "power", "voltage=11.1", "voltage2=5"});
    const std::string shown = anoctl({"decode"}, power.out, true).out;
    EXPECT_NE(shown.find("voltage (battery) 11.1 V"), std::string::npos) << shown;
    EXPECT_NE(shown.find("voltage2 (controller supply) 5 V"), std::string::npos) << shown;
    const auto text = anoctl({"decode"}, power.out).out;
    EXPECT_EQ(text, "0xFE 0xFF 0x0D power voltage=11.1 current=0 voltage2=5 current2=0 reserved=0\n");
}

// --- Version 7

TEST(DecodeV7, shows_receiver_id_name_and_fields) {
    EXPECT_EQ(anoctl({"decode", "--v7", "AAFFE00B1000010000000000000000A585"}).out,
              "0xFF 0xE0 command cid=16 cmd0=0 cmd1=1 values=0000000000000000\n");
    EXPECT_EQ(anoctl({"decode", "--v7", "AAAF03078F001A00E82A001EEE"}).out,
              "0xAF 0x03 euler rol=1.43 pit=0.26 yaw=109.84 fusion_sta=0\n");
    EXPECT_EQ(anoctl({"decode", "--v7", "AAFF3407000000FFFFFFFFE046"}).out, "0xFF 0x34 ranging direction=0 angle=0 dist=null\n");
    EXPECT_EQ(anoctl({"decode", "--v7", "--json", "AAAFE2060B00E803000037F0"}).out,
              "{\"to\":175,\"id\":226,\"name\":\"parameter_value\",\"fields\":{\"par_id\":11,\"val\":1000}}\n");
    EXPECT_EQ(anoctl({"decode", "--v7", "AAAFFA0208005D65"}).out, "0xAF 0xFA flexible10 data=\"0800\"\n");
}

TEST(DecodeV7, every_vector_to_its_json_and_encode_takes_that_back) {
    std::string bytes;
    std::string hex;
    for (const auto& v : support::v7_vectors("valid")) {
        bytes.append(v.v7.begin(), v.v7.end());
        hex += ano::spaced_hex(v.v7) + "\n";
    }
    const auto decoded = anoctl({"decode", "--v7", "--json", "-"}, bytes);
    EXPECT_EQ(decoded.exit, 0) << decoded.err;
    const auto encoded = anoctl({"encode", "--v7", "-"}, decoded.out);
    EXPECT_EQ(encoded.exit, 0) << encoded.err;
    EXPECT_EQ(encoded.out, hex);
    // Other lengths and values come back as well: with their bytes.
    for (const auto& v : {support::v7_frame(0xFF, 0xE0, {0x10, 0, 1}), support::v7_frame(0xFF, 0x01, support::Bytes(18, 3)),
                          support::v7_frame(0xFF, 0xB0, {1, 2}), support::v7_frame(0xFF, 0xFB, {})}) {
        const auto json = anoctl({"decode", "--v7", "--json", ano::spaced_hex(v)}).out;
        EXPECT_EQ(anoctl({"encode", "--v7", "-"}, json).out, ano::spaced_hex(v) + "\n") << json;
    }
}

TEST(DecodeV7, tells_what_is_damaged_and_the_version_of_the_bytes) {
    const std::string good = raw("AAAF0D045E06FA00C8F9");
    std::string bad = good;
    bad[8] = 0;
    const auto result = anoctl({"decode", "--v7", "-"}, "abc" + good + bad + good + good.substr(0, 5));
    EXPECT_EQ(result.exit, 1);
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 2);
    EXPECT_EQ(result.err,
              "anoctl: offset 0: 3 bytes outside any frame: no frame starts here\n"
              "anoctl: offset 13: 10 bytes outside any frame: wrong checksum 00 F9, expected C8 F9\n"
              "anoctl: offset 33: 5 bytes outside any frame: truncated frame\n");
    EXPECT_EQ(
        anoctl({"decode", "--v7", log_hex}).err,
        "anoctl: offset 0: 20 bytes outside any frame: contains frames of protocol version 8 (0xAB), decode it without --v7\n");
    EXPECT_EQ(anoctl({"decode", "AAAF0D045E06FA00C8F9"}).err,
              "anoctl: offset 0: 10 bytes outside any frame: contains frames of protocol version 7 (0xAA), use --v7\n");
}

}    // namespace
}    // namespace decode_tests
