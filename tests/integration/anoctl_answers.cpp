// Confirmations of `anoctl` before it overwrites, and its messages when a device, a file or the gateway fails.
#include <support/asked_devices.hpp>
#include <support/bytes.hpp>
#include <support/fake_loader.hpp>
#include <support/files.hpp>
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <http/client/client.hpp>
#include <sys/local_client.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace anoctl_answers_tests {
namespace {

using namespace support;
using nlohmann::json;

using AnoctlAnswers = DeviceGateway;
using AnoctlOtherDevice = AnsweringDevice;

json points(int number) {
    json all = json::array();
    for (int i = 0; i < number; ++i) all.push_back({{"lng", 116.4}, {"lat", 39.9 + i * 0.001}, {"alt", 500}, {"spd", 300}});
    return {{"waypoints", all}};
}

TEST_F(AnoctlAnswers, writing_fewer_waypoints_than_stored_needs_confirmation_and_is_reported) {
    const std::string many = dir.write("many.json", points(4).dump()), one = dir.write("one.json", points(1).dump());
    const Ran refused = anoctl({"waypoint", "put", many});
    EXPECT_EQ(refused.exit, 2) << "nobody can be asked";
    EXPECT_TRUE(contains(refused.output, "--yes")) << refused.output;
    ASSERT_EQ(anoctl({"waypoint", "put", many, "--yes"}).exit, 0);
    const Ran put = anoctl({"waypoint", "put", one, "--yes"});
    EXPECT_EQ(put.exit, 0) << put.output;
    EXPECT_TRUE(contains(put.output, "0 will be overwritten, and 1 to 3 remain")) << put.output;
    EXPECT_TRUE(contains(put.output, "until it has 4")) << put.output;
    EXPECT_TRUE(contains(put.output, ": 1 waypoint written; 0xDC has 4, the last 3 are its old ones\n")) << put.output;
    EXPECT_EQ(json::parse(anoctl({"waypoint", "get"}).output).at("waypoints").size(), 4u);
    const Ran still = anoctl(
        {"waypoint", "put", dir.write("still.json", R"({"waypoints": [{"lng": 1, "lat": 2, "alt": 3}]})"), "--yes"});
    EXPECT_EQ(still.exit, 0) << still.output;
    EXPECT_TRUE(contains(still.output, "The file has no speed for 0 (counted from 0); 0 cm/s is written.\n")) << still.output;
    const Ran wrong = anoctl({"waypoint", "put", dir.write("wrong.json", "{\"way\": 1}"), "--yes"});
    EXPECT_EQ(wrong.exit, 2);
    EXPECT_TRUE(contains(wrong.output, "wrong.json: not a waypoint file")) << wrong.output;
}

TEST_F(AnoctlOtherDevice, that_stops_in_the_middle_of_a_write_is_reported_with_its_number_of_waypoints) {
    hear_of_another();
    fake.instead = [this](ano::FrameView frame) {
        return fake.waypoints.size() >= 2 && frame.id() == 0x61 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const Ran put = asked({"waypoint", "put", dir.write("way.json", points(4).dump()), "--yes"});
    EXPECT_EQ(put.exit, 1);
    EXPECT_TRUE(contains(put.output, "write of waypoint 2")) << put.output;
    EXPECT_TRUE(contains(put.output, ": 2 of 4 waypoints written; the device has a mixture of new and old waypoints"))
        << put.output;
}

TEST_F(AnoctlOtherDevice, that_is_online_but_does_not_answer_is_not_reported_as_silent) {
    hear_of_another();
    fake.instead = [](ano::FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (frame.id() != 0x60 && frame.id() != 0xE1) return std::nullopt;
        return std::vector<Bytes>{frame_of_another()};
    };
    fake.make_parameters(1);
    const Ran commands = asked({"command", "list"});
    EXPECT_EQ(commands.exit, 0) << commands.output;
    EXPECT_EQ(commands.output, "0xDD has no commands\n");
    const Ran way = asked({"waypoint", "get"});
    EXPECT_EQ(way.exit, 1);
    EXPECT_TRUE(contains(way.output, "fake (0xDD) is online, but did not answer the request for its number of waypoints, sent "))
        << way.output;
    EXPECT_TRUE(contains(way.output, " times; it probably stores none\n")) << way.output;
    const Ran set = asked({"param", "set", "PAR_0", "7"});
    EXPECT_EQ(set.exit, 1);
    EXPECT_TRUE(contains(set.output, "fake (0xDD) is online, but did not acknowledge: write of PAR_0, sent ")) << set.output;
    EXPECT_TRUE(contains(set.output, " times; it probably does not accept this value")) << set.output;
}

TEST_F(AnoctlOtherDevice, that_was_never_seen_is_asked_before_it_is_reported_as_unknown) {
    fake.make_parameters(3);
    const Ran get = asked({"param", "get", "PAR_0"});
    EXPECT_EQ(get.exit, 0) << get.output;
    EXPECT_EQ(get.output, "PAR_0=0\n");
    const Ran nobody = anoctl({"param", "get", "PAR_0", "--device", "0x21"});
    EXPECT_EQ(nobody.exit, 1);
    EXPECT_EQ(nobody.output, "anoctl: 0x21 was not seen and does not answer\n");
}

TEST_F(AnoctlAnswers, nothing_is_written_when_one_of_several_is_wrong) {
    ASSERT_EQ(anoctl({"param", "set", "SIM_TURN", "1"}).exit, 0);
    const Ran name = anoctl({"param", "set", "SIM_TURN=2", "SIM_HEIGT=3"});
    EXPECT_EQ(name.exit, 1);
    EXPECT_TRUE(contains(name.output, "no parameter is named 'SIM_HEIGT' (did you mean 'SIM_HEIGHT'?)")) << name.output;
    const Ran range = anoctl({"param", "set", "SIM_TURN=2", "SIM_HEIGHT=99999999999"});
    EXPECT_EQ(range.exit, 1);
    EXPECT_TRUE(contains(range.output, "SIM_HEIGHT: '99999999999' is out of range, ")) << range.output;
    EXPECT_TRUE(contains(range.output, " to ")) << range.output;
    EXPECT_EQ(anoctl({"param", "set", "SIM_TURN=2", "SIM_TURN=3"}).exit, 1);
    EXPECT_EQ(anoctl({"param", "get", "SIM_TURN"}).output, "SIM_TURN=1\n");
    EXPECT_TRUE(contains(anoctl({"param", "get", "SIM_TRN"}).output, "(did you mean 'SIM_TURN'?)"));
}

TEST_F(AnoctlOtherDevice, is_listed_with_its_name_and_found_by_it_in_upper_or_lower_case) {
    hear_of_another();
    Process several{ANOCTL, {"param", "get", "SIM_TURN", "--control", socket}};
    EXPECT_EQ(until_ended(several), 2);
    EXPECT_TRUE(contains(several.output(), "choose one with --device: 0xDC SimFC, 0xDD fake\n")) << several.output();
    const Ran named = anoctl({"param", "get", "SIM_RANGE_OFFSET", "--device", "simfc"});
    EXPECT_EQ(named.exit, 0) << named.output;
    fake.name = "SIMFC";    // now two have this name, and neither matches the typed one exactly
    Process scan{ANOCTL, {"devices", "--scan", "--control", socket}};
    EXPECT_EQ(until_ended(scan), 0);
    EXPECT_EQ(anoctl({"param", "get", "SIM_RANGE_OFFSET", "--device", "simfc"}).exit, 2);
    EXPECT_EQ(anoctl({"param", "get", "SIM_RANGE_OFFSET", "--device", "SimFC"}).exit, 0);
}

TEST(AnoctlPinnedDevice, is_listed_with_its_link) {
    const TempDir dir;
    Daemon gateway{ANOGATED, dir / "control", {"sim:fc,name=vehicle", "--route", "0xDC=vehicle"}};
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    std::string listed;
    EXPECT_TRUE(wait_until([&] {
        Process scan{ANOCTL, {"devices", "--scan", "--json", "--control", dir / "control"}};
        scan.wait();
        listed = scan.output();
        return listed.find(R"("link":"vehicle")") != std::string::npos;
    })) << listed;
}

TEST_F(AnoctlOtherDevice, is_selected_by_its_name_for_the_log) {
    hear_of_another();
    Process scan{ANOCTL, {"devices", "--scan", "--control", socket}};
    ASSERT_EQ(until_ended(scan), 0);
    Process log{ANOCTL, {"log", "--device", "FAKE", "--control", socket}};
    EXPECT_TRUE(wait_until([&] {
        peer.send(gateway.port("peer"), frame(0xDE, 0xFE, 0xA0, {0, 'y'}));
        peer.send(gateway.port("peer"), frame(0xDD, 0xFE, 0xA0, {0, 'x'}));
        return contains(log.output(), " 0xDD x\n");
    })) << log.output();
    EXPECT_FALSE(contains(log.output(), "0xDE")) << log.output();
}

TEST_F(AnoctlAnswers, the_available_devices_are_listed_when_the_named_one_is_unknown) {
    const Ran nobody = anoctl({"log", "--device", "Nobody"});
    EXPECT_EQ(nobody.exit, 2);
    EXPECT_EQ(nobody.output, "anoctl: --device: no device is named 'Nobody'; devices: 0xDC SimFC\n")
        << "it was asked for its name";
    Process own{ANOCTL, {"image", dir / "pictures", "--device", "Nobody", "--link", "sim:fc"}};
    EXPECT_EQ(own.wait(), 2);
    EXPECT_TRUE(contains(own.output(), "'Nobody' is not an address (0xDC); with --link, give addresses")) << own.output();
}

TEST_F(AnoctlAnswers, values_that_a_calibration_stored_are_imported_and_their_file_is_named) {
    const std::string file = dir.write(
        "calibration-0xDC-accelerometer.json",
        R"({"device": {"address": "0xDC", "name": "SimFC", "dev_id": 220}, "parameters": {"CAL_AOFF_X": 2.5}})");
    const Ran import = anoctl({"param", "import", file, "--yes"});
    EXPECT_EQ(import.exit, 0) << import.output;
    EXPECT_TRUE(contains(import.output, "1 parameter written")) << import.output;
    EXPECT_TRUE(contains(import.output, "then remove " + file)) << import.output;
    EXPECT_FALSE(contains(import.output, "the file is for")) << import.output;
    EXPECT_EQ(anoctl({"param", "get", "CAL_AOFF_X"}).output, "CAL_AOFF_X=2.5\n");
}

TEST_F(AnoctlAnswers, parameters_that_the_device_refuses_are_not_counted_as_written) {
    const std::string file = dir.write("refused.json", R"({"SIM_SERIAL": 1})");
    const Ran import = anoctl({"param", "import", file, "--yes"});
    EXPECT_EQ(import.exit, 1);
    EXPECT_TRUE(contains(import.output, "SIM_SERIAL: 687194767361 -> 1, failed: 0xDC is online, ")) << import.output;
    EXPECT_TRUE(contains(import.output, "no parameter was written\n")) << import.output;
    EXPECT_TRUE(contains(import.output, "anoctl: 1 parameter was not written\n")) << import.output;
}

TEST_F(AnoctlAnswers, parameters_after_a_refused_one_are_still_imported) {
    const std::string file = dir.write("two.json", R"({"SIM_SERIAL": 1, "SIM_TURN": 44})");
    const Ran undone = anoctl({"param", "import", file, "--yes", "--rollback"});
    EXPECT_EQ(undone.exit, 1);
    EXPECT_TRUE(contains(undone.output, "SIM_TURN: ")) << undone.output;
    EXPECT_TRUE(contains(undone.output, " -> 44, not attempted\n")) << undone.output;
    EXPECT_NE(anoctl({"param", "get", "SIM_TURN"}).output, "SIM_TURN=44\n");
    const Ran import = anoctl({"param", "import", file, "--yes"});
    EXPECT_EQ(import.exit, 1);
    EXPECT_TRUE(contains(import.output, "1 parameter written; to save permanently: anoctl param save\nSIM_SERIAL: "))
        << "what was refused is at the end: " << import.output;
    EXPECT_EQ(anoctl({"param", "get", "SIM_TURN"}).output, "SIM_TURN=44\n");
}

TEST_F(AnoctlAnswers, all_values_that_do_not_fit_a_device_are_reported_before_anything_is_written) {
    ASSERT_EQ(anoctl({"param", "set", "SIM_HEIGHT", "321"}).exit, 0);
    const std::string file = dir.write(
        "other.json", R"({"name": "Other", "parameters": {"NEWER": 1, "SIM_HEIGHT": 300, "SIM_TURN": 300, "SIM_NOTE": ")" +
                          std::string(200, 'x') + R"("}})");
    for (const char* action : {"import", "diff"}) {
        const Ran ran = anoctl({"param", action, file, "--yes"});
        EXPECT_EQ(ran.exit, *action == 'd' ? 2 : 1);
        EXPECT_TRUE(contains(ran.output, "the file is for Other")) << ran.output;
        EXPECT_TRUE(contains(ran.output, "unknown parameter NEWER\n")) << ran.output;
        EXPECT_TRUE(contains(ran.output, "SIM_TURN: 300 is out of range, i8 is -128 to 127\n")) << ran.output;
        EXPECT_EQ(contains(ran.output, " bytes that the device has: --longer allows a longer one"), *action == 'i') << ran.output;
    }
    EXPECT_TRUE(contains(
        anoctl({"param", "import", file, "--yes"}).output,
        "anoctl: 3 parameters of " + file + " do not fit SimFC (0xDC): nothing was written. To write the others, remove them"));
    EXPECT_EQ(anoctl({"param", "get", "SIM_HEIGHT"}).output, "SIM_HEIGHT=321\n");
}

TEST_F(AnoctlAnswers, a_file_of_another_device_causes_a_warning_even_without_confirmation) {
    const std::string file = dir.write("other.json", R"({"name": "Other", "dev_id": 1, "parameters": {"SIM_HEIGHT": 444}})");
    const Ran import = anoctl({"param", "import", file, "--yes"});
    EXPECT_EQ(import.exit, 0) << import.output;
    EXPECT_TRUE(contains(import.output, "anoctl: the file is for Other, device type 1, but the device is SimFC"))
        << import.output;
    EXPECT_EQ(anoctl({"param", "get", "SIM_HEIGHT"}).output, "SIM_HEIGHT=444\n");
}

TEST_F(AnoctlAnswers, files_are_replaced_only_after_confirmation) {
    const std::string old = dir.write("old.json", "old"), plan = dir.write("old.plan", "old");
    const std::vector<std::vector<std::string>> commands{{"param", "export", old}, {"waypoint", "get", plan}};
    for (std::vector<std::string> command : commands) {
        const std::string file = command.back();
        const Ran refused = anoctl(command);
        EXPECT_EQ(refused.exit, 2) << refused.output;
        EXPECT_TRUE(contains(refused.output, file + " already exists")) << refused.output;
        EXPECT_EQ(file_text(file), "old");
        command.emplace_back("--yes");
        EXPECT_EQ(anoctl(command).exit, 0);
        EXPECT_NE(file_text(file), "old");
    }
    const std::string link = dir / "link.json";
    std::filesystem::create_symlink(dir.write("behind.json", "old"), link);
    EXPECT_EQ(anoctl({"param", "export", link, "--yes"}).exit, 0);
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_NE(file_text(dir / "behind.json"), "old");
    const Ran csv = anoctl({"param", "export", dir / "new.csv"}), kml = anoctl({"waypoint", "get", dir / "new.kml"});
    EXPECT_EQ(csv.exit, 2);
    EXPECT_TRUE(contains(csv.output, "'.csv' is not a supported parameter file format; use .json")) << csv.output;
    EXPECT_EQ(kml.exit, 2);
    EXPECT_TRUE(contains(kml.output, "'.kml' is not a supported waypoint format; use .json, .geojson or .plan")) << kml.output;
}

TEST_F(AnoctlAnswers, differences_are_printed_as_json_with_the_exit_status_of_diff) {
    const std::string file = dir / "backup.json";
    ASSERT_EQ(anoctl({"param", "export", file}).exit, 0);
    EXPECT_EQ(anoctl({"param", "diff", file}).exit, 0);
    EXPECT_EQ(anoctl({"param", "diff", file, "--json"}).output, "");
    ASSERT_EQ(anoctl({"param", "set", "SIM_TURN", "17"}).exit, 0);
    const Ran differs = anoctl({"param", "diff", file, "--json"});
    EXPECT_EQ(differs.exit, 1);
    const auto rows = lines_of(differs.output);
    ASSERT_EQ(rows.size(), 1u) << differs.output;
    EXPECT_EQ(rows[0].at("name"), "SIM_TURN");
    const Ran all = anoctl({"param", "diff", file, "--json", "--all"});
    EXPECT_EQ(all.exit, 1);
    EXPECT_GT(lines_of(all.output).size(), 20u);
    EXPECT_EQ(anoctl({"param", "diff", file, "--device", "Nobody"}).exit, 2) << "that could not be found out";
}

TEST_F(AnoctlOtherDevice, with_inf_and_nan_values_is_listed_exported_and_compared) {
    hear_of_another();
    fake.parameters = {{8, "A", "", {0, 0, 0xC0, 0x7F}}, {8, "B", "", {0, 0, 0x80, 0xFF}}, {8, "C", "", {0, 0, 0x80, 0x3F}}};
    const Ran get = asked({"param", "get", "--all"});
    EXPECT_EQ(get.output, "A=nan\nB=-inf\nC=1\n");
    EXPECT_TRUE(contains(asked({"param", "list"}).output, "f32   nan\n"));
    const Ran exported = asked({"param", "export", dir / "f.json"});
    EXPECT_TRUE(contains(exported.output, "inf and nan are stored as null, which import skips: A, B\n")) << exported.output;
    EXPECT_TRUE(json::parse(file_text(dir / "f.json")).at("parameters").at("A").is_null());
    const Ran diff = asked({"param", "diff", dir / "f.json"});
    EXPECT_EQ(diff.exit, 0) << diff.output;
    EXPECT_TRUE(contains(diff.output, "no value in the file: A, B\n")) << diff.output;
}

TEST_F(AnoctlOtherDevice, with_control_characters_in_names_has_a_backup_without_them_that_fits_it) {
    hear_of_another();
    const Bytes value{0, 0, 0x80, 0x3F};
    fake.parameters = {{8, "P\xE2\x80\xAEX", "", value}, {8, "P\xE2\x80\xADX", "", value}, {8, "a\x01", "", value},
                       {8, "SAME", "", value},           {8, "SAME", "", value},           {8, "\xE5\x90\x8D", "", value}};
    const std::string file = dir / "f.json";
    ASSERT_EQ(asked({"param", "export", file}).exit, 0);
    EXPECT_TRUE(contains(file_text(file), R"("P\u202eX": 1.0)")) << file_text(file);
    EXPECT_TRUE(contains(file_text(file), "\"\xE5\x90\x8D\": 1.0")) << file_text(file);
    EXPECT_FALSE(contains(file_text(file), "\xE2\x80")) << file_text(file);
    const Ran diff = asked({"param", "diff", file});
    EXPECT_EQ(diff.exit, 0) << diff.output;
    const Ran import = asked({"param", "import", file, "--yes"});
    EXPECT_EQ(import.exit, 0) << import.output;
}

TEST_F(AnoctlAnswers, earlier_log_lines_are_shown_without_terminal_control_characters) {
    peer.send(gateway.port("peer"), frame(0x35, 0xFF, 0xA0, {1, 'm', 0xE2, 0x80, 0xAE, '1', '\r', '\n'}));
    peer.send(gateway.port("peer"), frame(0x36, 0xFF, 0xA1, {0, 0, 0xC0, 0x3F, 'v'}));
    Ran shown;
    ASSERT_TRUE(wait_until([&] {
        return contains((shown = anoctl({"log", "--since", "10m", "--no-follow"})).output, " 0x36 1.5 v\n");
    })) << shown.output;
    EXPECT_EQ(shown.exit, 0);
    EXPECT_TRUE(contains(shown.output, " 0x35 m")) << shown.output;
    const std::string printed = anoctl({"log", "--since", "10m", "--no-follow", "--json", "--device", "0x35"}).output;
    const auto lines = lines_of(printed);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].at("from"), "0x35");
    EXPECT_EQ(lines[0].at("fields").at("color"), 1);
    EXPECT_TRUE(contains(lines[0].at("fields").at("str").get<std::string>(), "\xE2\x80\xAE"));
    EXPECT_FALSE(contains(printed, "\xE2\x80\xAE")) << printed;
    EXPECT_TRUE(anoctl({"log", "--since", "0s", "--no-follow"}).output.empty());
    EXPECT_EQ(anoctl({"log", "--since", "soon"}).exit, 2);
    EXPECT_EQ(anoctl({"log", "--no-follow"}).exit, 2);
}

TEST_F(AnoctlAnswers, alarms_are_shown_once_or_followed_as_they_change) {
    const auto send_voltage = [&](std::uint8_t low, std::uint8_t high) {
        peer.send(gateway.port("peer"), frame(0x35, 0xFF, 0x0D, {low, high, 0, 0}));
    };
    const auto shows = [&](const std::string& words) {
        Ran shown;
        EXPECT_TRUE(wait_until([&] { return contains((shown = anoctl({"alarms"})).output, words); })) << shown.output;
    };
    hear_of_another();
    anogate::http::Request limits;
    limits.method = "PUT";
    limits.target = "/devices/0x35/limits";
    limits.headers.push_back({"Content-Type", "application/json"});
    limits.body = R"({"limits": [{"field": "power.voltage", "side": "below", "amber": 3.6, "red": 3.4, "cells": 4}]})";
    ASSERT_EQ(anogate::http::ask(socket, limits).answer.status, 200u);
    EXPECT_EQ(anoctl({"alarms"}).output, "no value exceeds its limits\n");
    Process follows{ANOCTL, {"alarms", "--follow", "--control", socket}};
    Process others{ANOCTL, {"alarms", "--follow", "--json", "--device", "0x36", "--control", socket}};
    EXPECT_TRUE(others.until_says("{\"alarms\":[]}\n")) << others.output();
    send_voltage(0x8C, 0x05);    // 14.2 V
    shows("0x35    amber  power.voltage  3.55 V per cell  below 3.6 V");
    EXPECT_TRUE(follows.until_says(" 0x35 amber power.voltage 3.55 V per cell, below 3.6 V\n")) << follows.output();
    send_voltage(0x28, 0x05);    // 13.2 V
    EXPECT_TRUE(follows.until_says(" 0x35 red power.voltage 3.3 V per cell, below 3.4 V\n")) << follows.output();
    const auto lines = lines_of(anoctl({"alarms", "--json", "--device", "0x35"}).output);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].at("level"), "red");
    EXPECT_EQ(anoctl({"alarms", "--device", "0x36"}).output, "no value exceeds its limits\n");
    send_voltage(0xF0, 0x05);    // 15.2 V
    EXPECT_TRUE(follows.until_says(" 0x35 ended power.voltage\n")) << follows.output();
    shows("no value exceeds its limits");
    EXPECT_FALSE(contains(others.output(), "power.voltage")) << others.output();
    follows.signal(SIGINT);
    EXPECT_EQ(follows.wait(), 0);
    gateway.signal(SIGTERM);
    EXPECT_TRUE(others.until_says("anoctl: ")) << others.output();
    EXPECT_EQ(others.wait(), 1);
}

TEST_F(AnoctlAnswers, the_job_that_uses_a_device_is_reported_with_the_command_that_cancels_it) {
    hear_of_another();
    Process first{ANOCTL, {"param", "save", "--device", "0xDD", "--control", socket}};
    ASSERT_TRUE(wait_until([&] { return contains(anoctl({"devices", "--jobs"}).output, "running"); })) << first.output();
    const Ran second = anoctl({"param", "save", "--device", "0xDD"});
    EXPECT_EQ(second.exit, 1);
    const std::string who = "anoctl of " + std::string{::getpwuid(::geteuid())->pw_name} + ", process " +
                            std::to_string(first.pid());
    EXPECT_TRUE(contains(second.output, who + "); anoctl devices --jobs --control " + socket + " shows its progress"))
        << second.output;
    const auto jobs = lines_of(anoctl({"devices", "--jobs", "--json"}).output);
    ASSERT_FALSE(jobs.empty());
    const std::string number = jobs.back().at("id").dump();
    EXPECT_TRUE(contains(second.output, "anoctl devices --cancel " + number + " --control " + socket + " cancels it"))
        << second.output;
    const Ran cancel = anoctl({"devices", "--cancel", number});
    EXPECT_EQ(cancel.exit, 0);
    EXPECT_TRUE(contains(cancel.output,
                         "job " + number + " (param save/reset of " + who + "): cancelled; save may have been carried out\n"))
        << cancel.output;
    EXPECT_EQ(first.wait(), 1);
    EXPECT_TRUE(contains(first.output(), "anoctl: cancelled by another client")) << first.output();
    EXPECT_TRUE(contains(anoctl({"devices", "--cancel", number}).output, "already ended: cancelled"));
    EXPECT_EQ(anoctl({"devices", "--cancel", "999"}).exit, 1);
    EXPECT_EQ(anoctl({"devices", "--cancel", "x"}).exit, 2);
}

TEST_F(AnoctlAnswers, a_job_is_described_by_its_user_and_program_despite_the_name_that_a_program_states) {
    const std::string asks =
        "GET /devices/0x33/parameters?client=logger HTTP/1.1\r\nHost: x\r\nUser-Agent: anoctl of root\r\n\r\n";
    const anogate::UniqueFd client{connect_unix(socket)};
    ASSERT_EQ(::send(client.get(), asks.data(), asks.size(), 0), static_cast<ssize_t>(asks.size()));
    const std::string by = "logger (" + anogate::local_client(::geteuid(), ::getpid()) + ")";
    const auto client_of_job = [&] { return anoctl({"devices", "--jobs", "--json"}).output; };
    EXPECT_TRUE(wait_until([&] { return contains(client_of_job(), "\"client\":\"" + by + "\""); })) << client_of_job();
}

TEST_F(AnoctlOtherDevice, an_interrupted_write_is_reported_as_possibly_carried_out) {
    hear_of_another();
    fake.make_parameters(1);
    bool is_asked_to_write = false;
    fake.instead = [&](ano::FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (frame.id() != 0xE1) return std::nullopt;
        is_asked_to_write = true;
        return std::vector<Bytes>{};
    };
    std::string said;
    for (int tries = 0; tries < 5 && !contains(said, "cancelled"); ++tries) {    // it may give up before the signal arrives
        is_asked_to_write = false;
        Process set{ANOCTL, {"param", "set", "PAR_0", "7", "--device", "0xDD", "--control", socket}};
        bool is_interrupted = false;
        const int exit = until_ended(set, [&] {
            if (is_asked_to_write && !std::exchange(is_interrupted, true)) set.signal(SIGINT);
        });
        said = set.output();
        EXPECT_EQ(exit, contains(said, "cancelled") ? 130 : 1) << said;
    }
    EXPECT_TRUE(contains(said, "anoctl: cancelled: PAR_0 may have been written\n")) << said;
}

TEST_F(AnoctlOtherDevice, an_interrupted_import_reports_which_values_stay_and_which_were_undone) {
    hear_of_another();
    fake.make_parameters(3);
    const auto old = fake.parameters;
    bool is_at_the_last = false;
    fake.instead = [&](ano::FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (frame.id() != 0xE1 || frame.data()[0] != 2) return std::nullopt;
        is_at_the_last = true;
        return std::vector<Bytes>{};
    };
    const std::string file = dir.write("three.json", R"({"PAR_0": 77, "PAR_1": -3, "PAR_2": 5})");
    for (const bool rollback : {false, true}) {
        std::string said;
        for (int tries = 0; tries < 5 && !contains(said, "cancelled"); ++tries) {    // it may give up before the signal arrives
            fake.parameters = old;
            is_at_the_last = false;
            Process import{ANOCTL,
                           {"param", "import", file, "--yes", "--device", "0xDD", "--control", socket,
                            rollback ? "--rollback" : "--longer"}};
            bool is_interrupted = false;
            (void)until_ended(import, [&] {
                if (is_at_the_last && !std::exchange(is_interrupted, true)) import.signal(SIGINT);
            });
            said = import.output();
        }
        const std::string end = rollback ? "anoctl: cancelled after 2 of 3: 3 parameters written and restored\n"
                                         : "anoctl: cancelled after 2 of 3: 2 parameters written; unless saved, the changes are "
                                           "lost when the device restarts; PAR_2 may have been written\n";
        EXPECT_TRUE(contains(said, end)) << said;
        EXPECT_EQ(fake.parameters[0].value == old[0].value, rollback);
    }
}

TEST_F(AnoctlOtherDevice, an_upgrade_is_cancelled_only_after_confirmation) {
    hear_of_another();
    FakeLoader loader;
    fake.instead = [&](ano::FrameView frame) { return loader.take(fake, frame); };
    Process flash{ANOCTL,
                  {"flash", dir.write("new.bin", std::string(60'000, '\x01')), "--device", "0xDD", "--yes", "--control", socket}};
    std::string number;
    const auto cancel = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"devices", "--cancel", number, "--control", socket};
        words.insert(words.end(), more.begin(), more.end());
        Process process{ANOCTL, std::move(words)};
        const int exit = until_ended(process);
        return Ran{exit, process.output()};
    };
    EXPECT_TRUE(wait_until([&] {
        answer();
        return loader.frames > 5;
    }));
    number = lines_of(anoctl({"devices", "--jobs", "--json"}).output).back().at("id").dump();
    const Ran refused = cancel({});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_TRUE(contains(refused.output, "cancelling a firmware update: confirmation required, but stdin is not a terminal"))
        << refused.output;
    EXPECT_TRUE(flash.is_running()) << flash.output();
    const Ran cancelled = cancel({"--yes"});
    EXPECT_EQ(cancelled.exit, 0) << cancelled.output;
    EXPECT_FALSE(contains(cancelled.output, "cancelled; cancelled")) << cancelled.output;
    EXPECT_EQ(until_ended(flash), 1);
}

TEST_F(AnoctlOtherDevice, stays_in_its_loader_when_the_gateway_stops_during_a_flash) {
    hear_of_another();
    FakeLoader loader;
    fake.instead = [&](ano::FrameView frame) { return loader.take(fake, frame); };
    Process flash{ANOCTL,
                  {"flash", dir.write("new.bin", std::string(60'000, '\x01')), "--device", "0xDD", "--yes", "--control", socket}};
    bool is_interrupted = false;
    EXPECT_EQ(until_ended(flash,
                          [&] {
                              if (loader.frames > 100 && !std::exchange(is_interrupted, true)) gateway.signal(SIGTERM);
                          }),
              1)
        << flash.output();
    EXPECT_TRUE(contains(flash.output(), "anoctl: the gateway stopped: ")) << flash.output();
    EXPECT_TRUE(contains(flash.output(), "the device is still in its loader: flash it again")) << flash.output();
}

TEST_F(AnoctlAnswers, streams_end_with_the_gateway) {
    Process log{ANOCTL, {"log", "--control", socket}};
    Process image{ANOCTL, {"image", dir / "pictures", "--control", socket}};
    ASSERT_TRUE(wait_until([&] {
        peer.send(gateway.port("peer"), frame(0xDD, 0xFE, 0xA0, {0, 'x'}));
        return contains(log.output(), "0xDD x");
    }));
    gateway.signal(SIGTERM);
    EXPECT_EQ(log.wait(), 1);
    EXPECT_TRUE(contains(log.output(), "anoctl: the gateway closed the connection")) << log.output();
    EXPECT_EQ(image.wait(), 1);
}

TEST_F(AnoctlAnswers, confirmations_name_the_data_to_be_lost_and_lines_wrap_between_words) {
    if (std::system("tmux -V > /dev/null 2>&1") != 0) GTEST_SKIP() << "tmux is not installed";
    const auto tmux = [&](const std::string& words) {
        return std::system(("TERM=xterm tmux -S " + (dir / "tmux") + " " + words + " 2>/dev/null").c_str());
    };
    ASSERT_EQ(tmux("-f /dev/null new-session -d -x 50 -y 40 -s t 'cd " + dir.path().string() + " && sh'"), 0);
    std::string screen;
    const auto shows = [&](const std::string& words) {
        return wait_until([&] {
            Process capture{"tmux", {"-S", dir / "tmux", "capture-pane", "-p", "-t", "t"}};
            capture.wait();
            screen = capture.output();
            return contains(screen, words);
        });
    };
    dir.write("a", "#!/bin/sh\nexec " ANOCTL " \"$@\" --control " + socket + "\n");
    dir.write("x.json", "{}");
    tmux("send-keys -t t 'clear; sh a param reset' Enter");
    EXPECT_TRUE(shows("[y/N]")) << screen;
    EXPECT_TRUE(contains(screen, "All parameters of 0xDC are reset to factory")) << screen;
    tmux("send-keys -t t 'n' Enter");
    EXPECT_TRUE(shows("anoctl: nothing was changed")) << screen;
    tmux("send-keys -t t 'clear; sh a param export x.json' Enter");
    EXPECT_TRUE(shows("x.json already exists. Replace it? [y/N]")) << screen;
    tmux("send-keys -t t 'n' Enter");
    EXPECT_TRUE(shows("anoctl: nothing was read")) << screen;
    EXPECT_EQ(file_text(dir / "x.json"), "{}");
    tmux("send-keys -t t 'clear; sh a waypoint put' Enter");
    EXPECT_TRUE(shows("anoctl: reading waypoints as JSON from")) << screen;
    tmux("kill-server");
}

}    // namespace
}    // namespace anoctl_answers_tests
