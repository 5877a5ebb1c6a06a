#include <http/client/connect_fault.hpp>

#include <gtest/gtest.h>
#include <support/temp_dir.hpp>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>

namespace anogate::http::connect_fault_tests {
namespace {

const std::string path = "/run/anogate/control.sock";

SocketFile of_the_service() {
    SocketFile file;
    file.is_there = file.is_socket = file.is_for_group = true;
    file.owner = "anogate";
    file.group = "anogate";
    return file;
}

TEST(ConnectFault, reports_that_no_gateway_is_running) {
    EXPECT_EQ(connect_fault(path, ENOENT, {}),
              "no gateway is running at /run/anogate/control.sock: socket not found (another one: --control PATH)");
    SocketFile sought;
    sought.no_runtime_dir = true;
    EXPECT_EQ(connect_fault(path, ENOENT, sought),
              "no gateway is running at /run/anogate/control.sock: socket not found; XDG_RUNTIME_DIR is not set, so a gateway of "
              "this user can't be found (another one: --control PATH)");
    sought = {};
    sought.nor = path;
    EXPECT_EQ(connect_fault("/run/user/1000/anogate.sock", ENOENT, sought),
              "no gateway is running at /run/user/1000/anogate.sock: socket not found, nor /run/anogate/control.sock "
              "(another one: --control PATH)");
    EXPECT_EQ(connect_fault(path, ECONNREFUSED, of_the_service()),
              "no gateway is running at /run/anogate/control.sock: the socket is left from a stopped one");
}

TEST(ConnectFault, without_permission_shows_how_to_get_it) {
    SocketFile file = of_the_service();
    EXPECT_EQ(connect_fault(path, EACCES, file),
              "no permission for /run/anogate/control.sock: it belongs to group anogate; "
              "sudo usermod -aG anogate $USER, then log in again");
    file.lists_us = true;
    EXPECT_EQ(connect_fault(path, EACCES, file),
              "no permission for /run/anogate/control.sock: it belongs to group anogate, which you join at your next login: log "
              "in again");
    file.group = "root";
    EXPECT_EQ(connect_fault(path, EACCES, file),
              "no permission for /run/anogate/control.sock: it belongs to group root: sudo anoctl ...");
    file.is_for_group = false;
    file.owner = "li";
    EXPECT_EQ(connect_fault(path, EACCES, file),
              "no permission for /run/anogate/control.sock: only user li has access: run sudo -u li anoctl ...");
    file.can_be_seen = false;
    EXPECT_EQ(connect_fault(path, EACCES, file),
              "no permission for /run/anogate/control.sock: this user has no access to its folder: sudo anoctl ...");
}

TEST(ConnectFault, reports_a_file_or_program_that_is_not_a_gateway) {
    SocketFile file = of_the_service();
    EXPECT_EQ(connect_fault(path, EPROTOTYPE, file), "the program at /run/anogate/control.sock is not a gateway");
    file.is_socket = false;
    EXPECT_EQ(connect_fault(path, ECONNREFUSED, file), "/run/anogate/control.sock is not a socket");
}

TEST(ConnectFault, inspects_the_file_at_the_socket_path) {
    const support::TempDir dir;
    EXPECT_FALSE(look_at_socket(dir / "none").is_there);
    EXPECT_FALSE(look_at_socket(dir.write("file", "")).is_socket);

    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = dir / "socket";
    name.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    for (const unsigned mode : {0600u, 0660u}) {
        ASSERT_EQ(::chmod(name.c_str(), mode), 0);
        const SocketFile file = look_at_socket(name);
        EXPECT_TRUE(file.is_there && file.is_socket && file.can_be_seen);
        EXPECT_EQ(file.is_for_group, mode == 0660u);
        EXPECT_NE(file.owner, "");
        EXPECT_NE(file.group, "");
    }
    ::close(fd);
}

}    // namespace
}    // namespace anogate::http::connect_fault_tests
