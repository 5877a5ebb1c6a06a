// The file of a parameter export: its content, and what is left out.
#include <anoctl/device/parameter_file.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace anoctl::parameter_file_tests {
namespace {

using ano::Json;

TEST(ParameterFile, leaves_out_unreadable_parameters) {
    const Json rows{{{"id", 0}, {"name", "ALT"}, {"type", "u8"}, {"unreadable", "4 bytes for u8"}},
                    {{"id", 1}, {"name", "KP"}, {"type", "f32"}, {"value", 1.5}},
                    {{"id", 2}, {"name", "ALT"}, {"type", "f32"}, {"unreadable", "8 bytes for f32"}}};
    const Json file = parameter_file({{"device", {{"address", "0xDC"}}}, {"parameters", rows}});
    EXPECT_EQ(file["parameters"], (Json{{"KP", 1.5}}));
    EXPECT_EQ(names_not_readable(rows), "ALT#0 (4 bytes for u8), ALT#2 (8 bytes for f32)");
}

}    // namespace
}    // namespace anoctl::parameter_file_tests
