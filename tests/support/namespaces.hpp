// Network namespaces that simulate machines, connected by veth. They are made with iproute2 and disappear when the test ends in
// any way.
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

/// While this object exists, the thread is in the namespace of `fd`; sockets and processes that it creates stay there.
class Inside {
public:
    explicit Inside(int fd) : home_{::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC)} {
        if (home_ >= 0 && ::setns(fd, CLONE_NEWNET) == 0) return;
        if (home_ >= 0) ::close(home_);
        throw std::runtime_error{"can't enter the namespace"};
    }
    template <class Space>
    explicit Inside(const Space& space) : Inside{space.fd()} {}
    ~Inside() {
        if (::setns(home_, CLONE_NEWNET) != 0) std::abort();
        ::close(home_);
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

private:
    int home_;
};

/// A namespace without a name: only our descriptor holds it, so it never outlives the test.
class Namespace {
public:
    Namespace() : fd_{make()} { ip("link set lo up"); }

    int fd() const { return fd_.number; }
    void ip(const std::string& arguments) const {
        if (!run(arguments)) throw std::runtime_error{"ip " + arguments + " failed"};
    }
    bool run(const std::string& arguments) const {    // false: the command failed
        const Inside inside{*this};
        return run_ip(arguments);
    }
    /// Connects the two namespaces by interfaces called `link`; `here`, `there`: the address of each, like 10.0.0.1/24.
    void join(const Namespace& other, const std::string& link, const std::string& here, const std::string& there) const {
        const std::string its_file = "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(other.fd());
        ip("link add " + link + " type veth peer name " + link + " netns " + its_file);
        ip("address add " + here + " dev " + link);
        other.ip("address add " + there + " dev " + link);
        ip("link set " + link + " up");
        other.ip("link set " + link + " up");
    }

private:
    struct Descriptor {
        explicit Descriptor(int fd) : number{fd} {}
        ~Descriptor() { ::close(number); }
        Descriptor(const Descriptor&) = delete;
        Descriptor& operator=(const Descriptor&) = delete;
        int number;
    };

    static int make() {
        const int home = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
        if (home < 0 || ::unshare(CLONE_NEWNET) != 0) {
            if (home >= 0) ::close(home);
            throw std::runtime_error{"no network namespace"};
        }
        const int fd = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
        if (::setns(home, CLONE_NEWNET) != 0) std::abort();
        ::close(home);
        if (fd < 0) throw std::runtime_error{"no network namespace"};
        return fd;
    }

    Descriptor fd_;
};

/// A private network of the test: its thread is inside as long as this object exists.
class NetworkNamespace : public Namespace {
    Inside inside_{*this};
};

/// The reason why namespaces are not possible here; empty: they are possible.
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

#define ANOGATE_NEEDS_NAMESPACES() \
    if (const std::string reason = support::no_namespaces(); !reason.empty()) GTEST_SKIP() << reason
