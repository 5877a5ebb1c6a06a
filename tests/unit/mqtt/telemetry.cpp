#include <mqtt/batch.hpp>
#include <mqtt/mqtt_config.hpp>
#include <mqtt/telemetry.hpp>

#include <ano_json/frame_json.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <sstream>
#include <string>

namespace telemetry_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using Json = nlohmann::json;

constexpr std::uint8_t euler_id = 0x03, log_id = 0xA0;
constexpr std::uint64_t ms = 1'000'000;

MqttSettings configured(const std::string& json) {
    MqttSettings settings;
    ConfigErrors errors;
    read_mqtt_config(json, "", settings, errors);
    EXPECT_TRUE(errors.empty()) << (errors.empty() ? "" : errors.front().where + ": " + errors.front().what);
    return settings;
}

struct Published {
    explicit Published(const std::string& json = "{}") : settings{configured(json)} {}

    MqttSettings settings;
    Telemetry telemetry{settings, "g", "s"};
    std::uint64_t boottime_ns = 5'000'000'000;

    std::optional<Record> receive(std::uint8_t source, std::uint8_t id, const Bytes& data, std::string_view link = "fc") {
        const Bytes bytes = support::frame(source, 0xFE, id, data);
        return telemetry.receive(
            link, {.time_ns = 1'700'000'000'123'456'789, .boottime_ns = boottime_ns, .frame = ano::FrameView{bytes}}, {});
    }
    /// Euler angles, of which `roll` is in hundredths of a degree.
    std::optional<Record> angles(std::uint8_t roll) { return receive(5, euler_id, {roll, 0, 0, 0, 0, 0, 1}); }
    /// The number of records of frames every `step` for 10 s.
    int count(std::chrono::milliseconds step) {
        int count = 0;
        for (auto time = 0ms; time < 10s; time += step, boottime_ns += static_cast<std::uint64_t>(step.count()) * ms)
            count += angles(1) ? 1 : 0;
        return count;
    }
};

TEST(MqttTelemetry, a_record_has_its_identity_its_times_and_the_whole_frame) {
    Published published;
    const auto record = published.angles(123);
    ASSERT_TRUE(record);
    EXPECT_EQ(record->topic, "anogate/v1/g/up/fc-05/euler");
    Json json = Json::parse(record->json);
    EXPECT_EQ(json["gateway"], "g");
    EXPECT_EQ(json["stream"], "s");
    EXPECT_EQ(json["seq"], 1);
    EXPECT_EQ(json["time"], 1700000000.123456);
    EXPECT_EQ(json["boottime"], 5.0);
    EXPECT_EQ(json["link"], "fc");
    EXPECT_EQ(json["device"], "fc-05");
    EXPECT_EQ(json["name"], "euler");
    EXPECT_EQ(json["fields"]["rol"], 1.23);
    EXPECT_EQ(record->seq, 1u);
    EXPECT_EQ(published.telemetry.devices().size(), 1u);
}

TEST(MqttTelemetry, the_rate_is_limited_for_each_message_of_each_device) {
    EXPECT_EQ(Published{}.count(10ms), 11);    // one per second, and the second one after half a second
    EXPECT_EQ(Published{R"({"messages": [{"message": "euler", "rate": 5}]})"}.count(10ms), 51);
    EXPECT_EQ(Published{R"({"messages": [{"message": "*", "rate": 0}]})"}.count(10ms), 1000);
    EXPECT_EQ(Published{R"({"messages": [{"message": "*", "rate": 0.1}]})"}.count(10ms), 2);
    EXPECT_EQ(Published{R"({"messages": [{"message": "euler", "publish": false}]})"}.count(10ms), 0);

    Published two;
    EXPECT_TRUE(two.receive(5, euler_id, Bytes(7)));
    EXPECT_TRUE(two.receive(6, euler_id, Bytes(7)));
    EXPECT_TRUE(two.receive(5, euler_id, Bytes(7), "other"));
    EXPECT_FALSE(two.receive(5, euler_id, Bytes(7)));
}

TEST(MqttTelemetry, jitter_below_half_a_period_costs_no_message) {
    Published published{R"({"messages": [{"message": "*", "rate": 10}]})"};
    for (std::uint64_t i = 0; i < 100; ++i) {
        published.boottime_ns = 5'000'000'000 + i * 100 * ms + (i * 7919 % 90) * ms / 2;
        EXPECT_TRUE(published.angles(1)) << i;
    }
}

TEST(MqttTelemetry, logs_are_not_limited_and_are_dropped_last) {
    Published published;
    for (int i = 0; i < 20; ++i) {
        const auto record = published.receive(5, log_id, {0, 'h', 'i'});
        ASSERT_TRUE(record);
        EXPECT_EQ(record->keep, Keep::high);
    }
}

TEST(MqttTelemetry, a_message_with_a_threshold_is_published_after_a_change_and_once_a_minute) {
    Published published{R"({"messages": [{"message": "euler", "rate": 0, "change": 0.5}]})"};
    EXPECT_TRUE(published.angles(0));
    published.boottime_ns += 1000 * ms;
    EXPECT_FALSE(published.angles(0));
    EXPECT_FALSE(published.angles(49)) << "0.49 degrees";
    EXPECT_TRUE(published.angles(50));
    EXPECT_FALSE(published.angles(99)) << "compared with the last published value";
    EXPECT_TRUE(published.angles(100));
    published.boottime_ns += 60'000 * ms;
    EXPECT_TRUE(published.angles(100));
}

TEST(MqttTelemetry, hosts_and_forged_senders_are_not_published) {
    Published published;
    EXPECT_FALSE(published.receive(0xFE, euler_id, Bytes(7)));
    const Bytes bytes = support::frame(5, 0xFE, euler_id, Bytes(7));
    FrameRecord frame{.frame = ano::FrameView{bytes}};
    frame.is_elsewhere = true;
    EXPECT_FALSE(published.telemetry.receive("fc", frame, {}));
    EXPECT_EQ(published.telemetry.last_seq(), 0u);
}

TEST(MqttTelemetry, a_frame_without_a_known_layout_has_its_data) {
    Published published;
    const auto record = published.receive(5, 0x7F, {1, 2, 3});
    ASSERT_TRUE(record);
    EXPECT_EQ(record->topic, "anogate/v1/g/up/fc-05/0x7F");
    EXPECT_EQ(Json::parse(record->json)["data"], "010203");
}

TEST(MqttTelemetry, memory_for_devices_is_bounded) {
    Published published;
    std::size_t count = 0;
    for (int link = 0; link < 3; ++link)
        for (int source = 1; source < 0xD0; ++source)
            for (int id = 0; id < 0x40; ++id)
                count += published.receive(static_cast<std::uint8_t>(source), static_cast<std::uint8_t>(id), {},
                                           "link" + std::to_string(link))
                             ? 1u
                             : 0u;
    EXPECT_LE(count, Telemetry::max_limits);
}

TEST(MqttBatch, batches_of_a_class_have_all_records_in_order_and_fit_a_message) {
    Published published{R"({"messages": [{"message": "*", "rate": 0}]})"};
    std::vector<Record> records;
    std::string expected;
    for (int i = 0; i < 2000; ++i) {
        records.push_back(*published.angles(static_cast<std::uint8_t>(i)));
        if (i % 10 == 0) records.back().keep = Keep::high;
        else expected += records.back().json + '\n';
    }
    BatchPacker packer;
    BatchUnpacker unpacker;
    std::string normal;
    std::uint64_t count = 0, bytes = 0;
    for (const Batch& batch : packer.pack(records)) {
        EXPECT_LE(batch.body.size(), max_payload);
        count += batch.records;
        bytes += batch.body.size();
        const auto lines = unpacker.unpack(batch.body);
        ASSERT_TRUE(lines);
        if (batch.keep == Keep::normal) normal += *lines;
    }
    EXPECT_EQ(normal, expected);
    EXPECT_EQ(count, 2000u);
    EXPECT_LT(bytes, expected.size() / 6);
}

TEST(MqttBatch, even_noise_fits_a_message_and_a_damaged_batch_is_refused) {
    BatchPacker packer;
    BatchUnpacker unpacker;
    std::string noise(BatchPacker::max_lines - 1, ' ');
    std::uint32_t state = 1;
    for (char& c : noise) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
    const auto batches = packer.pack(std::vector{Record{1, Keep::low, {}, 0, "", noise}});
    ASSERT_EQ(batches.size(), 1u);
    EXPECT_LE(batches[0].body.size(), max_payload);
    EXPECT_TRUE(packer.pack(std::vector{Record{1, Keep::low, {}, 0, "", noise + "xy"}}).empty());
    EXPECT_TRUE(unpacker.unpack(batches[0].body));
    EXPECT_FALSE(unpacker.unpack(std::string_view{batches[0].body}.substr(0, 1000)));
    EXPECT_FALSE(unpacker.unpack("no batch"));
    EXPECT_FALSE(unpacker.unpack(""));
}

}    // namespace
}    // namespace telemetry_tests
