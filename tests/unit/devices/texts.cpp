// The names and texts of devices in UTF-8 and GBK, through the routes: clients use UTF-8, devices their own encoding.
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

#include <ano_json/text.hpp>

namespace texts_tests {
namespace {

using namespace support;
using json = nlohmann::ordered_json;

std::string gbk(std::string_view text) { return ano::from_utf8(text, ano::Encoding::gbk).value(); }
Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

struct TextRoutes : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    /// The texts of a device with that encoding; in some of them the last character is truncated.
    void make(const std::function<std::string(std::string_view)>& encoded) {
        fake.name = encoded("飞控");
        const auto cut = [&](std::string_view text, std::size_t size) { return encoded(text).substr(0, size); };
        fake.parameters = {{0, encoded("横滚P"), encoded("比例增益"), {7}},
                           {10, encoded("备注"), cut("任意文字任意文字", 11), bytes_of(cut("左前右后左前", 11) + '\0' + '\0')},
                           {8, cut("P位置控制器的比例增益系数", 20), "", {0, 0, 0x80, 0x3F}},
                           {0, "ASCII", "plain", {1}}};
        fake.commands = {{{1, 0, 1}, {3}, encoded("起飞"), encoded("高度")}, {{1, 0, 2}, {}, encoded("降落"), ""}};
    }
    void make_gbk() { make(gbk); }
    void make_utf8() {
        make([](std::string_view text) { return std::string{text}; });
    }
    json parameter(std::size_t i) { return net.ask("GET", "/devices/0xDC/parameters").json.at("parameters").at(i); }
    static std::string path(const std::string& rest, const std::string& text) {
        std::string out = "/devices/0xDC/" + rest + "/";
        for (const char c : text) {
            char code[4];
            std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned char>(c));
            out += code;
        }
        return out;
    }
    std::size_t writes() const {
        return static_cast<std::size_t>(
            std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xE1; }));
    }
};

TEST_F(TextRoutes, texts_of_either_encoding_are_shown_in_utf8_without_truncated_characters) {
    for (const bool is_gbk : {true, false}) {
        fake.version += 1;    // another device
        is_gbk ? make_gbk() : make_utf8();
        const json all = net.ask("GET", "/devices/0xDC/parameters").json;
        EXPECT_EQ(all.at("device").at("name"), "飞控");
        const json& rows = all.at("parameters");
        EXPECT_EQ(rows[0].at("name"), "横滚P");
        EXPECT_EQ(rows[0].at("text"), "比例增益");
        EXPECT_EQ(rows[1].at("text"), is_gbk ? "任意文字任" : "任意文");
        EXPECT_EQ(rows[1].at("value"), is_gbk ? "左前右后左" : "左前右");
        EXPECT_EQ(rows[2].at("name"), is_gbk ? "P位置控制器的比例增" : "P位置控制器的");
        EXPECT_EQ(rows[3].at("name"), "ASCII");
        const json commands = net.ask("GET", "/devices/0xDC/commands").json;
        EXPECT_EQ(commands.at("commands")[0].at("name"), "起飞");
        EXPECT_EQ(commands.at("commands")[0].at("text"), "高度");
        const json device = net.ask("GET", "/devices").json.at("devices").at(0);
        EXPECT_EQ(device.at("name"), "飞控");
        EXPECT_EQ(device.value("encoding", ""), is_gbk ? "gbk" : "");
    }
}

TEST_F(TextRoutes, a_dry_run_continues_after_a_text_that_the_encoding_cannot_represent) {
    make_gbk();
    const std::string given = R"({"parameters": {"备注": "é😀", "ASCII": 2}, "dry_run": )";
    const auto compared = net.ask("POST", "/devices/0xDC/apply", given + "true, \"longer\": true}");
    ASSERT_EQ(compared.status, 200u) << compared.json;
    const json& rows = compared.json.at("parameters");
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0].at("written"), "é😀");
    EXPECT_EQ(rows[0].at("was"), "左前右后左");
    EXPECT_EQ(rows[0].at("state"), "differs");
    EXPECT_EQ(rows[0].at("encodable"), false);
    EXPECT_NE(rows[0].at("what").get<std::string>().find("GBK"), std::string::npos) << rows[0];
    EXPECT_EQ(rows[1].at("state"), "differs");
    EXPECT_FALSE(rows[1].contains("encodable"));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", given + "false}").status, 422u);
    EXPECT_EQ(writes(), 0u);
}

TEST_F(TextRoutes, parameters_commands_and_devices_are_found_by_name) {
    make_gbk();
    const auto set = net.ask("PUT", path("parameters", "横滚P"), R"({"value": 3})");
    EXPECT_EQ(set.status, 200u) << set.json;
    EXPECT_EQ(set.json.at("name"), "横滚P");
    EXPECT_EQ(fake.parameters[0].value, Bytes{3});
    EXPECT_EQ(net.ask("GET", path("parameters", "P位置控制器的比例增")).json.at("value"), 1.0) << "a name that is cut";
    const auto called = net.ask("POST", path("commands", "起飞"), R"({"values": [150]})");
    EXPECT_EQ(called.status, 200u) << called.json;
    EXPECT_EQ(called.json.at("name"), "起飞");
    EXPECT_EQ(fake.heard.back()[3], 0xC0);
    EXPECT_EQ(net.ask("GET", "/devices/%E9%A3%9E%E6%8E%A7/parameters/ASCII").status, 200u);
    EXPECT_EQ(net.ask("GET", path("parameters", "俯仰P")).json.at("error"), "unknown parameter '俯仰P'");
    fake.parameters[0].store = [](const Bytes&) { return Bytes{3}; };
    EXPECT_EQ(net.ask("PUT", path("parameters", "横滚P"), R"({"value": 9})").json.at("error"), "0xDC keeps 横滚P at 3");
}

TEST_F(TextRoutes, a_value_is_written_in_the_encoding_of_the_device_and_its_bytes_are_counted) {
    make_gbk();
    const auto set = net.ask("PUT", path("parameters", "备注"), R"({"value": "前后左右"})");
    EXPECT_EQ(set.status, 200u) << set.json;
    EXPECT_EQ(set.json.at("was"), "左前右后左");
    EXPECT_EQ(set.json.at("stored"), "前后左右");
    EXPECT_EQ(std::string(fake.parameters[1].value.begin(), fake.parameters[1].value.begin() + 8), gbk("前后左右"));
    const auto fits = net.ask("PUT", path("parameters", "备注"), R"({"value": "前后左右前后"})");
    EXPECT_EQ(fits.status, 200u) << "12 bytes in GBK, 18 in UTF-8: " << fits.json;
    EXPECT_EQ(net.ask("PUT", path("parameters", "备注"), R"({"value": "前后左右前后左"})").status, 422u);
    const auto lacks = net.ask("PUT", path("parameters", "备注"), R"({"value": "🚁"})");
    EXPECT_EQ(lacks.status, 422u);
    EXPECT_EQ(lacks.json.at("error"), "备注: the text can't be written in GBK");
}

TEST_F(TextRoutes, applying_values_that_were_read_changes_nothing) {
    for (const bool is_gbk : {true, false}) {
        fake.version += 1;
        is_gbk ? make_gbk() : make_utf8();
        json values = json::object();
        const json listed = net.ask("GET", "/devices/0xDC/parameters").json;
        for (const json& row : listed.at("parameters")) values[row.at("name").get<std::string>()] = row.at("value");
        const std::size_t before = writes();
        const auto applied = net.ask("POST", "/devices/0xDC/apply", values.dump());
        EXPECT_EQ(applied.status, 200u) << applied.json;
        for (const json& row : applied.json.at("parameters")) EXPECT_EQ(row.at("state"), "unchanged") << row;
        EXPECT_EQ(writes(), before);
        values["横滚P"] = 9;
        values["备注"] = "右";
        const auto changed = net.ask("POST", "/devices/0xDC/apply", values.dump());
        EXPECT_EQ(changed.status, 200u) << changed.json;
        EXPECT_EQ(changed.json.at("parameters")[0], json::parse(R"({"name": "横滚P", "was": 7, "written": 9, "stored": 9,
            "clamped": false, "state": "written"})"));
        EXPECT_EQ(changed.json.at("parameters")[1].at("stored"), "右");
    }
}

// Such files have U+FFFD in place of each byte that is not UTF-8.
TEST_F(TextRoutes, names_in_files_of_older_versions_are_still_found) {
    make_gbk();
    const std::string raw = gbk("横滚P");
    const std::string once = ano::to_utf8({reinterpret_cast<const std::uint8_t*>(raw.data()), raw.size()}, ano::Encoding::utf8);
    const auto applied = net.ask("POST", "/devices/0xDC/apply", json{{once, 5}}.dump());
    EXPECT_EQ(applied.status, 200u) << applied.json;
    EXPECT_EQ(applied.json.at("parameters")[0].at("name"), "横滚P");
    EXPECT_EQ(fake.parameters[0].value, Bytes{5});
}

TEST_F(TextRoutes, the_encoding_key_of_the_link_overrides_detection) {
    fake.parameters = {{0, gbk("模"), "", {1}}};    // another character if read as UTF-8
    EXPECT_EQ(parameter(0).at("name"), "模") << "what is probable";
    net.link_limits.encoding = ano::Encoding::utf8;
    EXPECT_EQ(parameter(0).at("name"), "ģ");
    EXPECT_TRUE(net.reports.empty());
    net.link_limits.encoding = ano::Encoding::gbk;
    EXPECT_EQ(parameter(0).at("name"), "模");
    fake.version += 1;
    fake.parameters = {{0, gbk("模拟"), "", {1}}};
    net.link_limits.encoding = ano::Encoding::utf8;
    EXPECT_EQ(parameter(0).at("name").get<std::string>().find("模"), std::string::npos);
    const std::string hint = net.ask("GET", "/devices").json.at("devices").at(0).value("hint", "");
    EXPECT_NE(hint.find("set encoding=gbk"), std::string::npos) << "the key is wrong";
    EXPECT_EQ(net.reports, std::vector<std::string>{"0xDC: " + hint});
}

TEST_F(TextRoutes, one_text_that_is_not_utf8_determines_the_encoding_of_all) {
    fake.parameters = {{0, gbk("模"), "", {1}}, {0, gbk("模拟"), "", {1}}};
    EXPECT_EQ(parameter(0).at("name"), "模");
    net.passes(frame(0xDC, 0xFE, 0xE3, {0xDC, 100, 0, 99, 0, 0, 0, 0x20, 3, 'n', 'e', 'w'}));    // another device
    fake.name = "new";
    fake.version = 99;
    fake.parameters = {{0, "模", "", {1}}};
    EXPECT_EQ(parameter(0).at("name"), "模");
}

}    // namespace
}    // namespace texts_tests
