// A network of the test's own: its interfaces and addresses are not those of the machine.
#pragma once
#include <fcntl.h>
#include <sched.h>
#include <unistd.h>
#include <cstdlib>
#include <string>

namespace support {

/// The calling thread, and every socket and process it makes, is inside until the destructor. Needs root and the program `ip`.
class NetworkNamespace {
public:
    NetworkNamespace() : before_{::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)} {
        made_ = before_ >= 0 && ::unshare(CLONE_NEWNET) == 0 && run("link set lo up");
    }
    ~NetworkNamespace() {
        if (before_ < 0) return;
        if (::setns(before_, CLONE_NEWNET) != 0) std::abort();
        ::close(before_);
    }
    NetworkNamespace(const NetworkNamespace&) = delete;
    NetworkNamespace& operator=(const NetworkNamespace&) = delete;

    explicit operator bool() const { return made_; }
    /// `ip ARGUMENTS`
    bool run(const std::string& arguments) const { return std::system(("ip " + arguments + " 2>/dev/null").c_str()) == 0; }

private:
    int before_;
    bool made_ = false;
};

}    // namespace support

#define ANOGATE_NEEDS_NETWORK(network) \
    if (!network) GTEST_SKIP() << "needs a network namespace of its own: run as root, with iproute2 installed"
