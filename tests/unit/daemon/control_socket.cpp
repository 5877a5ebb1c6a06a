#include <daemon/control_socket.hpp>

#include <gtest/gtest.h>

namespace anogate {
namespace {

constexpr char system_wide[] = "/run/anogate/control.sock";

TEST(ControlSocket, is_where_the_settings_say) {
    EXPECT_EQ(control_socket({"/tmp/x.sock"}, {true, ""}), "/tmp/x.sock");
    EXPECT_EQ(control_socket({"/tmp/x.sock"}, {false, "/run/user/1000"}), "/tmp/x.sock");
    EXPECT_EQ(control_socket({"none"}, {true, ""}), std::nullopt);
}

TEST(ControlSocket, of_the_system_is_in_run) {
    EXPECT_EQ(control_socket({}, {true, ""}), system_wide);
    EXPECT_EQ(control_socket({}, {true, "/run/user/0"}), system_wide);
}

TEST(ControlSocket, of_a_user_is_in_the_runtime_folder) {
    EXPECT_EQ(control_socket({}, {false, "/run/user/1000"}), "/run/user/1000/anogate.sock");
}

TEST(ControlSocket, of_a_user_without_a_runtime_folder_is_the_one_whose_error_tells_why) {
    EXPECT_EQ(control_socket({}, {false, ""}), system_wide);
}

}  // namespace
}  // namespace anogate
