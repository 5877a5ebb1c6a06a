// Values to be written into parameters, and whether they can be.
#include <anoctl/anoctl.hpp>
#include <anoctl/device/parameter_assignments.hpp>
#include <anoctl/device/typed_value.hpp>

#include <support/thrown.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace anoctl::parameter_assignments_tests {
namespace {

using ano::Json;

const Json described{{{"id", 0}, {"name", "PID_P"}, {"type", "f32"}},
                     {{"id", 1}, {"name", "TURN"}, {"type", "i8"}},
                     {{"id", 2}, {"name", "NOTE"}, {"type", "text"}},
                     {{"id", 3}, {"name", "TWICE"}, {"type", "u8"}},
                     {{"id", 4}, {"name", "TWICE"}, {"type", "u8"}},
                     {{"id", 5}, {"name", "STRANGE"}, {"type", nullptr}},
                     {{"id", 6}, {"missing", true}}};

using support::thrown;

TEST(ParameterAssignments, are_one_name_and_value_or_several_name_value_pairs) {
    const auto one = assignments({"TURN", "-5"});
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(one[0].value, "-5");
    const auto two = assignments({"TURN=1", "NOTE=a=b"});
    ASSERT_EQ(two.size(), 2u);
    EXPECT_EQ(two[1].name, "NOTE");
    EXPECT_EQ(two[1].value, "a=b");
    for (const std::vector<std::string>& wrong : {std::vector<std::string>{}, {"TURN"}, {"=1"}, {"A=1", "B"}})
        EXPECT_THROW((void)assignments(wrong), UsageError);
}

TEST(ParameterAssignments, are_checked_before_anything_is_written) {
    const auto fault = [](std::vector<std::string> words) {
        return thrown<Failure>([&] { check(assignments(words), described); });
    };
    EXPECT_EQ(fault({"TURN=-128", "PID_P=1e3", "NOTE=x", "STRANGE=1", "3=255"}), "nothing was thrown");
    EXPECT_EQ(fault({"PID_P=1", "TRN=1"}), "no parameter is named 'TRN' (did you mean 'TURN'?)");
    EXPECT_EQ(fault({"TURN=128"}), "TURN: '128' is out of range, i8 is -128 to 127");
    EXPECT_EQ(fault({"TURN=1.5"}), "TURN: '1.5' is not whole, i8 is -128 to 127");
    EXPECT_EQ(fault({"TURN=high"}), "TURN: 'high' is not a number");
    EXPECT_EQ(fault({"PID_P=1e39"}), "PID_P: '1e39' is out of range, f32 is -3.4e38 to 3.4e38");
    EXPECT_EQ(fault({"PID_P=nan"}).find("PID_P: 'nan' is not a number"), 0u) << fault({"PID_P=nan"});
    EXPECT_EQ(fault({"TURN=1", "1=2"}), "TURN is given twice");
    EXPECT_EQ(fault({"TWICE=1"}), "several parameters are named 'TWICE'; use the number");
    EXPECT_NE(fault({"NOTE=\xFF"}).find(" is not UTF-8"), std::string::npos);
    EXPECT_EQ(fault({"9=1"}), "no parameter is named '9'");
}

TEST(TypedValue, has_the_range_of_its_type) {
    EXPECT_EQ(misfit_of("256", "u8"), "'256' is out of range, u8 is 0 to 255");
    EXPECT_EQ(misfit_of("18446744073709551615", "u64"), "");
    EXPECT_EQ(misfit_of("-1", "u64"), "'-1' is out of range, u64 is 0 to 18446744073709551615");
    EXPECT_EQ(misfit_of("0x10", "u8"), "");
    EXPECT_EQ(misfit_of("anything", "text"), "");
    EXPECT_EQ(misfit_of("anything", ""), "");
}

}    // namespace
}    // namespace anoctl::parameter_assignments_tests
