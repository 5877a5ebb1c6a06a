// Devices by their names, and what is said of them.
#include <anoctl/device/device_names.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

const Json devices{
    {{"address", "0xDC"}, {"name", "SimFC"}}, {{"address", "0xDD"}, {"name", "SIMFC"}}, {{"address", "0xDE"}, {"name", "Flow"}}};

TEST(DeviceNames, are_as_written_or_else_of_any_case) {
    EXPECT_EQ(with_name(devices, "SimFC").size(), 1u);
    EXPECT_EQ(with_name(devices, "simfc").size(), 2u) << "which one is meant is not known";
    ASSERT_EQ(with_name(devices, "FLOW").size(), 1u);
    EXPECT_EQ(with_name(devices, "FLOW")[0]["address"], "0xDE");
    EXPECT_TRUE(with_name(devices, "Flo").empty());
}

TEST(DeviceNames, what_was_left_behind_is_told) {
    EXPECT_TRUE(left_behind(devices[0]).empty());
    EXPECT_EQ(
        left_behind(Json{{"in_loader", true}, {"kept", {"calibration-0xDC-compass.json"}}}),
        (std::vector<std::string>{"an upgrade did not end: it was left in its loader, anoctl flash FILE gives it its firmware",
                                  "a calibration did not end: the old values are kept (calibration-0xDC-compass.json) and "
                                  "written back when that can be done"}));
}

}    // namespace
}    // namespace anoctl
