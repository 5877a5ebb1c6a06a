#include <ros/standard_types.hpp>
#include <ros2/type_hash.hpp>

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace type_hash_tests {
namespace {

using namespace anogate;

// As published with ROS 2 Jazzy; of some only the beginning is known.
TEST(TypeHash, equals_the_published_ones) {
    const auto& t = standard_types();
    const std::vector<std::pair<const RosMessage*, const char*>> published{
        {t.imu, "RIHS01_7d9a00ff"},
        {t.quaternion_stamped, "RIHS01_381add86"},
        {t.magnetic_field, "RIHS01_e80f32f5"},
        {t.temperature, "RIHS01_72514a14"},
        {t.vector3_stamped, "RIHS01_d4829622"},
        {t.point_stamped, "RIHS01_4c0296af"},
        {t.point_cloud, "RIHS01_9198cabf"},
        {t.range, "RIHS01_b42b6256"},
        {t.image, "RIHS01_d31d41a9"},
        {t.twist, "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"},
        {t.string, "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
        {t.log, "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac"},
        {t.joy, "RIHS01_0d356c79cad3401e35ffeb75a96a96e08be3ef896b8b83841d73e890989372c5"},
        {t.diagnostic_array, "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
        {t.odometry, "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
        {t.tf_message, "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    };
    for (const auto& [type, hash] : published)
        EXPECT_EQ(type_hash(*type).substr(0, std::string{hash}.size()), hash) << type->name;
    for (const RosMessage* type : {t.nav_sat_fix, t.battery_state})
        EXPECT_EQ(type_hash(*type).size(), std::string{"RIHS01_"}.size() + 64);
}

TEST(TypeHash, types_have_the_names_of_dds) { EXPECT_EQ(dds_type_name(*standard_types().imu), "sensor_msgs::msg::dds_::Imu_"); }

}    // namespace
}    // namespace type_hash_tests
