// Machines of their own for the network: namespaces joined by veth, made with iproute2 and gone with the test.
#pragma once
#include <fcntl.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace support {

/// False: the command failed.
inline bool run_ip(const std::string& arguments) { return std::system(("ip " + arguments + " >/dev/null 2>&1").c_str()) == 0; }

class Namespace {
public:
    Namespace() {
        static int count = 0;
        name_ = "anogate-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
        if (!run_ip("netns add " + name_)) throw std::runtime_error{"no network namespace"};
        fd_ = ::open(("/run/netns/" + name_).c_str(), O_RDONLY | O_CLOEXEC);
        ip("link set lo up");
    }
    ~Namespace() {
        ::close(fd_);
        run_ip("netns del " + name_);
    }
    Namespace(const Namespace&) = delete;
    Namespace& operator=(const Namespace&) = delete;

    const std::string& name() const { return name_; }
    int fd() const { return fd_; }
    void ip(const std::string& arguments) const {
        if (!run_ip("-n " + name_ + " " + arguments)) throw std::runtime_error{"ip " + arguments + " failed"};
    }
    /// Joins `name` here with `name` there; an address for each, as 10.0.0.1/24.
    void join(const Namespace& other, const std::string& link, const std::string& here, const std::string& there) const {
        ip("link add " + link + " type veth peer name " + link + " netns " + other.name_);
        ip("address add " + here + " dev " + link);
        other.ip("address add " + there + " dev " + link);
        ip("link set " + link + " up");
        other.ip("link set " + link + " up");
    }

private:
    std::string name_;
    int fd_ = -1;
};

/// This thread is in the namespace as long as this lives; the sockets it opens stay there.
class Inside {
public:
    explicit Inside(const Namespace& space) : home_{::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)} {
        if (home_ < 0 || ::setns(space.fd(), CLONE_NEWNET) != 0) throw std::runtime_error{"can't enter the namespace"};
    }
    ~Inside() {
        if (::setns(home_, CLONE_NEWNET) != 0) std::abort();
        ::close(home_);
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

private:
    int home_;
};

/// Why there can be none here; empty: there can.
inline std::string no_namespaces() {
    if (::getuid() != 0) return "network namespaces need root";
    if (!run_ip("-V")) return "network namespaces need the command ip (Debian package iproute2)";
    try {
        Namespace a, b;
        a.join(b, "try0", "10.0.0.1/24", "10.0.0.2/24");
        const Inside inside{a};
    } catch (const std::exception& error) {
        return std::string{"network namespaces can't be made here: "} + error.what();
    }
    return {};
}

}    // namespace support
