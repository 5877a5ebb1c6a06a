#include <link/tcp/tcp_socket.hpp>

#include <gtest/gtest.h>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace tcp_socket_tests {
namespace {

using namespace std::chrono_literals;

struct TcpOptions : testing::Test {
    int option(int level, int name) const {
        int value = -1;
        socklen_t size = sizeof value;
        ::getsockopt(fd.get(), level, name, &value, &size);
        return value;
    }
    const anogate::UniqueFd fd{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
};

TEST_F(TcpOptions, send_small_frames_at_once_and_limit_what_waits_in_the_kernel) {
    anogate::set_tcp_options(fd.get(), 10s);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_NODELAY), 1);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_NOTSENT_LOWAT), 4096);
    EXPECT_EQ(option(SOL_SOCKET, SO_SNDBUF), 64 * 1024) << "with the kernel's own data";
}

TEST_F(TcpOptions, end_a_silent_connection_after_the_time_that_is_set) {
    anogate::set_tcp_options(fd.get(), 10s);
    EXPECT_EQ(option(SOL_SOCKET, SO_KEEPALIVE), 1);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPIDLE), 5);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPINTVL), 2);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_USER_TIMEOUT), 10'000);
}

TEST_F(TcpOptions, probe_as_rarely_as_the_kernel_allows_for_a_long_time) {
    anogate::set_tcp_options(fd.get(), 24h);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPIDLE), 32767);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_KEEPINTVL), 17280);
    EXPECT_EQ(option(IPPROTO_TCP, TCP_USER_TIMEOUT), 86'400'000);
}

}    // namespace
}    // namespace tcp_socket_tests
