#include <ros/standard_types.hpp>
#include <ros2/type_hash.hpp>

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace type_hash_tests {
namespace {

using namespace anogate;

// As published with ROS 2 Jazzy (share/PACKAGE/msg/TYPE.json).
TEST(TypeHash, equals_the_published_ones) {
    const auto& t = standard_types();
    const std::vector<std::pair<const RosMessage*, const char*>> published{
        {t.imu, "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"},
        {t.quaternion_stamped, "RIHS01_381add86c6c3160644d228ca342182c7fd6c7fab11c7a85ad817a9cc22dbac6e"},
        {t.magnetic_field, "RIHS01_e80f32f56a20486c9923008fc1a1db07bbb273cbbf6a5b3bfa00835ee00e4dff"},
        {t.temperature, "RIHS01_72514a14126ab9f8a9abec974c78e5610a367b59db5da355ff1fb982d5bad4b8"},
        {t.vector3_stamped, "RIHS01_d4829622288cbb443886e7ea94ea5671a3b1be6bab4ad04224432a65f7d7887a"},
        {t.point_stamped, "RIHS01_4c0296af86e01e562e9e0405d138a01537247580076c58ea38d7923ac1045897"},
        {t.point_cloud, "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
        {t.range, "RIHS01_b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a"},
        {t.image, "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"},
        {t.nav_sat_fix, "RIHS01_62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404"},
        {t.battery_state, "RIHS01_4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"},
        {t.twist, "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"},
        {t.string, "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
        {t.log, "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac"},
        {t.joy, "RIHS01_0d356c79cad3401e35ffeb75a96a96e08be3ef896b8b83841d73e890989372c5"},
        {t.diagnostic_array, "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
        {t.odometry, "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
        {t.tf_message, "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    };
    for (const auto& [type, hash] : published) EXPECT_EQ(type_hash(*type), hash) << type->name;
}

TEST(TypeHash, types_have_the_names_of_dds) { EXPECT_EQ(dds_type_name(*standard_types().imu), "sensor_msgs::msg::dds_::Imu_"); }

}    // namespace
}    // namespace type_hash_tests
