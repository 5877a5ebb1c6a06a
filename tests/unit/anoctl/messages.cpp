#include <gtest/gtest.h>
#include <ano/messages.hpp>
#include <nlohmann/json.hpp>

#include <sstream>
#include <string>
#include <vector>

#include <support/anoctl.hpp>
#include <support/temp_dir.hpp>

namespace messages_tests {
namespace {

using support::anoctl;

TEST(Messages, as_json_are_one_object_per_layout) {
    std::istringstream lines{anoctl({"messages", "--json"}).out};
    std::size_t rows = 0;
    for (std::string line; std::getline(lines, line); ++rows) {
        const auto row = nlohmann::json::parse(line);
        const ano::Message& expected = ano::messages[rows];
        EXPECT_EQ(row["id"], expected.id);
        EXPECT_EQ(row["name"], expected.name);
        EXPECT_EQ(row["fields"].size(), expected.fields().size());
    }
    EXPECT_EQ(rows, ano::messages.size());
    const auto target = nlohmann::json::parse(anoctl({"messages", "--json", "target_attitude"}).out);
    EXPECT_EQ(target["class"], "telemetry");
    EXPECT_EQ(target["fields"][0]["scale"], 0.01);
    EXPECT_EQ(target["fields"][0]["unit"], "°");
}

TEST(Messages, as_json_have_the_layouts_of_a_configuration) {
    const support::TempDir dir;
    const std::string config = dir.write("my.json", R"({"flexible": [
        {"id": "0xF1", "fields": [{"name": "water_temp", "type": "i16", "scale": 0.1, "unit": "°C"}]},
        {"id": "0xF2", "source": 30, "fields": [{"name": "n", "type": "u8"}]}]})");
    std::istringstream lines{anoctl({"messages", "--json", "--config", config}).out};
    std::vector<nlohmann::json> of_f1, of_f2;
    for (std::string line; std::getline(lines, line);) {
        const auto row = nlohmann::json::parse(line);
        if (row["id"] == 0xF1) of_f1.push_back(row);
        if (row["id"] == 0xF2) of_f2.push_back(row);
    }
    ASSERT_EQ(of_f1.size(), 1u);
    EXPECT_EQ(of_f1[0]["size"], 2);
    EXPECT_EQ(of_f1[0]["fields"][0]["name"], "water_temp");
    EXPECT_EQ(of_f1[0]["fields"][0]["scale"], 0.1);
    EXPECT_FALSE(of_f1[0].contains("source"));
    ASSERT_EQ(of_f2.size(), 2u) << "frames of others have none";
    EXPECT_EQ(of_f2[0]["source"], 30);
    EXPECT_EQ(of_f2[1]["fields"].size(), 0u);
}

TEST(Messages, as_text_are_one_line_per_layout) {
    const auto all = anoctl({"messages"}).out;
    EXPECT_EQ(static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n')), ano::messages.size());
}

TEST(Messages, by_name_show_types_units_ranges_and_values) {
    EXPECT_EQ(anoctl({"messages", "mode"}).out,
              "0x06 mode telemetry: Flight mode, and the command being executed\n"
              "    field  type  range     values\n"
              "    mode   u8    0 to 255\n"
              "    sflag  u8    0 to 255  0 locked, 1 unlocked, 2 airborne\n"
              "    cid    u8    0 to 255\n"
              "    cmd0   u8    0 to 255\n"
              "    cmd1   u8    0 to 255\n");
    const auto power = anoctl({"messages", "0x0D"}).out;
    EXPECT_NE(power.find("0x0D power telemetry: Supply voltage and current\n"), std::string::npos) << power;
    EXPECT_NE(power.find("of the battery and of the controller's supply (layout field, at exactly 10 bytes)\n"),
              std::string::npos);
    EXPECT_NE(power.find("    voltage2  u16   V     0 to 655.35  controller supply\n"), std::string::npos);
    const auto euler = anoctl({"messages", "euler"}).out;
    EXPECT_NE(euler.find("    rol         i16   °     -327.68 to 327.67\n"), std::string::npos) << euler;
    const auto scan = anoctl({"messages", "ranging"}).out;
    EXPECT_NE(scan.find("      angle  u16"), std::string::npos) << scan;    // of each point
    EXPECT_NE(scan.find("0 to 360"), std::string::npos);
    EXPECT_NE(scan.find("    type     u8                      100         100 scan\n"), std::string::npos);
    EXPECT_NE(anoctl({"messages", "general_velocity"}).out.find("null: no data"), std::string::npos);
    EXPECT_NE(anoctl({"messages", "parameter_value"}).out.find("written as f32:1.5"), std::string::npos);
    EXPECT_NE(anoctl({"messages", "parameter_info"}).out.find("0 to 10"), std::string::npos);
    EXPECT_NE(anoctl({"messages", "flexible1"}).out.find("as configured"), std::string::npos);
}

TEST(Messages, report_bad_input) {
    EXPECT_EQ(anoctl({"messages", "eulr"}).err, "anoctl: there is no message 'eulr' (did you mean 'euler'?)\n");
    EXPECT_EQ(anoctl({"messages", "eulr"}).exit, 2);
    EXPECT_EQ(anoctl({"messages", "0x77"}).exit, 2);
    EXPECT_EQ(anoctl({"messages", "heartbeat"}).err, "anoctl: there is no message 'heartbeat'; to list them: anoctl messages\n");
    EXPECT_EQ(anoctl({"messages", "--json", "--lua"}).exit, 2);
}

TEST(Anoctl, names_an_unknown_command) {
    const auto ran = anoctl({"mesages"});
    EXPECT_EQ(ran.exit, 2);
    EXPECT_EQ(ran.err,
              "anoctl: unknown command 'mesages' (did you mean 'messages'?); commands: decode, encode, messages, monitor, "
              "ports, setup, status, links, routes, metrics, reload, flexible, send, devices, param, command, waypoint, flash, "
              "calibrate, "
              "log, alarms, image, "
              "terminal, top, record, recordings, info, convert, replay, plot-udp, web, certificate\n");
    EXPECT_EQ(anoctl({"help"}).out, anoctl({"--help"}).out);
    EXPECT_EQ(anoctl({"help", "decode"}).out, anoctl({"decode", "--help"}).out);
    EXPECT_EQ(anoctl({}).exit, 2);
    EXPECT_EQ(anoctl({}).err,
              "anoctl: missing command; commands: decode, encode, messages, monitor, "
              "ports, setup, status, links, routes, metrics, reload, flexible, send, devices, param, command, waypoint, flash, "
              "calibrate, "
              "log, alarms, "
              "image, terminal, top, record, recordings, info, convert, replay, plot-udp, web, certificate; for help: anoctl "
              "COMMAND --help\n");
}

}    // namespace
}    // namespace messages_tests
