// Devices by their names, and the messages about them.
#include <anoctl/device/device_names.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace anoctl::device_names_tests {
namespace {

using ano::Json;

const Json devices{
    {{"address", "0xDC"}, {"name", "SimFC"}}, {{"address", "0xDD"}, {"name", "SIMFC"}}, {{"address", "0xDE"}, {"name", "Flow"}}};

TEST(DeviceNames, match_exactly_first_and_then_in_any_case) {
    EXPECT_EQ(with_name(devices, "SimFC").size(), 1u);
    EXPECT_EQ(with_name(devices, "simfc").size(), 2u) << "which one is meant is not known";
    ASSERT_EQ(with_name(devices, "FLOW").size(), 1u);
    EXPECT_EQ(with_name(devices, "FLOW")[0]["address"], "0xDE");
    EXPECT_TRUE(with_name(devices, "Flo").empty());
}

TEST(DeviceNames, unknown_names_are_reported_with_the_known_devices) {
    EXPECT_EQ(no_such_device("Flwo", devices),
              "no device 'Flwo' responded (did you mean 'Flow'?); devices: 0xDC SimFC, 0xDD SIMFC, 0xDE Flow");
    EXPECT_EQ(no_such_device("Nobody", Json::array({devices[2]})), "no device 'Nobody' responded; devices: 0xDE Flow");
    EXPECT_EQ(no_such_device("Nobody", Json::array()), "no device 'Nobody' responded; no devices known");
}

TEST(DeviceNames, precede_the_address_at_the_beginning_of_a_message) {
    EXPECT_EQ(with_device_named("0xDC is unlocked", devices[0]), "SimFC (0xDC) is unlocked");
    EXPECT_EQ(with_device_named("0xDE is unlocked", devices[0]), "0xDE is unlocked");
    EXPECT_EQ(with_device_named("0xDC is unlocked", Json{{"address", "0xDC"}}), "0xDC is unlocked");
    EXPECT_EQ(with_device_named("nothing was written", Json{}), "nothing was written");
}

TEST(DeviceNames, interrupted_updates_and_calibrations_are_reported) {
    EXPECT_TRUE(left_behind(devices[0]).empty());
    EXPECT_EQ(left_behind(Json{{"in_loader", true}, {"kept", {"calibration-0xDC-compass.json"}}}),
              (std::vector<std::string>{
                  "a firmware update was interrupted; the device is still in its loader. Flash it again: anoctl flash FILE",
                  "a calibration was interrupted; its old values are kept (calibration-0xDC-compass.json) and will be restored "
                  "when possible"}));
    EXPECT_EQ(
        left_behind(Json{{"dropped", {"calibration-0xDC-compass.json (removed: the device has other calibration values)"}}}),
        (std::vector<std::string>{"a calibration was interrupted and its old values were not restored: "
                                  "calibration-0xDC-compass.json (removed: the device has other calibration values)"}));
}

}    // namespace
}    // namespace anoctl::device_names_tests
