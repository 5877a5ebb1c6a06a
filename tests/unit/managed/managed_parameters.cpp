#include <gtest/gtest.h>
#include <managed/managed_parameters.hpp>

#include <ano/traffic.hpp>

#include <algorithm>
#include <chrono>
#include <string>

namespace managed_parameters_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

LinkSettings link(const std::string& name) {
    LinkSettings one;
    one.name = name;
    return one;
}

Settings settings() {
    Settings all;
    all.gateway.id = 21;
    all.links = {link("fc"), link("ground")};
    return all;
}

ManagedParameter row(const Settings& of_file, const std::string& name) {
    for (const ManagedParameter& one : managed_parameters(of_file))
        if (one.name == name) return one;
    ADD_FAILURE() << "unknown parameter " << name;
    return {};
}

std::optional<double> limit_of(const LinkSettings& of, std::uint8_t id) {
    for (const LimitRule& rule : of.rules.limit)
        if (rule.id == id) return rule.per_second;
    return std::nullopt;
}

TEST(ManagedParameters, list_those_of_the_gateway_first_and_then_two_of_each_link) {
    std::string names;
    for (const ManagedParameter& one : managed_parameters(settings())) names += one.name + " ";
    EXPECT_EQ(names, "LOG_LEVEL FORGET_AFTER UNKNOWN EN_fc LIM_fc EN_ground LIM_ground ");
}

TEST(ManagedParameters, have_short_unique_names_that_end_with_whole_characters) {
    Settings all = settings();
    all.links = {link("a-radio-with-a-long-name-1"), link("a-radio-with-a-long-name-2"), link("一二三四五六七")};
    std::vector<std::string> names;
    for (const ManagedParameter& one : managed_parameters(all)) names.push_back(one.name);
    for (const std::string& name : names) EXPECT_LE(name.size(), 20u) << name;
    EXPECT_EQ(names[3], "EN_a-radio-with-a-lo");
    EXPECT_EQ(names[5], "EN_a-radio-with-a-~2");
    EXPECT_EQ(names[7], "EN_一二三四五");
}

TEST(ManagedParameters, change_the_settings_of_their_keys) {
    const Settings file = settings();
    WrittenValues written;
    written.write(row(file, "LOG_LEVEL"), 1, file);
    written.write(row(file, "FORGET_AFTER"), 5000, file);
    written.write(row(file, "UNKNOWN"), 1, file);
    written.write(row(file, "EN_ground"), 0, file);
    const Settings all = written.applied(file);
    EXPECT_EQ(all.log.level, "debug");
    EXPECT_EQ(all.gateway.forget_after, 5s);
    EXPECT_EQ(all.gateway.unknown, Unknown::drop);
    EXPECT_TRUE(all.links[0].enabled);
    EXPECT_FALSE(all.links[1].enabled);
}

TEST(ManagedParameters, limit_every_message_of_telemetry_and_no_other) {
    Settings file = settings();
    file.links[0].rules.limit = {{0x01, 5}, {0x03, 200}, {0xB0, 1}};
    WrittenValues written;
    written.write(row(file, "LIM_fc"), 50, file);
    const LinkSettings fc = written.applied(file).links[0];
    EXPECT_EQ(limit_of(fc, 0x01), 5) << "the file allows less";
    EXPECT_EQ(limit_of(fc, 0x03), 50);
    EXPECT_EQ(limit_of(fc, 0x34), 50);
    EXPECT_EQ(limit_of(fc, 0xB0), 1);
    for (const std::uint8_t id : std::vector<std::uint8_t>{0x00, 0x40, 0xC0, 0xE1, 0xF1})
        EXPECT_EQ(limit_of(fc, id), std::nullopt) << int{id};
    EXPECT_TRUE(written.applied(file).links[1].rules.limit.empty());
}

TEST(ManagedParameters, may_name_the_link_for_unknown_addresses_only_where_the_file_does) {
    Settings file = settings();
    EXPECT_EQ(row(file, "UNKNOWN").max, 1);
    file.gateway.unknown = Unknown::link;
    file.gateway.unknown_link = "fc";
    EXPECT_EQ(row(file, "UNKNOWN").max, 2);
    EXPECT_EQ(value_in(file, row(file, "UNKNOWN")), 2);
    WrittenValues written;
    written.write(row(file, "UNKNOWN"), 0, file);
    EXPECT_EQ(written.applied(file).gateway.unknown_link, "");
    written.write(row(file, "UNKNOWN"), 2, file);
    EXPECT_EQ(written.applied(file).gateway.unknown_link, "fc");
    EXPECT_TRUE(written.empty()) << "it is what the file says";
}

TEST(WrittenValues, are_superseded_by_a_file_that_was_changed_later) {
    Settings file = settings();
    WrittenValues written;
    written.write(row(file, "FORGET_AFTER"), 5000, file);
    written.write(row(file, "EN_fc"), 0, file);
    file.gateway.forget_after = 60s;
    EXPECT_EQ(written.applied(file).gateway.forget_after, 60s);
    EXPECT_FALSE(written.applied(file).links[0].enabled) << "of that the file says what it said";
    EXPECT_EQ(written.forget_stale(file), std::vector<std::string>{"gateway/forget_after"});
    file.gateway.forget_after = 30s;
    EXPECT_EQ(written.applied(file).gateway.forget_after, 30s) << "forgotten is forgotten";
}

TEST(WrittenValues, of_a_removed_link_are_forgotten) {
    Settings file = settings();
    WrittenValues written;
    written.write(row(file, "EN_fc"), 0, file);
    file.links.erase(file.links.begin());
    EXPECT_EQ(written.forget_stale(file), std::vector<std::string>{"links/fc/enabled"});
    EXPECT_TRUE(written.empty());
}

TEST(WrittenValues, name_the_source_of_each_value) {
    Settings file = settings();
    file.gateway.forget_after = 60s;
    WrittenValues written;
    written.write(row(file, "LOG_LEVEL"), 0, file);
    using Pair = std::pair<double, ValueFrom>;
    EXPECT_EQ(written.effective(row(file, "LOG_LEVEL"), file), (Pair{0, ValueFrom::parameter}));
    EXPECT_EQ(written.effective(row(file, "FORGET_AFTER"), file), (Pair{60'000, ValueFrom::file}));
    EXPECT_EQ(written.effective(row(file, "EN_fc"), file), (Pair{1, ValueFrom::defaults}));
}

TEST(WrittenValues, are_kept_as_text) {
    const Settings file = settings();
    WrittenValues written;
    written.write(row(file, "LIM_fc"), 2.5, file);
    written.write(row(file, "EN_ground"), 0, file);
    EXPECT_EQ(WrittenValues::parse(written.text()), written);
    EXPECT_EQ(WrittenValues::parse(""), std::nullopt);
    EXPECT_EQ(WrittenValues::parse("{\"parameters\": {\"log/level\": 3}}"), std::nullopt);
}

TEST(WrittenValues, that_no_parameter_can_have_are_ignored) {
    const Settings file = settings();
    for (const char* value : {"7", "-1", "1e300"}) {
        const auto written = WrittenValues::parse(R"({"parameters": {"log/level": {"value": )" + std::string{value} +
                                                  R"(, "file": "info"}}})");
        ASSERT_TRUE(written);
        EXPECT_EQ(written->applied(file).log.level, "info") << value;
    }
}

TEST(WrittenValues, are_ignored_where_the_gateway_is_not_a_device) {
    Settings file = settings();
    WrittenValues written;
    written.write(row(file, "EN_fc"), 0, file);
    for (const int id : {0, 0xFE, 0xD2}) {
        file.gateway.id = static_cast<std::uint8_t>(id);
        EXPECT_TRUE(written.applied(file).links[0].enabled) << id;
    }
}

}    // namespace
}    // namespace managed_parameters_tests
