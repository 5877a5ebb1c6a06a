// Recordings in a configuration.
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_recordings_tests {
namespace {

TEST(Config, records_nothing_without_a_record_section) {
    EXPECT_FALSE(settings_of("{}").record.has_value());
    EXPECT_EQ(settings_of(R"({"record": {}})").record, RecordSettings{});
}

TEST(Config, errors_in_the_record_section_name_their_location) {
    EXPECT_EQ(faults_in(R"({"record": {"direction": ["in", "ot"]}})"),
              "/record/direction: 'direction' has 'ot', which is not in, out or dropped (did you mean 'out'?)\n");
    EXPECT_EQ(faults_in(R"({"record": {"direction": []}})"),
              "/record/direction: 'direction' must list what to record: in, out, dropped\n");
    EXPECT_EQ(faults_in(R"({"links": ["sim:fc"], "record": {"link": ["fx"]}})"),
              "/record/link/0: there is no link 'fx' (did you mean 'fc'?); use one of fc\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"free": "1MB"}}})"),
              "/record/keep/free: 'keep.free' must be at least 'free', 500MB: otherwise recording stops before old files are "
              "deleted\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"bytes": "1MB"}}})").substr(0, 19), "/record/keep/bytes:");
    EXPECT_EQ(faults_in(R"({"record": {"format": "csv"}})"), "/record/format: 'format' must be one of pcapng, mcap, not 'csv'\n");
    EXPECT_EQ(faults_in(R"({"record": {"message_encoding": "xml"}})"),
              "/record/message_encoding: 'message_encoding' must be one of cdr, json, not 'xml'\n");
}

TEST(Config, a_recording_size_without_its_unit_is_rejected) {
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": "20"}}})"),
              "/record/keep/size: 'keep.size' must be 0 or at least 100kB, not 20 bytes: add a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": 99999}}})").substr(0, 18), "/record/keep/size:");
    EXPECT_EQ(faults_in(R"({"record": {"rotate": {"size": "9999"}}})"),
              "/record/rotate/size: 'rotate.size' must be 0 or at least 10kB, not 9999 bytes: add a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"free": 500}, "free": 0}})"),
              "/record/keep/free: 'keep.free' must be 0 or at least 1MB, not 500 bytes: add a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"free": "999kB"}})"),
              "/record/free: 'free' must be 0 or at least 1MB, not 999000 bytes: add a unit, such as 20GB\n");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": "100kB", "free": "1MB"}, "rotate": {"size": 10000}, "free": 1000000}})"),
              "");
    EXPECT_EQ(faults_in(R"({"record": {"keep": {"size": 0, "free": 0}, "rotate": {"size": "0"}, "free": 0}})"), "");
}

TEST(Config, warns_of_a_message_encoding_without_mcap) {
    const auto warnings_in = [](const std::string& record) {
        return lines(parse_config(R"({"links": ["sim:fc"], "record": )" + record + "}").warnings);
    };
    const std::string warned =
        "anogated: /record/message_encoding: warning: 'message_encoding' has no effect on the format pcapng: set 'format' to "
        "\"mcap\", the only one with decoded messages\n";
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json"})"), warned);
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json", "format": "pcapng"})"), warned);
    EXPECT_EQ(warnings_in(R"({"message_encoding": "json", "format": "mcap"})"), "");
    EXPECT_EQ(warnings_in(R"({"message_encoding": "cdr"})"), "");
}

TEST(Config, warns_of_files_larger_than_the_limit_for_all_recordings) {
    const auto warnings_in = [](const std::string& record) {
        return lines(parse_config(R"({"links": ["sim:fc"], "record": )" + record + "}").warnings);
    };
    const std::string warned = "anogated: /record/keep/size: warning: 'keep.size' is smaller than 'rotate.size', ";
    EXPECT_EQ(warnings_in(R"({"keep": {"size": "999MB"}})").substr(0, warned.size() + 4), warned + "1GB:");
    EXPECT_NE(warnings_in(R"({"keep": {"size": "20MB"}, "rotate": {"size": "21MB"}})"), "");
    EXPECT_EQ(warnings_in(R"({"keep": {"size": "20MB"}, "rotate": {"size": "20MB"}})"), "");
    EXPECT_EQ(warnings_in(R"({"keep": {"size": "20MB"}, "rotate": {"size": 0, "time": "60s"}})"), "");
    EXPECT_EQ(warnings_in(R"({"keep": {"age": "24h"}})"), "");
}

}    // namespace
}    // namespace anogate::config_recordings_tests
