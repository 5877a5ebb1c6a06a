#include <gtest/gtest.h>
#include <ano/typed.hpp>
#include <ros/cdr_encoder.hpp>
#include <ros/standard_messages.hpp>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/ros_definition.hpp>

namespace standard_messages_tests {
namespace {

using namespace anogate;
using support::Bytes;
using support::operator+;

constexpr std::uint64_t second = 1'000'000'000;

/// A device, and the last message of each of its topics, as shown by a program that has the definition.
struct HeardDevice {
    StandardMessages messages{"fc/device_5"};
    std::uint64_t now_ns = 1'700'000'000 * second + 7;
    std::vector<std::string> topics;    // of the last frame
    std::map<std::string, ano::Json> last;

    void receive(std::uint8_t id, const Bytes& data) {
        topics.clear();
        const ano::Reading reading = ano::read(id, data);
        ASSERT_TRUE(reading);
        CdrEncoder encoder;
        ValueList values;
        for (const StandardTopic topic : messages.receive(reading, now_ns)) {
            values.clear();
            messages.append_values(topic, values);
            const StandardRow& row = standard_row(topic);
            topics.emplace_back(row.name);
            last[std::string{row.name}] = support::decoded_cdr(definition_of(*row.type),
                                                               encoder.encode(*row.type, values.values()));
        }
    }
    const ano::Json& at(const std::string& topic) { return last.at(topic); }
};

void put(Bytes& data, std::int64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
        data.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
}
Bytes shorts(std::initializer_list<int> values) {
    Bytes data;
    for (const int value : values) put(data, value, 2);
    return data;
}
Bytes longs(std::initializer_list<std::int64_t> values) {
    Bytes data;
    for (const std::int64_t value : values) put(data, value, 4);
    return data;
}

void expect_vector(const ano::Json& v, double x, double y, double z) {
    EXPECT_NEAR(v["x"].get<double>(), x, 1e-9);
    EXPECT_NEAR(v["y"].get<double>(), y, 1e-9);
    EXPECT_NEAR(v["z"].get<double>(), z, 1e-9);
}
void expect_rotation(const ano::Json& q, double w, double x, double y, double z) {
    EXPECT_NEAR(q["w"].get<double>(), w, 1e-9);
    expect_vector(q, x, y, z);
}

const Bytes inertial = shorts({100, -200, 981, 16384, -8192, 0}) + Bytes{0};
const double half = std::sqrt(0.5);

TEST(StandardMessages, an_imu_is_in_metres_and_radians) {
    HeardDevice device;
    device.receive(0x01, inertial);
    EXPECT_EQ(device.topics, std::vector<std::string>{"imu"});
    const ano::Json& imu = device.at("imu");
    EXPECT_EQ(imu["header"]["stamp"]["sec"], 1'700'000'000);
    EXPECT_EQ(imu["header"]["stamp"]["nanosec"], 7);
    EXPECT_EQ(imu["header"]["frame_id"], "fc/device_5");
    expect_vector(imu["linear_acceleration"], 1, -2, 9.81);
    expect_vector(imu["angular_velocity"], 1000 * std::numbers::pi / 180, -500 * std::numbers::pi / 180, 0);
    EXPECT_EQ(imu["linear_acceleration_covariance"][0], 0.0);
}

TEST(StandardMessages, an_imu_reports_that_its_orientation_is_unknown) {
    HeardDevice device;
    device.receive(0x01, inertial);
    EXPECT_EQ(device.at("imu")["orientation_covariance"][0], -1.0);
    expect_rotation(device.at("imu")["orientation"], 1, 0, 0, 0);
    device.receive(0x03, shorts({0, 0, 9000}) + Bytes{1});
    device.now_ns += second;
    device.receive(0x01, inertial);
    EXPECT_EQ(device.at("imu")["orientation_covariance"][0], 0.0);
    expect_rotation(device.at("imu")["orientation"], half, 0, 0, half);
    ++device.now_ns;
    device.receive(0x01, inertial);
    EXPECT_EQ(device.at("imu")["orientation_covariance"][0], -1.0);
}

TEST(StandardMessages, angles_turn_about_x_then_y_then_z) {
    HeardDevice device;
    const auto orientation = [&](int roll, int pitch, int yaw) {
        device.receive(0x03, shorts({roll, pitch, yaw}) + Bytes{1});
        EXPECT_EQ(device.topics, std::vector<std::string>{"orientation"});
        EXPECT_EQ(device.at("orientation")["header"]["frame_id"], "fc/device_5/odom");
        return device.at("orientation")["quaternion"];
    };
    expect_rotation(orientation(9000, 0, 0), half, half, 0, 0);
    expect_rotation(orientation(0, 9000, 0), half, 0, half, 0);
    expect_rotation(orientation(0, 0, -9000), half, 0, 0, -half);
    expect_rotation(orientation(9000, 0, 9000), 0.5, 0.5, 0.5, 0.5);
    expect_rotation(orientation(0, 9000, 9000), 0.5, -0.5, 0.5, 0.5);
}

TEST(StandardMessages, angles_with_a_mode_are_converted_alike) {
    HeardDevice device;
    device.receive(0x03, Bytes{1} + shorts({0, 0, -9000}) + Bytes{1});
    EXPECT_EQ(device.topics, std::vector<std::string>{"orientation"});
    expect_rotation(device.at("orientation")["quaternion"], half, 0, 0, -half);
}

TEST(StandardMessages, a_quaternion_is_preferred_to_angles) {
    HeardDevice device;
    device.receive(0x04, shorts({7071, 0, 0, -7071}) + Bytes{1});
    expect_rotation(device.at("orientation")["quaternion"], half, 0, 0, -half);
    device.receive(0x03, shorts({0, 0, 9000}) + Bytes{1});
    EXPECT_TRUE(device.topics.empty());
    device.receive(0x01, inertial);
    expect_rotation(device.at("imu")["orientation"], half, 0, 0, -half);
    device.now_ns += 2 * second;
    device.receive(0x03, shorts({0, 0, 9000}) + Bytes{1});
    expect_rotation(device.at("orientation")["quaternion"], half, 0, 0, half);
}

TEST(StandardMessages, invalid_quaternions_are_ignored) {
    HeardDevice device;
    device.receive(0x04, shorts({0, 0, 0, 0}) + Bytes{0});
    EXPECT_TRUE(device.topics.empty());
    device.receive(0x04, shorts({10000, 10000, 0, 0}) + Bytes{0});
    EXPECT_TRUE(device.topics.empty());
    device.receive(0x01, inertial);
    EXPECT_EQ(device.at("imu")["orientation_covariance"][0], -1.0);
}

TEST(StandardMessages, a_compass_is_a_field_in_tesla_and_a_temperature) {
    HeardDevice device;
    for (const Bytes& data : {shorts({300, 0, -400, 253}) + Bytes{1}, shorts({300, 0, -400, 5, 0, 253}) + Bytes{1, 1}}) {
        device.last.clear();
        device.receive(0x02, data);
        EXPECT_EQ(device.topics, (std::vector<std::string>{"magnetic_field", "temperature"}));
        expect_vector(device.at("magnetic_field")["magnetic_field"], 30e-6, 0, -40e-6);
        EXPECT_EQ(device.at("temperature")["temperature"], 25.3);
    }
}

TEST(StandardMessages, odometry_has_its_speed_along_the_axes_of_the_vehicle) {
    HeardDevice device;
    const Bytes position = longs({100, -250, 1000});
    device.receive(0x08, position);
    EXPECT_EQ(device.topics, std::vector<std::string>{"point"});
    expect_vector(device.at("point")["point"], 1, -2.5, 10);
    device.receive(0x03, shorts({0, 0, 9000}) + Bytes{1});    // the nose along y
    device.receive(0x07, shorts({0, 300, 50}));
    expect_vector(device.at("linear_velocity")["vector"], 0, 3, 0.5);
    device.receive(0x08, position);
    EXPECT_EQ(device.topics, (std::vector<std::string>{"point", "odometry"}));
    const ano::Json& odometry = device.at("odometry");
    EXPECT_EQ(odometry["header"]["frame_id"], "fc/device_5/odom");
    EXPECT_EQ(odometry["child_frame_id"], "fc/device_5");
    expect_vector(odometry["pose"]["pose"]["position"], 1, -2.5, 10);
    expect_rotation(odometry["pose"]["pose"]["orientation"], half, 0, 0, half);
    expect_vector(odometry["twist"]["twist"]["linear"], 3, 0, 0.5);
    for (const std::size_t i : {21u, 28u, 35u}) EXPECT_EQ(odometry["twist"]["covariance"][i], -1.0);
    EXPECT_EQ(odometry["twist"]["covariance"][0], 0.0);
    device.receive(0x01, inertial);
    device.receive(0x08, position);
    expect_vector(device.at("odometry")["twist"]["twist"]["angular"], 1000 * std::numbers::pi / 180,
                  -500 * std::numbers::pi / 180, 0);
    EXPECT_EQ(device.at("odometry")["twist"]["covariance"][21], 0.0);
}

TEST(StandardMessages, a_speed_is_rotated_back_about_all_axes) {
    HeardDevice device;
    device.receive(0x03, shorts({9000, 0, 9000}) + Bytes{1});    // the nose along y, its left side up
    device.receive(0x07, shorts({100, 200, 300}));
    device.receive(0x08, longs({0, 0, 0}));
    expect_vector(device.at("odometry")["twist"]["twist"]["linear"], 2, 3, 1);
}

TEST(StandardMessages, a_position_without_height_has_no_standard_message) {
    HeardDevice device;
    device.receive(0x08, longs({100, -250}));
    EXPECT_TRUE(device.topics.empty());
}

TEST(StandardMessages, a_discharging_battery_has_a_negative_current) {
    HeardDevice device;
    device.receive(0x0D, shorts({1234, 250}));
    const ano::Json battery = device.at("battery");
    EXPECT_NEAR(battery["voltage"].get<double>(), 12.34, 1e-6);
    EXPECT_EQ(battery["current"], -2.5);
    EXPECT_TRUE(battery["percentage"].is_null());
    EXPECT_TRUE(battery["temperature"].is_null());
    EXPECT_EQ(battery["power_supply_status"], 0);
    EXPECT_EQ(battery["present"], true);
    EXPECT_TRUE(battery["cell_voltage"].empty());
    EXPECT_EQ(battery["serial_number"], "");
    device.receive(0x0D, shorts({1234, 250, 500, 100, 0}));
    EXPECT_EQ(device.at("battery"), battery);
}

Bytes gps(std::uint8_t fix) {
    return Bytes{fix, 12} + longs({1213456789, -312345678, 12345}) + shorts({100, 200, -300}) + Bytes{2, 3, 4};
}

TEST(StandardMessages, a_fix_is_in_degrees_and_its_speed_to_the_east) {
    HeardDevice device;
    device.receive(0x30, gps(3));
    EXPECT_EQ(device.topics, (std::vector<std::string>{"fix", "fix_velocity"}));
    const ano::Json& fix = device.at("fix");
    EXPECT_EQ(fix["status"]["status"], 0);
    EXPECT_EQ(fix["status"]["service"], 0);
    EXPECT_EQ(fix["latitude"], -31.2345678);
    EXPECT_EQ(fix["longitude"], 121.3456789);
    EXPECT_NEAR(fix["altitude"].get<double>(), 123.45, 1e-9);
    EXPECT_EQ(fix["position_covariance_type"], 0);
    expect_vector(device.at("fix_velocity")["vector"], 2, 1, 3);
    EXPECT_EQ(device.at("fix_velocity")["header"]["frame_id"], "fc/device_5/enu");
}

TEST(StandardMessages, without_a_fix_there_is_no_position) {
    HeardDevice device;
    for (const std::uint8_t fix : Bytes{0, 1, 5, 255}) {
        device.receive(0x30, gps(fix));
        EXPECT_EQ(device.topics, std::vector<std::string>{"fix"}) << int{fix};
        EXPECT_EQ(device.at("fix")["status"]["status"], -1);
        for (const char* key : {"latitude", "longitude", "altitude"}) EXPECT_TRUE(device.at("fix")[key].is_null()) << key;
    }
    device.receive(0x30, gps(2));
    EXPECT_FALSE(device.at("fix")["latitude"].is_null());
    EXPECT_TRUE(device.at("fix")["altitude"].is_null());
}

TEST(StandardMessages, unknown_values_of_an_external_sensor_are_not_published) {
    HeardDevice device;
    device.receive(0x32, longs({1000, -2000, 3000}));
    expect_vector(device.at("external_point")["point"], 1, -2, 3);
    device.receive(0x33, shorts({100, -200, 300}));
    expect_vector(device.at("external_velocity")["vector"], 1, -2, 3);
    EXPECT_EQ(device.at("external_velocity")["header"]["frame_id"], "fc/device_5");
    device.receive(0x32, longs({1000, INT32_MIN, 3000}));
    EXPECT_TRUE(device.topics.empty());
    device.receive(0x33, shorts({100, -200, INT16_MIN}));
    EXPECT_TRUE(device.topics.empty());
}

TEST(StandardMessages, a_range_has_the_frame_of_its_direction) {
    HeardDevice device;
    const std::vector<std::string> names{"range_down",  "range_forward", "range_back", "range_left",
                                         "range_right", "range_up",      "range_down"};
    for (std::size_t type = 0; type < names.size(); ++type) {
        device.receive(0x34, Bytes{static_cast<std::uint8_t>(type)} + longs({1500}));
        ASSERT_EQ(device.topics, std::vector<std::string>{names[type]});
        EXPECT_EQ(device.at(names[type])["range"], 1.5);
        EXPECT_EQ(device.at(names[type])["header"]["frame_id"], "fc/device_5/" + names[type]);
    }
    device.receive(0x34, Bytes{1} + longs({-7}));
    EXPECT_TRUE(device.at("range_forward")["range"].is_null());
    device.receive(0x34, Bytes{1, 1, 2, 3, 4, 5, 6});
    EXPECT_TRUE(device.topics.empty());
}

TEST(StandardMessages, a_scan_is_ordered_clockwise) {
    HeardDevice device;
    device.receive(0x34, Bytes{100} + shorts({0, 250, 9000, 100, 18000, 0, 27000, 300}));    // ahead, right, none behind, left
    EXPECT_EQ(device.topics, std::vector<std::string>{"scan"});
    const ano::Json& scan = device.at("scan");
    EXPECT_EQ(scan["header"]["frame_id"], "fc/device_5");
    EXPECT_EQ(scan["width"], 3);
    EXPECT_EQ(scan["height"], 1);
    EXPECT_EQ(scan["point_step"], 12);
    EXPECT_EQ(scan["row_step"], 36);
    EXPECT_EQ(scan["fields"][1], (ano::Json{{"name", "y"}, {"offset", 4}, {"datatype", 7}, {"count", 1}}));
    const Bytes data = scan["data"].get<Bytes>();
    const std::vector<double> expected{2.5, 0, 0, 0, -1, 0, 0, 3, 0};
    ASSERT_EQ(data.size(), 4 * expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(ano::load<float>(data.data() + 4 * i), expected[i], 1e-6) << i;
    device.receive(0x34, Bytes{100});
    EXPECT_EQ(device.at("scan")["width"], 0);
}

TEST(StandardMessages, no_topic_has_the_name_of_a_message_of_the_table) {
    for (std::size_t i = 0; i < standard_topics; ++i)
        EXPECT_EQ(ano::find_message(standard_row(static_cast<StandardTopic>(i)).name), nullptr);
}

TEST(StandardMessages, a_time_beyond_2038_becomes_the_largest_time) {
    HeardDevice device;
    device.now_ns = UINT64_MAX;
    device.receive(0x0D, shorts({1, 2}));
    EXPECT_EQ(device.at("battery")["header"]["stamp"]["sec"], INT32_MAX);
}

}    // namespace
}    // namespace standard_messages_tests
