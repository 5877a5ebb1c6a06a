// anoctl info and convert, with files written by record.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <record/mcap/mcap_format.hpp>
#include <support/anoctl.hpp>
#include <support/files.hpp>
#include <support/recorded.hpp>
#include <support/temp_dir.hpp>

namespace recordings_tests {
namespace {

using nlohmann::json;
using support::anoctl;
using support::file_text;
using support::KeptItem;

constexpr std::uint64_t second = 1'000'000'000;

KeptItem item(double at, const support::Bytes& frame, anogate::Direction direction = anogate::Direction::in,
              std::string cause = {}) {
    KeptItem item;
    item.time_ns = 1'763'898'044 * second + static_cast<std::uint64_t>(at * 1e9);
    item.boottime_ns = 100 * second + static_cast<std::uint64_t>(at * 1e9);
    item.link = "fc";
    item.description = "serial";
    item.direction = direction;
    item.cause = std::move(cause);
    item.frame = frame;
    return item;
}

std::string flight() {
    const auto euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
    const auto wind = support::frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});
    KeptItem lost;
    lost.lost = 7;
    lost.names = "euler 4, power 3";
    return support::write_pcapng(
        {item(0, euler), item(0.5, wind), lost, item(1, euler), item(2, wind, anogate::Direction::dropped, "limited")},
        {"anoctl 0.1.0", 1'763'898'044 * second, 100 * second});
}

TEST(Info, shows_the_contents_of_a_recording) {
    const support::TempDir folder;
    const auto said = anoctl({"info", folder.write("flight.pcapng", flight())});
    EXPECT_EQ(said.exit, 0) << said.err;
    for (const char* words : {"pcapng of anoctl 0.1.0", "4 frames in 2.0 s",
                              "7 frames are missing: the buffer of the gateway was full: euler 4, power 3",
                              "fc    serial   3    0        1  limited 1", "0x03  euler         2        1.00     30  0xDC"})
        EXPECT_NE(said.out.find(words), std::string::npos) << words << "\n" << said.out;
    const json told = json::parse(anoctl({"info", "--json", "-"}, flight()).out);
    EXPECT_EQ(told["frames"], 4);
    EXPECT_EQ(told["lost"], 7);
    EXPECT_EQ(told["lost_messages"], json({{"euler", 4}, {"power", 3}}));
    EXPECT_EQ(told["ended"], true);
    EXPECT_EQ(told["seconds"], 2.0);
    EXPECT_EQ(told["messages"].size(), 2u);
    EXPECT_EQ(told["messages"][0]["rate"], 1.0);
    EXPECT_EQ(told["links"][0]["causes"], json({{"limited", 1}}));
}

TEST(Convert, texts_of_a_device_can_not_control_the_terminal) {
    const std::string harmful = "\x1b[31m\xC2\x9B\xE2\x80\xAE end";
    support::Bytes data{0};
    data.insert(data.end(), harmful.begin(), harmful.end());
    const std::string recorded = support::write_pcapng({item(0, support::frame(0xDC, 0xFE, 0xA0, data))},
                                                       {"anoctl 0.1.0", 1'763'898'044 * second, 100 * second});
    const auto has_any = [](const std::string& text) {
        return text.find('\x1b') != text.npos || text.find("\xC2\x9B") != text.npos || text.find("\xE2\x80\xAE") != text.npos;
    };
    const auto lines = anoctl({"convert", "-", "-"}, recorded);
    EXPECT_FALSE(has_any(lines.out)) << lines.out;
    EXPECT_NE(lines.out.find("\\u001b[31m\\u009b\\u202e end"), std::string::npos) << lines.out << lines.err;
    const auto table = anoctl({"convert", "-", "-", "--id", "0xA0"}, recorded, true);
    EXPECT_FALSE(has_any(table.out)) << table.out;
    EXPECT_NE(table.out.find("\\u001b[31m\\u009b\\u202e end,"), std::string::npos) << table.out << table.err;
    EXPECT_TRUE(has_any(anoctl({"convert", "-", "-", "--id", "0xA0"}, recorded).out)) << "a program gets the bytes of the device";
}

TEST(Info, reads_truncated_and_damaged_recordings_and_reports_the_damage) {
    const std::string whole = flight();
    const auto cut = anoctl({"info", "-"}, whole.substr(0, whole.size() - 60));
    EXPECT_EQ(cut.exit, 0);
    EXPECT_NE(cut.out.find("cut off: the last "), std::string::npos) << cut.out;
    const auto running = anoctl({"info", "-"},
                                support::write_pcapng({item(0, support::frame(1, 2, 3))}, {"anoctl 0.1.0"}, false));
    EXPECT_NE(running.out.find("not finished: the recording is still running"), std::string::npos) << running.out;
    const auto damaged = anoctl({"info", "-"}, whole + std::string(5000, '\0'));
    EXPECT_EQ(damaged.exit, 1);
    EXPECT_NE(damaged.out.find("4 frames"), std::string::npos);
    EXPECT_NE(damaged.out.find("damaged after byte " + std::to_string(whole.size())), std::string::npos) << damaged.out;
}

TEST(Info, reports_that_the_clock_was_set) {
    std::vector<KeptItem> items{item(0, support::frame(1, 2, 3)), item(2, support::frame(1, 2, 3))};
    items[1].time_ns -= 3600 * second;
    const auto said = anoctl({"info", "-"}, support::write_pcapng(items, {"anoctl 0.1.0"}));
    EXPECT_NE(said.out.find("the clock was set back by"), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("2 frames in 2.0 s"), std::string::npos) << said.out;
}

TEST(Info, reports_files_that_are_not_recordings) {
    const support::TempDir folder;
    EXPECT_EQ(anoctl({"info", folder / "nothing"}).exit, 2);
    EXPECT_NE(anoctl({"info", "-"}, "").err.find("the file is empty"), std::string::npos);
    const auto text = anoctl({"info", folder.write("a.txt", "no capture, but more than enough text")});
    EXPECT_EQ(text.exit, 1);
    EXPECT_NE(text.err.find("it is neither pcapng nor MCAP"), std::string::npos);
    EXPECT_EQ(anoctl({"info", folder.path().string()}).exit, 2);
}

TEST(Convert, writes_one_table_per_message) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    const auto made = anoctl({"convert", file, folder / "out.csv"});
    EXPECT_EQ(made.exit, 0) << made.err;
    EXPECT_NE(made.err.find("4 frames of "), std::string::npos);
    const std::string euler = file_text(folder / "out-euler.csv");
    EXPECT_TRUE(euler.starts_with("time [s],link,peer,frame_direction,frame_cause,from,to,rol [°],")) << euler;
    EXPECT_NE(euler.find("\n1763898045.000000000,fc,,in,,220,254,1.23,0,0,1,,,\n"), std::string::npos) << euler;
    EXPECT_NE(file_text(folder / "out-wind.csv").find("dropped,limited"), std::string::npos);
    const auto again = anoctl({"convert", file, folder / "out.csv"});
    EXPECT_EQ(again.exit, 2);
    EXPECT_NE(again.err.find("already exists; use --force to overwrite it"), std::string::npos) << again.err;
    EXPECT_EQ(anoctl({"convert", file, folder / "out.csv", "--force"}).exit, 0);
    EXPECT_EQ(file_text(folder / "out-euler.csv"), euler);
}

TEST(Convert, names_the_written_files) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    const std::string tables = anoctl({"convert", file, folder / "out.csv"}).err;
    EXPECT_NE(tables.find(" written into 2 tables: "), std::string::npos) << tables;
    EXPECT_NE(tables.find(folder / "out-euler.csv"), std::string::npos) << tables;
    const std::string lines = anoctl({"convert", file, folder / "out.ndjson"}).err;
    EXPECT_NE(lines.find(" written into " + (folder / "out.ndjson")), std::string::npos) << lines;
    EXPECT_EQ(anoctl({"convert", file, "-"}).err.find(" into "), std::string::npos);
    const std::string none = anoctl({"convert", file, folder / "none.csv", "--id", "mode", "gps"}).err;
    EXPECT_NE(none.find(" written: no table was written"), std::string::npos) << none;
}

// With `alias anoctl='anoctl --control X'` the option is passed to these as well, although they use no gateway.
TEST(Info, accepts_the_control_option_without_using_it) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight()), nobody = folder / "control.sock";
    const std::string plain = anoctl({"info", file}).out;
    EXPECT_EQ(anoctl({"--control", nobody, "info", file}).out, plain);
    EXPECT_EQ(anoctl({"info", file, "--control", nobody}).out, plain);
    EXPECT_EQ(anoctl({"convert", file, "-", "--control", nobody}).exit, 0);
}

TEST(Convert, writes_a_single_table_for_one_message) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "one.csv", "--id", "euler"}).exit, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "one.csv"));
    EXPECT_EQ(anoctl({"convert", file, "-", "--id", "euler"}).out, file_text(folder / "one.csv"));
}

TEST(Convert, writes_lines_of_json) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "out.ndjson"}).exit, 0);
    const std::string lines = file_text(folder / "out.ndjson");
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 5);
    EXPECT_EQ(json::parse(lines.substr(0, lines.find('\n')))["fields"]["rol"], 1.23);
    EXPECT_EQ(anoctl({"convert", file, "-"}).out, lines);
}

TEST(Convert, writes_part_of_a_recording_or_a_copy_with_the_same_bytes) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "all.pcapng"}).exit, 0);
    EXPECT_EQ(file_text(folder / "all.pcapng"), flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "part.pcapng", "--id", "wind"}).exit, 0);
    EXPECT_EQ(support::read_pcapng(file_text(folder / "part.pcapng")).items.size(), 3u);    // with the loss
}

TEST(Convert, rejects_unusable_output_files) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "out.xlsx"}).exit, 2);
    EXPECT_EQ(anoctl({"convert", file, file, "--force"}).exit, 2);
    EXPECT_EQ(file_text(file), flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "no/such/folder.ndjson"}).exit, 2);
    EXPECT_EQ(anoctl({"convert", file, "/dev/full", "--force"}).exit, 2);    // no ending
}

TEST(Record, rejects_unusable_arguments) {
    const support::TempDir folder;
    const std::string nobody = folder / "control.sock";
    EXPECT_EQ(anoctl({"record", folder / "a.csv", "--control", nobody}).exit, 2);
    EXPECT_EQ(anoctl({"record", folder / "a.pcapng", "--control", nobody, "--seconds", "-1"}).exit, 2);
    EXPECT_EQ(anoctl({"record", "-", "--control", nobody}, {}, true).exit, 2);
    EXPECT_EQ(anoctl({"record", folder / "a.pcapng", "--control", nobody}).exit, 1);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.pcapng"));    // nothing is left if there was nothing to record
}

TEST(Convert, uses_the_attitude_and_the_encoding_of_the_configuration_for_its_links) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight()), out = folder / "out.pcapng";
    const auto convert = [&](const std::string& in, const std::string& config) {
        const auto made = anoctl({"convert", in, out, "--force", "--config", folder.write("c.json", config)});
        EXPECT_EQ(made.exit, 0) << made.err;
        return file_text(out);
    };
    const std::string lx = convert(file, R"({"links": ["sim:fc,attitude=lx,encoding=gbk"]})");
    EXPECT_NE(lx.find(R"("attitude":{"fc":"lx"})"), std::string::npos);
    EXPECT_NE(lx.find(R"("encoding":{"fc":"gbk"})"), std::string::npos);
    const std::string recorded = folder.write("lx.pcapng", lx);
    EXPECT_NE(convert(recorded, R"({"flexible": []})").find(R"("attitude":{"fc":"lx"})"), std::string::npos);
    EXPECT_EQ(convert(recorded, R"({"links": ["sim:fc"]})").find(R"("attitude")"), std::string::npos);
}

TEST(Convert, reports_layouts_that_cannot_be_read) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    const std::string config = folder.write("c.json", R"({"links": ["sim:fc,attitude=lx"]})");
    ASSERT_EQ(anoctl({"convert", file, folder / "lx.pcapng", "--config", config}).exit, 0);
    std::string damaged = file_text(folder / "lx.pcapng");
    const std::size_t at = damaged.find(R"({"attitude")");
    ASSERT_NE(at, std::string::npos);
    damaged[at] = '[';
    const auto made = anoctl({"convert", folder.write("damaged.pcapng", damaged), "-"});
    EXPECT_NE(made.err.find("layouts in the recording can't be read"), std::string::npos) << made.err;
    EXPECT_EQ(anoctl({"convert", file, "-"}).err.find("layouts"), std::string::npos);
}

TEST(Convert, writes_mcap_that_converts_back_to_the_same_pcapng) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "flight.mcap"}).exit, 0);
    const auto read = support::read_recording(file_text(folder / "flight.mcap"));
    EXPECT_EQ(read.items, support::read_recording(flight()).items);
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(anoctl({"convert", folder / "flight.mcap", folder / "again.pcapng"}).exit, 0);
    EXPECT_EQ(file_text(folder / "again.pcapng"), flight());
    EXPECT_EQ(anoctl({"convert", folder / "flight.mcap", folder / "again.mcap"}).exit, 0);
    EXPECT_EQ(file_text(folder / "again.mcap"), file_text(folder / "flight.mcap"));
    EXPECT_EQ(anoctl({"convert", folder / "flight.mcap", "-"}).out, anoctl({"convert", file, "-"}).out);
}

TEST(Convert, writes_decoded_messages_in_the_requested_encoding) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "a.mcap", "--message-encoding", "json"}).exit, 0);
    EXPECT_NE(file_text(folder / "a.mcap").find("jsonschema"), std::string::npos);    // in the summary, which is not compressed
    EXPECT_EQ(file_text(folder / "a.mcap").find("ros2msg", file_text(folder / "a.mcap").find("jsonschema")), std::string::npos);
    EXPECT_EQ(anoctl({"convert", file, folder / "b.mcap", "--message-encoding", "xml"}).exit, 2);
    const auto other = anoctl({"convert", file, folder / "b.pcapng", "--message-encoding", "cdr"});
    EXPECT_EQ(other.exit, 2);
    EXPECT_NE(other.err.find("name OUT_FILE with .mcap"), std::string::npos) << other.err;
}

TEST(Info, shows_the_same_for_mcap_from_the_index_as_from_the_whole_file) {
    const support::TempDir folder;
    const std::string file = folder.write("flight.pcapng", flight()), mcap = folder / "flight.mcap";
    ASSERT_EQ(anoctl({"convert", file, mcap}).exit, 0);
    const auto said = anoctl({"info", mcap});
    EXPECT_EQ(said.exit, 0);
    EXPECT_NE(said.out.find("mcap of anoctl 0.1.0"), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("4 frames in 2.0 s"), std::string::npos) << said.out;
    EXPECT_EQ(anoctl({"info", mcap, "--all"}).out, said.out);
    json indexed = json::parse(anoctl({"info", "--json", mcap}).out),
         of_pcapng = json::parse(anoctl({"info", "--json", file}).out);
    EXPECT_EQ(indexed["format"], "mcap");
    for (const char* key : {"file", "format", "bytes"}) indexed.erase(key), of_pcapng.erase(key);
    EXPECT_EQ(indexed, of_pcapng);
}

TEST(Info, reads_all_of_an_mcap_file_whose_index_is_missing_or_wrong) {
    const support::TempDir folder;
    ASSERT_EQ(anoctl({"convert", folder.write("flight.pcapng", flight()), folder / "flight.mcap"}).exit, 0);
    const std::string whole = file_text(folder / "flight.mcap");
    const auto cut = anoctl({"info", folder.write("cut.mcap", whole.substr(0, whole.size() - 100))});
    EXPECT_EQ(cut.exit, 0) << cut.err;
    EXPECT_NE(cut.out.find("4 frames in 2.0 s"), std::string::npos) << cut.out;
    EXPECT_NE(cut.out.find("cut off: the last "), std::string::npos) << cut.out;
    std::string damaged = whole;
    damaged[damaged.find("zstd") + 20] ^= 1;
    const auto by_index = anoctl({"info", folder.write("damaged.mcap", damaged)});
    EXPECT_EQ(by_index.exit, 0);
    const auto all = anoctl({"info", "--all", folder / "damaged.mcap"});
    EXPECT_EQ(all.exit, 1);
    EXPECT_NE(all.out.find("the chunk at byte "), std::string::npos) << all.out;
    EXPECT_NE(all.out.find(" is damaged and skipped, "), std::string::npos) << all.out;
    EXPECT_NE(all.out.find("4 frames cannot be read because of this"), std::string::npos) << all.out;
    const json told = json::parse(anoctl({"info", "--all", "--json", folder / "damaged.mcap"}).out);
    EXPECT_EQ(told["skipped"]["parts"], 1);
    EXPECT_EQ(told["skipped"]["frames"], 4);
    EXPECT_EQ(told["skipped"]["first"].size(), 1u);
    EXPECT_EQ(told["unread"], 0);
    EXPECT_EQ(told["fault"], nullptr);
}

TEST(Info, finds_damage_outside_of_chunks) {
    const support::TempDir folder;
    const std::string file = folder / "flight.mcap";
    ASSERT_EQ(anoctl({"convert", folder.write("flight.pcapng", flight()), file}).exit, 0);
    const std::string whole = file_text(file);
    EXPECT_EQ(json::parse(anoctl({"info", "--all", "--json", file}).out)["mismatches"], json::array());
    const std::size_t in_data = whole.find("anogate.recording") + 1, in_summary = whole.rfind("anogate.summary") + 1;
    const std::size_t in_footer = whole.size() - 8 - 4 - 1;    // the position of its offsets, before CRC and magic
    const std::pair<std::size_t, const char*> places[] = {{in_data, "the data does not match the CRC in its DataEnd"},
                                                          {in_summary, "its summary does not match the CRC in its Footer"},
                                                          {in_footer, "its summary does not match the CRC in its Footer"}};
    for (const auto& [place, words] : places) {
        std::string damaged = whole;
        damaged[place] ^= 1;
        const auto said = anoctl({"info", "--all", folder.write("damaged.mcap", damaged)});
        EXPECT_EQ(said.exit, 1) << place;
        EXPECT_NE(said.out.find(words), std::string::npos) << said.out;
        EXPECT_NE(said.out.find("4 frames in 2.0 s"), std::string::npos) << said.out;
        const auto made = anoctl({"convert", folder / "damaged.mcap", folder / "good.pcapng", "--force"});
        EXPECT_EQ(made.exit, 1);
        EXPECT_NE(made.err.find(words), std::string::npos) << made.err;
        EXPECT_EQ(support::read_recording(file_text(folder / "good.pcapng")).items.size(), 5u);
    }
}

TEST(Info, accepts_a_file_whose_crc_is_absent) {
    const support::TempDir folder;
    const std::string file = folder / "flight.mcap";
    ASSERT_EQ(anoctl({"convert", folder.write("flight.pcapng", flight()), file}).exit, 0);
    std::string whole = file_text(file);
    whole.replace(whole.size() - 8 - 4, 4, 4, '\0');
    EXPECT_EQ(anoctl({"info", "--all", folder.write("untold.mcap", whole)}).exit, 0);
}

TEST(Info, reports_damage_in_the_middle_and_reads_the_data_after_it) {
    const std::string whole = flight();
    std::string damaged = whole;
    const auto packet = damaged.find(std::string{"\x06\0\0\0", 4});
    damaged[packet + 8] = '\x7F';    // its interface
    const auto said = anoctl({"info", "-"}, damaged);
    EXPECT_EQ(said.exit, 1);
    EXPECT_NE(said.out.find("3 frames in"), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("the block at byte " + std::to_string(packet) +
                            " is damaged and skipped, 1 message: a packet belongs to an interface without a description"),
              std::string::npos)
        << said.out;
    const support::TempDir folder;
    const auto made = anoctl({"convert", folder.write("damaged.pcapng", damaged), folder / "good.pcapng"});
    EXPECT_EQ(made.exit, 1);
    EXPECT_NE(made.err.find("the block at byte "), std::string::npos) << made.err;
    EXPECT_EQ(support::read_recording(file_text(folder / "good.pcapng")).skipped.count, 0u);
}

// A section header and the description of an interface with `link_type`, with a packet.
std::string capture_of(char link_type) {
    const auto word = [](std::uint32_t number) {
        std::string text;
        for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(number >> shift & 0xFF);
        return text;
    };
    const auto block = [&](std::uint32_t type, const std::string& body) {
        const auto size = static_cast<std::uint32_t>(body.size() + 12);
        return word(type) + word(size) + body + word(size);
    };
    return block(0x0A0D0D0A, word(0x1A2B3C4D) + word(1) + word(~0u) + word(~0u)) +
           block(1, std::string{link_type, 0, 0, 0} + word(0)) +
           block(6, word(0) + word(0) + word(0) + word(4) + word(4) + "abcd");
}

TEST(Info, reports_that_a_network_capture_is_not_a_recording_of_a_gateway) {
    const support::TempDir folder;
    const std::string file = folder.write("network.pcapng", capture_of(1));
    const std::vector<std::vector<std::string>> all{
        {"info", file}, {"convert", file, folder / "a.mcap"}, {"replay", file, "udp:127.0.0.1:9"}};
    for (const auto& words : all) {
        const auto said = anoctl(words);
        EXPECT_EQ(said.exit, 1) << words[0];
        EXPECT_NE(said.err.find("this is a network capture, not a recording of a gateway"), std::string::npos) << said.err;
    }
    EXPECT_EQ(anoctl({"info", "-"}, capture_of(static_cast<char>(147))).exit, 0);    // LINKTYPE_USER0
}

TEST(Record, accepts_endings_in_capitals_and_rejects_unknown_endings) {
    const support::TempDir folder;
    const auto record = [&](const std::string& name) {
        return anoctl({"record", folder / name, "--control", folder / "none.sock"});
    };
    for (const char* name : {"f.mcap.gz", "f.PCAP", "f.csv"}) {
        const auto refused = record(name);
        EXPECT_EQ(refused.exit, 2) << name;
        EXPECT_NE(refused.err.find("name the file .pcapng or .mcap"), std::string::npos) << refused.err;
    }
    EXPECT_NE(record("flight2").err.find("flight2: writing pcapng; for MCAP, end the name with .mcap"), std::string::npos);
    EXPECT_EQ(record("F.MCAP").err.find(".pcapng"), std::string::npos);
    const std::string file = folder.write("flight.pcapng", flight());
    EXPECT_EQ(anoctl({"convert", file, folder / "A.MCAP", "--message-encoding", "json"}).exit, 0);
    EXPECT_TRUE(file_text(folder / "A.MCAP").starts_with(anogate::mcap::magic));
    EXPECT_EQ(anoctl({"convert", file, folder / "A.CSV", "--id", "euler"}).exit, 0);
}

TEST(Record, explains_which_option_consumed_the_file_name) {
    const auto said = anoctl({"record", "--id", "euler", "power", "e1.mcap", "--seconds", "2"});
    EXPECT_EQ(said.exit, 2);
    EXPECT_NE(said.err.find("missing FILE; 'e1.mcap' was read as a value of --id; place it before --id"), std::string::npos)
        << said.err;
    EXPECT_EQ(anoctl({"record", "--id", "euler", "power", "--seconds", "2"}).err.find("was taken"), std::string::npos);
}

TEST(WithoutAGateway, each_command_explains_how_to_continue) {
    const support::TempDir folder;
    const std::string none = folder / "none.sock", starts = "; to start one: anogated LINK...";
    const auto said = [&](std::vector<std::string> words) {
        words.insert(words.end(), {"--control", none});
        return anoctl(words).err;
    };
    for (const std::string& err : {said({"record", folder / "a.mcap"}), said({"recordings"})})
        EXPECT_TRUE(err.ends_with(starts + "\n")) << err;
    const std::string plot = said({"plot-udp", "127.0.0.1:9870"}), monitor = said({"monitor"}), list = said({"param", "list"});
    EXPECT_TRUE(plot.ends_with(starts + "; to work without a gateway: anoctl plot-udp IP:PORT LINK\n")) << plot;
    EXPECT_TRUE(monitor.ends_with(starts + "; to work without a gateway: anoctl monitor LINK\n")) << monitor;
    EXPECT_TRUE(list.ends_with(starts + "; to work without a gateway, add --link LINK\n")) << list;
}

TEST(Info, reports_that_an_mcap_file_of_another_program_contains_no_frames) {
    const support::TempDir folder;
    std::string file{anogate::mcap::magic};
    anogate::mcap::append_channel(file, {1, 0, "/camera", "cdr"});
    anogate::mcap::append_message(file, {1, 0, 1, 1, "abc"});
    const auto said = anoctl({"info", folder.write("other.mcap", file)});
    EXPECT_EQ(said.exit, 1);
    EXPECT_NE(said.err.find("this MCAP file is not a recording of a gateway: it has no channel /anogate/frames"),
              std::string::npos)
        << said.err;
}

}    // namespace
}    // namespace recordings_tests
