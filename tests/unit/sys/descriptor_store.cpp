#include <support/child.hpp>
#include <sys/descriptor_store.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace anogate::descriptor_store_tests {
namespace {

constexpr int passed = 3;

/// The way in which systemd starts a process: one descriptor, and the process that it is for in the environment.
void pass_one(pid_t to) {
    const int fd = ::open("/dev/null", O_RDONLY);
    if (fd != passed) ::dup2(fd, passed);
    ::fcntl(passed, F_SETFD, 0);
    ::unsetenv("NOTIFY_SOCKET");
    ::setenv("LISTEN_PID", std::to_string(to).c_str(), 1);
    ::setenv("LISTEN_FDS", "1", 1);
    ::setenv("LISTEN_FDNAMES", "wire", 1);
}

bool environment_is_clean() {
    for (const char* variable : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"})
        if (std::getenv(variable)) return false;
    return true;
}

TEST(DescriptorStore, returns_descriptors_passed_to_this_process) {
    EXPECT_EQ(support::Child{[] {
                  pass_one(::getpid());
                  const auto taken = receive_descriptors();
                  if (taken.size() != 1 || taken[0].first != "wire" || taken[0].second.get() != passed) return 1;
                  return ::fcntl(passed, F_GETFD) == FD_CLOEXEC && environment_is_clean() ? 0 : 2;
              }}.wait(),
              0);
}

TEST(DescriptorStore, ignores_descriptors_passed_to_another_process) {
    EXPECT_EQ(support::Child{[] {
                  pass_one(::getppid());
                  if (!receive_descriptors().empty()) return 1;
                  return ::fcntl(passed, F_GETFD) == 0 && environment_is_clean() ? 0 : 2;
              }}.wait(),
              0);
}

}    // namespace
}    // namespace anogate::descriptor_store_tests
