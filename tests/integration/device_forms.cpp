// Simulated devices of several generations and encodings, with the commands of anoctl: through a gateway, and over a link of
// their own.
#include <support/files.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <ostream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace device_forms_tests {
namespace {

using namespace support;
using nlohmann::json;

struct Ran {
    int exit = -1;
    std::string output;
};

Ran anoctl(std::vector<std::string> words, const std::vector<std::string>& place) {
    words.insert(words.end(), place.begin(), place.end());
    Process process{ANOCTL, std::move(words)};
    const int exit = process.wait();
    return {exit, process.output()};
}

bool contains(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

/// Names of the simulated flight controller.
struct Names {
    std::string device, gain, turn, note, charge, take_off;
};
const Names english{"SimFC", "SIM_P_ATTITUDE", "SIM_TURN", "SIM_NOTE", "SIM_CHARGE", "TAKE_OFF"};
const Names chinese{"模拟飞控", "横滚P", "转弯速度", "备注", "电池电量", "起飞"};

/// The generation, which decides how it describes its parameters, and the encoding of its texts.
class DeviceForms : public testing::TestWithParam<std::tuple<std::string, std::string>> {
protected:
    Ran run(std::vector<std::string> words) { return anoctl(std::move(words), {"--control", socket}); }
    /// The description of a parameter, with --json.
    json row(const std::string& name) {
        const Ran ran = run({"param", "get", name, "--json"});
        EXPECT_EQ(ran.exit, 0) << ran.output;
        return json::parse(ran.output, nullptr, false);
    }

    const std::string layout = std::get<0>(GetParam()), texts = std::get<1>(GetParam());
    const bool is_typed = layout == "typed", is_scaled = layout == "scaled";
    const Names& names = texts == "en" ? english : chinese;
    TempDir dir;
    std::string socket = dir / "control.sock";
    std::string link = "sim:fc,name=fc,parameters=" + layout + ",texts=" + texts;
    Daemon gateway{ANOGATED, socket, {link}};
};

TEST_P(DeviceForms, are_listed_read_written_and_commanded) {
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    const Ran list = run({"param", "list"});
    ASSERT_EQ(list.exit, 0) << list.output;
    EXPECT_TRUE(contains(list.output, names.gain)) << list.output;
    EXPECT_FALSE(contains(list.output, "\xEF\xBF\xBD")) << list.output;
    EXPECT_TRUE(contains(run({"devices", "--scan"}).output, names.device));
    const json gain = row(names.gain);
    EXPECT_EQ(gain.contains("min"), !is_typed) << gain;
    EXPECT_EQ(gain.value("mul", 1), is_scaled ? 1000 : 1);
    EXPECT_EQ(gain.value("max", 10), 10);
    const json charge = row(names.charge);
    const std::string cut = texts == "utf8" ? "剩余电量的百分比：写入后电池立即"
                                            : "剩余电量的百分比：写入后电池立即变为这个电量，飞行";
    EXPECT_EQ(charge.at("text"), texts == "en" ? "battery charge, %" : cut);

    EXPECT_EQ(run({"param", "set", names.gain, "3"}).output, names.gain + "=3\n");
    const bool has_fractions = is_typed || is_scaled;
    const Ran finer = run({"param", "set", names.gain, "4.125"});
    EXPECT_EQ(finer.exit, has_fractions ? 0 : 1) << finer.output;
    EXPECT_EQ(row(names.gain).at("value"), has_fractions ? 4.125 : 3);
    EXPECT_EQ(run({"param", "set", "--force", names.turn + "=100"}).output,
              names.turn + "=90 (device limited the requested 100)\n");
    if (is_scaled) {
        const Ran between = run({"param", "set", names.gain, "4.1255"});
        EXPECT_EQ(between.exit, 1);
        EXPECT_TRUE(contains(between.output, "'4.1255' is not a multiple of 0.001")) << between.output;
    }
    const Ran list_of_commands = run({"command", "list"});
    EXPECT_TRUE(contains(list_of_commands.output, names.take_off + " u16")) << list_of_commands.output;
    const Ran called = run({"command", "call", names.take_off, "150", "--yes"});
    EXPECT_EQ(called.exit, 0) << called.output;
    EXPECT_TRUE(contains(called.output, names.take_off + " 150: acknowledged")) << called.output;
}

TEST_P(DeviceForms, a_fresh_export_is_imported_without_a_difference) {
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    if (is_typed) {    // the others have no texts; it stores 29 bytes
        const Ran set = run({"param", "set", "--longer", names.note, "测试用的备注文字测试用的备注文"});
        EXPECT_EQ(set.exit, 0) << set.output;
    }
    const std::string file = dir / "backup.json";
    ASSERT_EQ(run({"param", "export", file}).exit, 0);
    const json backup = json::parse(file_text(file));
    EXPECT_EQ(backup.at("name"), names.device);
    EXPECT_TRUE(backup.at("parameters").contains(names.gain));
    const Ran same = run({"param", "import", file, "--with-calibration"});
    EXPECT_EQ(same.exit, 0) << same.output;
    EXPECT_EQ(same.output, "no differences\n");
    ASSERT_EQ(run({"param", "set", names.gain + "=5", names.turn + "=7"}).exit, 0);
    const Ran back = run({"param", "import", file, "--with-calibration", "--yes"});
    EXPECT_EQ(back.exit, 0) << back.output;
    EXPECT_TRUE(contains(back.output, "2 parameters written")) << back.output;
    EXPECT_EQ(run({"param", "diff", file, "--with-calibration"}).exit, 0);
}

INSTANTIATE_TEST_SUITE_P(All, DeviceForms,
                         testing::Combine(testing::Values("typed", "minmax", "scaled"), testing::Values("en", "utf8", "gbk")),
                         [](const auto& form) { return std::get<0>(form.param) + "_" + std::get<1>(form.param); });

// Each command starts a new device.
TEST(DeviceFormsByLink, are_read_without_a_gateway) {
    const TempDir dir;
    for (const std::string form : {"texts=gbk", "texts=utf8,profile=vendor", "texts=gbk,profile=vendor,parameters=scaled"}) {
        const std::vector<std::string> place{"--link", "sim:fc," + form};
        const std::string file = dir / "backup.json";
        const Ran exported = anoctl({"param", "export", file, "--yes"}, place);
        ASSERT_EQ(exported.exit, 0) << exported.output;
        EXPECT_TRUE(contains(exported.output, chinese.device)) << exported.output;
        EXPECT_TRUE(contains(file_text(file), "\"横滚P\": 7")) << form;
        EXPECT_EQ(anoctl({"param", "diff", file, "--with-calibration"}, place).output, "no differences\n") << form;
        EXPECT_EQ(anoctl({"param", "set", "横滚P", "3"}, place).output, "横滚P=3\n") << form;
        EXPECT_EQ(anoctl({"command", "call", "起飞", "150", "--yes"}, place).exit, 0) << form;
    }
}

}    // namespace
}    // namespace device_forms_tests
