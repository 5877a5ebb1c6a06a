// The network namespaces made by tests are removed when they end.
#include <support/namespaces.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

namespace namespaces_tests {
namespace {

using namespace support;

std::set<std::string> named_namespaces() {
    std::set<std::string> names;
    std::error_code ec;
    for (const auto& entry : std::filesystem::directory_iterator{"/run/netns", ec}) names.insert(entry.path().filename());
    return names;
}

/// Restores $PATH in its destructor.
class Path {
public:
    explicit Path(const std::string& path) : before_{std::getenv("PATH")} { ::setenv("PATH", path.c_str(), 1); }
    ~Path() { ::setenv("PATH", before_.c_str(), 1); }
    Path(const Path&) = delete;
    Path& operator=(const Path&) = delete;

private:
    std::string before_;
};

TEST(Namespaces, are_removed_when_ip_fails) {
    ANOGATE_NEEDS_NAMESPACES();
    const auto before = named_namespaces();
    const TempDir dir;
    // A program `ip` that supports everything except bringing a link up.
    std::ofstream{dir / "ip"} << "#!/bin/sh\ncase \"$*\" in *\" up\") exit 1;; esac\nPATH=${PATH#*:} exec ip \"$@\"\n";
    std::filesystem::permissions(dir / "ip", std::filesystem::perms::owner_all);
    const auto home = std::filesystem::read_symlink("/proc/thread-self/ns/net");
    const Path path{dir.path().string() + ":" + std::getenv("PATH")};
    EXPECT_THROW(Namespace{}, std::runtime_error);
    EXPECT_EQ(std::filesystem::read_symlink("/proc/thread-self/ns/net"), home);
    EXPECT_THROW(NetworkNamespace{}, std::runtime_error);
    EXPECT_EQ(std::filesystem::read_symlink("/proc/thread-self/ns/net"), home);
    EXPECT_EQ(named_namespaces(), before);
}

TEST(Namespaces, have_no_name_that_a_killed_test_could_leave_behind) {
    ANOGATE_NEEDS_NAMESPACES();
    const auto before = named_namespaces();
    const Namespace a, b;
    a.join(b, "x0", "10.0.0.1/24", "10.0.0.2/24");
    EXPECT_EQ(named_namespaces(), before);
}

}    // namespace
}    // namespace namespaces_tests
