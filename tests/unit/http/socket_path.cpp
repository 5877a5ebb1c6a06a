#include <http/socket_path.hpp>
#include <sys/files/own_folder.hpp>

#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

namespace anogate::http::socket_path_tests {
namespace {

constexpr char system_wide[] = "/run/anogate/control.sock";

TEST(SocketPath, is_the_path_in_the_settings) {
    EXPECT_EQ(control_socket("/tmp/x.sock", {true, ""}), "/tmp/x.sock");
    EXPECT_EQ(control_socket("/tmp/x.sock", {false, "/run/user/1000"}), "/tmp/x.sock");
    EXPECT_EQ(control_socket("none", {true, ""}), std::nullopt);
}

TEST(SocketPath, of_the_system_is_in_run) {
    EXPECT_EQ(control_socket("", {true, ""}), system_wide);
    EXPECT_EQ(control_socket("", {true, "/run/user/0"}), system_wide);
}

TEST(SocketPath, of_a_user_is_in_the_runtime_folder) {
    EXPECT_EQ(control_socket("", {false, "/run/user/1000"}), "/run/user/1000/anogate.sock");
}

TEST(SocketPath, of_a_user_without_a_runtime_folder_is_the_path_of_the_system) {
    EXPECT_EQ(control_socket("", {false, ""}), system_wide);
}

TEST(SocketPath, of_a_client_is_that_of_a_gateway_of_the_same_user) {
    const support::TempDir folder;
    const std::string own = folder.write("anogate.sock", "");
    EXPECT_EQ(socket_to_ask("", {false, folder.path().string()}), own);
    EXPECT_EQ(socket_to_ask("/tmp/x.sock", {false, folder.path().string()}), "/tmp/x.sock");
    EXPECT_EQ(socket_to_ask("", {true, folder.path().string()}), system_wide);
}

TEST(SocketPath, may_create_only_folders_of_the_gateway) {
    for (const char* own : {"/run/anogate", "/run/anogate/more", "/run/anogate-left", "/run/anogate-left/x", "/var/log/anogate",
                            "/run/user/1000", "/run/user/1000/anogate"})
        EXPECT_TRUE(is_own_folder(own, "/run/user/1000")) << own;
    for (const char* other :
         {"/run/anogate-left/../x", "/run/user/1000/anogaet", "/run/anogaet", "/run", "/tmp/anogate", "/run/anogate/../x", "."})
        EXPECT_FALSE(is_own_folder(other, "/run/user/1000")) << other;
    EXPECT_FALSE(is_own_folder("/run/user/1000", ""));
}

TEST(SocketPath, that_cannot_be_used_is_reported) {
    const support::TempDir folder;
    const std::string here = folder.path().string();
    const Runner runner{true, here + "/xdg"};
    const std::string instead = " (use --control with another path, or --control none)";
    EXPECT_EQ(fault_of_socket(here + "/c.sock", runner), "");
    EXPECT_EQ(fault_of_socket(here + "/absent/c.sock", runner),
              here + "/absent/c.sock: there is no folder " + here + "/absent" + instead);
    EXPECT_EQ(fault_of_socket(here + "/xdg/c.sock", runner), "") << "made when it is needed";
    EXPECT_EQ(fault_of_socket(here + "/xdg/anogaet/c.sock", runner),
              here + "/xdg/anogaet/c.sock: there is no folder " + here + "/xdg/anogaet" + instead);
    const std::string file = folder.write("file", "precious");
    EXPECT_EQ(fault_of_socket(file, runner), file + ": exists and is not a socket" + instead);
    EXPECT_EQ(fault_of_socket(here, runner), here + ": exists and is not a socket" + instead);
    EXPECT_EQ(fault_of_socket(file + "/c.sock", runner), file + "/c.sock: Not a directory" + instead);
    if (::geteuid() == 0) return;
    EXPECT_EQ(fault_of_socket("/etc/c.sock", runner), "/etc/c.sock: Permission denied" + instead);
}

}    // namespace
}    // namespace anogate::http::socket_path_tests
