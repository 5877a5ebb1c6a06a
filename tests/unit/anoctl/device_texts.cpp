// The output of device commands for answers, and their handling of typed input.
#include <anoctl/anoctl.hpp>
#include <anoctl/device/calibration_text.hpp>
#include <anoctl/device/command_values.hpp>
#include <anoctl/device/job_text.hpp>
#include <anoctl/device/job_view.hpp>
#include <anoctl/device/parameter_file.hpp>
#include <anoctl/device/waypoint_form.hpp>

#include <support/thrown.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>
#include <string>
#include <vector>

using namespace anoctl;
using ano::Json;
using support::thrown;

namespace device_texts_tests {
namespace {

TEST(JobText, shows_the_rate_and_the_remaining_time) {
    const Json job{{"done", 60}, {"total", 150}, {"unit", "parameters"}, {"message", "reading"}};
    EXPECT_EQ(progress_text(job, 5, 200), "[########............] 60 of 150 parameters, 12/s, 7.5 s left: reading");
    EXPECT_EQ(progress_text(job, 0.1, 200), "[########............] 60 of 150 parameters: reading")
        << "nothing is known of the rate yet";
    EXPECT_EQ(progress_text(job, 5, 10), "[########.");
    const Json told{{"unit", "bytes"}, {"message", "sending, 12.3 KB/s, 3 s left"}};
    EXPECT_EQ(progress_text(told, 5, 200), "sending") << "the rate stands elsewhere";
    const Json file{{"done", 128 * 1024}, {"total", 256 * 1024}, {"unit", "bytes"}};
    EXPECT_EQ(progress_text(file, 4, 200), "[##########..........] 128 KiB of 256 KiB, 32 KiB/s, 4.0 s left");
    const Json whole{{"done", 4}, {"total", 4}, {"unit", "steps"}};
    EXPECT_EQ(progress_text(whole, 2, 200), "[####################] 4 of 4 steps, 2/s");
    EXPECT_EQ(progress_text(Json{{"message", "waits"}}, 2, 200), "waits");
}

TEST(JobText, describes_a_partly_finished_job) {
    const auto half = [](const char* kind, int done) {
        return half_done(Json{{"kind", kind}, {"done", done}, {"total", 2048}, {"unit", "bytes"}});
    };
    EXPECT_EQ(half("firmware", 1024), "1 KiB of 2 KiB written; the device is still in its loader: flash it again");
    EXPECT_EQ(half("firmware", 0), "");
    EXPECT_NE(half("apply", 1).find("unless saved"), std::string::npos);
    EXPECT_EQ(half("put_waypoints", 0), "0 bytes of 2 KiB written");
    EXPECT_EQ(half("put_waypoints", 1),
              "1 bytes of 2 KiB written; the device has a mixture of new and old waypoints until you write all of them");
    EXPECT_EQ(half("command", 0), "the command may have been executed");
    EXPECT_EQ(half("parameters", 7), "") << "who only reads leaves nothing";
}

TEST(JobText, lists_the_written_and_undone_parameters_of_a_cancelled_apply) {
    const auto half = [](std::vector<const char*> states) {
        Json rows = Json::array();
        for (const char* state : states)
            rows.push_back({{"name", "P" + std::to_string(rows.size())}, {"state", state}, {"what", "P may have been written"}});
        return half_done(Json{{"kind", "apply"}, {"done", 2}, {"total", 9}, {"result", {{"parameters", rows}}}});
    };
    EXPECT_EQ(half({"unchanged", "waiting"}), "nothing was written");
    EXPECT_EQ(half({"written", "clamped", "failed", "waiting"}),
              "2 parameters written; unless saved, the changes are lost when the device restarts; P may have been "
              "written");
    EXPECT_EQ(half({"undone", "undone", "waiting"}), "2 parameters written and restored");
    EXPECT_EQ(half({"not_undone", "undone", "not_undone"}), "1 parameter written and restored; not restored: P0, P2");
}

const Json answered{{"device", {{"address", "0xDC"}, {"name", "SimFC"}, {"dev_id", 220}, {"hw", 100}, {"sw", 3}, {"pt", 800}}},
                    {"parameters",
                     {{{"id", 0}, {"name", "PID_P"}, {"type", "f32"}, {"value", 1.5}},
                      {{"id", 1}, {"name", "CAL_AOFF_X"}, {"type", "f32"}, {"value", 0.25}},
                      {{"id", 2}, {"name", "NAME"}, {"type", "string"}, {"value", "x"}}}}};

TEST(ParameterFile, stores_values_by_name_in_order) {
    EXPECT_EQ(
        parameter_file(answered).dump(),
        R"({"device":"0xDC","name":"SimFC","dev_id":220,"hw":100,"sw":3,"parameters":{"PID_P":1.5,"CAL_AOFF_X":0.25,"NAME":"x"}})");
}

TEST(ParameterFile, is_not_exported_with_missing_values) {
    Json holed = answered;
    holed["parameters"][1].erase("value");
    EXPECT_EQ(thrown<Failure>([&] { parameter_file(holed); }),
              "nothing was exported; these parameters were not received: CAL_AOFF_X");
}

TEST(ParameterFile, adds_the_number_where_a_name_is_ambiguous_or_empty) {
    Json alike = answered;
    alike["parameters"][0]["id"] = 0;
    alike["parameters"][1]["id"] = 1;
    alike["parameters"][2]["id"] = 2;
    alike["parameters"][2]["name"] = "PID_P";
    alike["parameters"][1]["name"] = "a\nb";
    EXPECT_EQ(parameter_file(alike)["parameters"].dump(), R"({"PID_P#0":1.5,"a\nb":0.25,"PID_P#2":"x"})")
        << "a name is as the device has it";
    alike["parameters"][1]["name"] = "";
    EXPECT_TRUE(parameter_file(alike)["parameters"].contains("#1"));
}

TEST(ParameterFile, is_read_as_it_was_written_or_as_plain_names_and_values) {
    const Json whole = parsed_parameter_file(parameter_file(answered).dump(), "f");
    EXPECT_EQ(whole["name"], "SimFC");
    EXPECT_EQ(whole["parameters"]["PID_P"], 1.5);
    EXPECT_EQ(parsed_parameter_file(R"({"A": 1})", "f")["parameters"]["A"], 1);
    EXPECT_NE(thrown<UsageError>([] { parsed_parameter_file("{", "f"); }).find("f: not valid JSON: "), std::string::npos);
    EXPECT_EQ(thrown<UsageError>([] { parsed_parameter_file("{}", "f"); }), "f: the file contains no parameters");
    EXPECT_EQ(thrown<UsageError>([] { parsed_parameter_file("[1]", "f"); }),
              "f: not a parameter file; expected {\"parameters\": {NAME: value}}");
    EXPECT_EQ(thrown<UsageError>([] { parsed_parameter_file(R"({"A": [1]})", "f"); }),
              "f: the value of 'A' is neither a number nor a text");
}

TEST(ParameterFile, of_another_device_is_detected) {
    const Json& device = answered["device"];
    EXPECT_EQ(of_another_device(Json{{"name", "SimFC"}, {"dev_id", 220}}, device), "");
    EXPECT_EQ(of_another_device(Json{{"parameters", Json::object()}}, device), "") << "it does not say";
    EXPECT_EQ(of_another_device(Json{{"name", "Other"}, {"dev_id", 220}}, device),
              "the file is for Other, but the device is SimFC, device type 220");
    EXPECT_EQ(of_another_device(Json{{"name", "Other"}, {"dev_id", 1}}, device),
              "the file is for Other, device type 1, but the device is SimFC, device type 220");
}

TEST(ParameterFile, leaves_out_values_that_are_specific_to_one_piece_of_hardware) {
    const Json file = parameter_file(answered);
    std::size_t left_out = 9;
    EXPECT_EQ(wanted_values(file, false, left_out).dump(), R"({"PID_P":1.5,"NAME":"x"})");
    EXPECT_EQ(left_out, 1u);
    EXPECT_EQ(wanted_values(file, true, left_out).size(), 3u);
    EXPECT_EQ(left_out, 0u);
}

TEST(ParameterFile, stores_null_for_numbers_that_json_cannot_represent) {
    Json strange = answered;
    strange["parameters"][0]["value"] = "nan";
    strange["parameters"][2]["value"] = "nan";    // a text
    const Json file = parameter_file(strange);
    EXPECT_EQ(file["parameters"].dump(), R"({"PID_P":null,"CAL_AOFF_X":0.25,"NAME":"nan"})");
    std::size_t left_out = 0;
    EXPECT_EQ(wanted_values(parsed_parameter_file(file.dump(), "f"), true, left_out).dump(),
              R"({"CAL_AOFF_X":0.25,"NAME":"nan"})");
    EXPECT_EQ(names_without_value(file), "PID_P");
}

TEST(ParameterFile, may_contain_the_values_stored_by_a_calibration) {
    const Json kept = parsed_parameter_file(
        R"({"device": {"address": "0xDC", "name": "SimFC", "dev_id": 220}, "parameters": {"CAL_AOFF_X": 1}})", "f");
    EXPECT_EQ(kept["device"], "0xDC");
    EXPECT_EQ(of_another_device(kept, answered["device"]), "");
    EXPECT_EQ(of_another_device(kept, Json{{"name", "Other"}}), "the file is for SimFC, but the device is Other, device type ");
    EXPECT_TRUE(is_kept_by_calibration("/var/lib/anogate/calibration-0xDC-compass.json"));
    EXPECT_TRUE(is_kept_by_calibration("calibration-0xDC-accelerometer.json"));
    EXPECT_FALSE(is_kept_by_calibration("calibration-0xDC.json"));
    EXPECT_FALSE(is_kept_by_calibration("calibration-0xDC-compass.json/backup.json"));
}

TEST(ParameterFile, shows_the_changes) {
    const Json answer{{"parameters",
                       {{{"name", "A"}, {"was", 1}, {"written", 1}, {"state", "unchanged"}},
                        {{"name", "B"}, {"was", 1.5}, {"written", 2}, {"state", "differs"}},
                        {{"name", "C"}, {"was", 1}, {"written", 9}, {"stored", 5}, {"state", "clamped"}},
                        {{"name", "D"}, {"written", 9}, {"state", "failed"}, {"what", "unknown parameter D"}},
                        {{"name", "F"}, {"was", 1}, {"written", 2}, {"stored", 2}, {"state", "not_undone"}},
                        {{"name", "G"}, {"was", 1}, {"written", 2}, {"stored", 1}, {"state", "failed"}, {"what", "it keeps 1"}},
                        {{"name", "H"}, {"was", 1}, {"written", 2}, {"state", "waiting"}},
                        {{"name", "E"}, {"was", "a"}, {"written", "b\x1b"}, {"stored", "b\x1b"}, {"state", "written"}}}}};
    EXPECT_EQ(
        difference_lines(answer),
        (std::vector<std::string>{"B: 1.5 -> 2", "C: 1 -> 5, limited by the device: 9 was requested",
                                  "D: 9, failed: unknown parameter D", "F: 1 -> 2, not restored", "G: 1 -> 2, failed: it keeps 1",
                                  "H: 1 -> 2, not attempted", "E: \"a\" -> \"b\\u001b\""}));
    EXPECT_EQ(rows_with(answer, "failed"), 2u);
    EXPECT_EQ(misfit_line(answer["parameters"][3]), "unknown parameter D");
    EXPECT_EQ(misfit_line(answer["parameters"][5]), "G: it keeps 1");
}

const Json commands{{{"id", 0}, {"name", "land"}, {"values", Json::array()}},
                    {{"id", 1}, {"name", "move"}, {"values", {"u8", "i16", "f32"}}},
                    {{"id", 2}, {"name", "twice"}, {"values", Json::array()}},
                    {{"id", 3}, {"name", "twice"}, {"values", Json::array()}}};

TEST(CommandValues, find_the_command_by_name_or_number) {
    EXPECT_EQ(command_called(commands, "move")["id"], 1);
    EXPECT_EQ(command_called(commands, "0")["name"], "land");
    EXPECT_EQ(command_called(commands, "3")["id"], 3);
    EXPECT_EQ(thrown<UsageError>([] { command_called(commands, "mve"); }),
              "the device has no command 'mve' (did you mean 'move'?); to list the commands: anoctl command list");
    EXPECT_NE(thrown<UsageError>([] { command_called(commands, "twice"); }).find("several commands are named 'twice'"),
              std::string::npos);
}

TEST(CommandValues, must_match_the_count_types_and_ranges_of_the_command) {
    const Json& move = commands[1];
    EXPECT_EQ(command_values(move, {"255", "-5", "1.5"}).dump(), "[255,-5,1.5]");
    EXPECT_EQ(thrown<UsageError>([&] { command_values(move, {"1"}); }), "move takes 3 values, not 1: move u8 i16 f32");
    EXPECT_EQ(thrown<UsageError>([&] { command_values(commands[0], {"1"}); }), "land takes 0 values, not 1: land");
    const Json seven{{"name", "seven"}, {"values", {"u64", "u8"}}};
    EXPECT_EQ(command_values(seven, {"1.5", "2"}, true).dump(), "[1.5,2]") << "the stored type may be wrong";
    EXPECT_NE(thrown<UsageError>([&] { command_values(seven, {"1.5", "2.5"}, true); }), "") << "only that of value type 7";
    EXPECT_EQ(thrown<UsageError>([&] { command_values(move, {"1", "x", "1"}); }), "move, value 2: 'x' is not a number");
    for (const char* wrong : {"256", "-1", "1.5"})
        EXPECT_EQ(thrown<UsageError>([&] {
                      command_values(move, {wrong, "1", "1"});
                  }).find("move, value 1: '" + std::string{wrong} + "' "),
                  0u)
            << wrong;
}

TEST(WaypointForm, is_recognized_by_file_name_or_content) {
    EXPECT_EQ(form_of_name("a.geojson"), "geojson");
    EXPECT_EQ(form_of_name("a.plan"), "qgc");
    EXPECT_EQ(form_of_name("a.json"), "json");
    EXPECT_EQ(form_of_name("way"), "json");
    EXPECT_EQ(form_of_name("-"), "json");
    EXPECT_EQ(thrown<UsageError>([] { form_of_name("a.kml"); }),
              "a.kml: '.kml' is not a supported waypoint format; use .json, .geojson or .plan (QGroundControl), or --format");
    EXPECT_EQ(form_of_content(Json{{"type", "FeatureCollection"}}, "f"), "geojson");
    EXPECT_EQ(form_of_content(Json{{"fileType", "Plan"}}, "f"), "qgc");
    EXPECT_EQ(form_of_content(Json{{"waypoints", Json::array()}}, "f"), "json");
    EXPECT_NE(thrown<UsageError>([] {
                  form_of_content(Json{{"way", 1}}, "f");
              }).find("f: not a waypoint file"),
              std::string::npos);
}

std::string overwriting(const std::vector<std::uint8_t>& numbers, std::size_t had) {
    std::vector<ano::host::Waypoint> all(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) all[i].num = numbers[i];
    return overwriting_text(all, had);
}

TEST(WaypointForm, lists_the_waypoints_that_will_be_overwritten) {
    EXPECT_EQ(overwriting({0, 1}, 0), "");
    EXPECT_EQ(overwriting({0, 1}, 1), "The device has 1 waypoint (number 0): it will be overwritten. ");
    EXPECT_EQ(overwriting({0, 1}, 2), "The device has 2 waypoints (0 to 1): all will be overwritten. ");
    EXPECT_EQ(
        overwriting({0}, 2),
        "The device has 2 waypoints (0 to 1): 0 will be overwritten, and 1 remains (the protocol cannot remove waypoints). To "
        "shorten the route, repeat the last point in the file until it has 2. ");
    EXPECT_NE(overwriting({0, 1}, 5).find("0 and 1 will be overwritten, and 2 to 4 remain "), std::string::npos);
}

TEST(WaypointForm, lists_overwritten_waypoints_by_their_numbers) {
    EXPECT_EQ(overwriting({7, 3}, 8).find(
                  "The device has 8 waypoints (0 to 7): 3 and 7 will be overwritten, and 0 to 2 and 4 to 6 remain"),
              0u)
        << overwriting({7, 3}, 8);
    EXPECT_EQ(overwriting({7, 3}, 8).find("To end"), std::string::npos);
    EXPECT_EQ(overwriting({9}, 8),
              "The device has 8 waypoints (0 to 7): none will be overwritten, and 0 to 7 remain (the protocol cannot remove "
              "waypoints). The file has no waypoint 8; the device decides their content. ");
}

TEST(WaypointForm, points_without_a_speed_are_named) {
    std::vector<ano::host::Waypoint> two(2);
    two[1].num = 4;
    const Json plain{{"waypoints", {{{"lng", 1}}, {{"lng", 1}, {"spd", 0}}}}};
    EXPECT_EQ(speedless_text(plain, "json", two), "The file has no speed for 0 (counted from 0); 0 cm/s is written. ");
    const Json map{{"features", {{{"properties", {{"spd", 0}}}}, {{"geometry", 1}}}}};
    EXPECT_EQ(speedless_text(map, "geojson", two), "The file has no speed for 4 (counted from 0); 0 cm/s is written. ");
    EXPECT_EQ(speedless_text({}, "qgc", two),
              "The file has no speed for 4 (counted from 0); 0 cm/s is written because the plan does not set a speed before. ");
    two[1].spd = 5;
    EXPECT_EQ(speedless_text({}, "qgc", two), "");
}

TEST(CalibrationText, draws_the_face_that_is_up_and_lists_those_that_are_done) {
    const Json job{{"step", {{"face", "+y"}, {"still", 0.4}, {"faces", {{"+y", 0.5}}}, {"done", {"+x", "-z"}}}}};
    EXPECT_EQ(calibration_lines(job), (std::vector<std::string>{
                                          "     __________     [x] +x",
                                          "    /  +y up   /|   [ ] -x",
                                          "   /__________/ |   [>] +y, 50 %, still 40 %",
                                          "   |          | |   [ ] -y",
                                          "   |          | /   [ ] +z",
                                          "   |__________|/    [x] -z",
                                      }));
    EXPECT_EQ(calibration_step(job), "2 of 6 faces: +x, -z");
    const Json enough{{"step", {{"face", "+y"}, {"still", 0.4}, {"faces", {{"+y", 1}}}, {"done", {"+y"}}}}};
    EXPECT_EQ(calibration_lines(enough)[2], "   /__________/ |   [x] +y, done: turn it to the next face");
    const Json unknown{{"step", {{"face", nullptr}, {"still", 0}, {"done", Json::array()}}}};
    EXPECT_NE(calibration_lines(unknown)[1].find("/    ?     /|"), std::string::npos);
    EXPECT_TRUE(calibration_lines(Json{{"message", "reading"}}).empty());
    EXPECT_EQ(calibration_step(Json{{"message", "reading"}}), "");
}

TEST(CalibrationText, draws_the_sphere_from_top_to_bottom) {
    Json cells = Json::array();
    for (int i = 0; i < 72; ++i) cells.push_back(i == 0 || i == 71 ? 1 : 0);
    const Json job{{"step", {{"coverage", cells}, {"filled", 0.278}}}};
    const auto lines = calibration_lines(job);
    ASSERT_EQ(lines.size(), 7u);
    EXPECT_EQ(lines[0], "   +z    . . . . . . . . . . . #");
    EXPECT_EQ(lines[1], "         . . . . . . . . . . . .");
    EXPECT_EQ(lines[5], "   -z    # . . . . . . . . . . .");
    EXPECT_EQ(lines[6].find("   28 % of all directions"), 0u) << lines[6];
    EXPECT_EQ(calibration_step(job), "20 % of all directions");
}

TEST(CalibrationText, is_wrapped_on_a_narrow_terminal) {
    EXPECT_EQ(broken_lines({"   28 % of all directions (80 % required); turn it toward the dots", "  . #"}, 60),
              (std::vector<std::string>{"   28 % of all directions (80 % required); turn it toward", "    the dots", "  . #"}));
}

TEST(JobText, names_the_option_that_allows_a_refused_action) {
    const std::string text = "A: \"xy\" is longer than the 1 byte that the device has: a longer one must be allowed (longer)";
    EXPECT_EQ(with_options_named(text, "param"),
              "A: \"xy\" is longer than the 1 byte that the device has: --longer allows a longer one");
    const std::string flies = "0xDC is unlocked or flying: this is only allowed on the ground";
    EXPECT_EQ(with_options_named(flies, "flash"), flies + "; land and lock it, or use --force");
    EXPECT_EQ(with_options_named(flies, "calibrate"), flies + "; land and lock it first") << "it has no such option";
}

TEST(JobText, names_jobs_after_their_commands) {
    EXPECT_EQ(command_of_job("put_waypoints"), "waypoint put");
    EXPECT_EQ(command_of_job("firmware"), "flash");
    EXPECT_EQ(command_of_job("write"), "param set");
    EXPECT_EQ(command_of_job("of a later gateway"), "of a later gateway");
}

TEST(LiveLines, are_rewritten_in_place_even_after_enter_was_pressed) {
    std::ostringstream err;
    LiveLines lines{err};
    lines.went_down(1);    // nothing is shown yet
    lines.show({"a", "b"}, 80);
    EXPECT_EQ(err.str(), "\r\x1b[Ja\r\nb");
    err.str({});
    lines.show({"c"}, 80);
    EXPECT_EQ(err.str(), "\r\x1b[1A\x1b[Jc");
    err.str({});
    lines.went_down(2);
    lines.show({"d"}, 80);
    EXPECT_EQ(err.str(), "\r\x1b[2A\x1b[Jd");
    err.str({});
    lines.show({"e"}, 80);
    EXPECT_EQ(err.str(), "\r\x1b[Je");
}

TEST(CalibrationText, shows_the_residuals_and_the_new_values) {
    EXPECT_EQ(calibration_result(Json{{"before", 25.31}, {"after", 1.25}, {"values", {{"CAL_AOFF_X", 1.5}}}}, "accelerometer"),
              (std::vector<std::string>{"residual 25.3 cm/s² before, 1.25 cm/s² now", "CAL_AOFF_X=1.5",
                                        "saved permanently in the device"}));
    EXPECT_EQ(calibration_result(Json{{"before", 25.31}, {"after", 1.25}, {"verified", 2.5}, {"restarts", 2}}, "accelerometer"),
              (std::vector<std::string>{"residual 25.3 cm/s² before, 1.25 cm/s² now", "measured with the new values: 2.5 cm/s²",
                                        "the device restarted 2 times during the calibration; only samples after that were used",
                                        "saved permanently in the device"}));
    EXPECT_EQ(calibration_result(Json{{"error_matrix", "kept"}}, "accelerometer")[1],
              "the error matrix (CAL_AEM) is unchanged: to measure it, lay each face level to 0.2°");
    EXPECT_EQ(calibration_result(Json{{"values", {{"CAL_AEM1_X", 1.0}}}}, "accelerometer")[1], "CAL_AEM1_X=1")
        << "as param has it";
    EXPECT_EQ(calibration_result(Json{{"before", 0.12}, {"after", 0.012}}, "compass")[0], "residual 12 % before, 1.2 % now");
}

}    // namespace
}    // namespace device_texts_tests
