// The reader without a broker: what gateways send, and what is in its folder afterwards.
#include <mqtt/collector.hpp>

#include <support/files.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace collector_tests {
namespace {

using namespace anogate;

constexpr std::uint64_t noon = 1'700'049'600;    // 2023-11-15T12:00:00Z

std::string line(const std::string& gateway, const std::string& stream, std::uint64_t seq) {
    return R"({"gateway":")" + gateway + R"(","stream":")" + stream + R"(","seq":)" + std::to_string(seq) +
           R"(,"time":1.5,"link":"fc","from":5,"id":3,"fields":{}})";
}

struct Collected {
    support::TempDir dir;
    Collector collector{dir / "all", false};

    Collected() { EXPECT_TRUE(collector.open()); }
    void receive(const std::string& topic, const std::string& payload, std::uint64_t now_s = noon) {
        BrokerMessage message;
        message.topic = topic;
        message.payload = payload;
        EXPECT_TRUE(collector.receive(message, now_s));
    }
    std::string text(const std::string& file) const { return support::file_text(dir / ("all/" + file)); }
};

TEST(MqttCollector, writes_each_record_once_into_the_file_of_its_gateway_and_day) {
    Collected c;
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 1));
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 1));
    const std::vector<Record> records{{1, Keep::low, {}, 0, "", line("g", "s", 1)}, {2, Keep::low, {}, 0, "", line("g", "s", 2)}};
    c.receive("anogate/v1/g/backlog/low", BatchPacker{}.pack(records).at(0).body);
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 3), noon + 86'400);
    c.receive("anogate/v1/h/up/fc-05/euler", line("h", "s", 1));
    EXPECT_EQ(c.text("g/2023-11-15.ndjson"), line("g", "s", 1) + '\n' + line("g", "s", 2) + '\n');
    EXPECT_EQ(c.text("g/2023-11-16.ndjson"), line("g", "s", 3) + '\n');
    EXPECT_EQ(c.text("h/2023-11-15.ndjson"), line("h", "s", 1) + '\n');
    EXPECT_EQ(c.collector.counts().repeats, 2u);
    EXPECT_EQ(c.collector.counts().invalid, 0u);
}

TEST(MqttCollector, a_gateway_can_neither_write_nor_suppress_records_of_another) {
    Collected c;
    c.receive("anogate/v1/evil/up/fc-05/euler", line("g", "s", 1));       // not its own name
    c.receive("anogate/v1/evil/up/fc-05/euler", line("evil", "s", 2));    // the stream of another
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 1));
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 2));
    EXPECT_EQ(c.text("g/2023-11-15.ndjson"), line("g", "s", 1) + '\n' + line("g", "s", 2) + '\n');
    EXPECT_EQ(c.collector.counts().invalid, 1u);
}

TEST(MqttCollector, nothing_is_written_outside_of_the_folder_and_rubbish_is_counted) {
    Collected c;
    c.receive("anogate/v1/../up/fc-05/euler", line("..", "s", 1));
    EXPECT_FALSE(std::filesystem::exists(c.dir / "2023-11-15.ndjson"));
    EXPECT_NE(c.text("_./2023-11-15.ndjson"), "");
    for (const char* rubbish : {"", "x", "[]", "{}", R"({"gateway":"g"})", R"({"gateway":"g","stream":"s","seq":-1})"})
        c.receive("anogate/v1/g/up/fc-05/euler", rubbish);
    c.receive("anogate/v1/g/backlog/low", "no batch");
    c.receive("anogate/v1/g/status", "{}");
    EXPECT_EQ(c.collector.counts().invalid, 6u) << "an empty message has no line";
    EXPECT_FALSE(std::filesystem::exists(c.dir / "all/g"));
}

TEST(MqttCollector, after_a_restart_it_knows_what_it_has_and_removes_an_incomplete_line) {
    Collected c;
    c.receive("anogate/v1/g/up/fc-05/euler", line("g", "s", 1) + '\n' + line("g", "s", 2));
    std::filesystem::resize_file(c.dir / "all/g/2023-11-15.ndjson", 2 * line("g", "s", 1).size());
    Collector again{c.dir / "all", false};
    ASSERT_TRUE(again.open());
    EXPECT_EQ(c.text("g/2023-11-15.ndjson"), line("g", "s", 1) + '\n');
    BrokerMessage message;
    message.topic = "anogate/v1/g/up/fc-05/euler";
    for (const std::uint64_t seq : {1u, 2u}) {
        message.payload = line("g", "s", seq);
        ASSERT_TRUE(again.receive(message, noon));
    }
    EXPECT_EQ(c.text("g/2023-11-15.ndjson"), line("g", "s", 1) + '\n' + line("g", "s", 2) + '\n');
}

}    // namespace
}    // namespace collector_tests
