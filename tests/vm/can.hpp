// CAN links on a kernel that has SocketCAN, with can-utils as the other side. The tests run in their own network namespace on
// machines with CAN: on such a host, and in the machine of tests/vm/machine.
#pragma once
#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace anogate::vm {

using namespace std::chrono_literals;
using support::Bytes;
using Frames = std::vector<Bytes>;
using support::frame;
using support::Loop;
using support::run;
using support::RunningGateway;
using support::Shell;
using support::UdpPeer;

inline bool have_vcan() {
    static const bool have = [] {
        if (::unshare(CLONE_NEWNET | CLONE_NEWNS) != 0) return false;
        // /sys shows the interfaces of the namespace in which it was mounted.
        if (run("mount --make-rprivate / && mount -t sysfs sysfs /sys") != 0) return false;
        return run("ip link set lo up") == 0 && run("ip link add dev vcan0 type vcan 2>/dev/null") == 0 &&
               run("ip link del vcan0") == 0;
    }();
    return have;
}

inline std::string hex(std::span<const std::uint8_t> bytes) {
    std::string text;
    char digits[3];
    for (const std::uint8_t byte : bytes) text += (std::snprintf(digits, sizeof digits, "%02X", byte), digits);
    return text;
}

/// "6DC#AB…" in the notation of can-utils.
inline std::string words(const CanCutter::Piece& piece, const CanSettings& can) {
    Bytes data(piece.bytes.begin(), piece.bytes.end());
    data.resize(piece.size);
    char id[16];
    std::snprintf(id, sizeof id, can.extended ? "%08X" : "%03X", piece.id);
    return id + std::string{can.fd ? "##1" : "#"} + hex(data);
}

inline std::vector<std::string> cut(const Bytes& frame, const CanSettings& can) {
    CanCutter cutter{can};
    const std::span<const std::uint8_t> waiting = frame;
    std::vector<std::string> all;
    for (const auto& piece : cutter.cut({&waiting, 1})) all.push_back(words(piece, can));
    return all;
}

inline double cpu_seconds(int whose) {
    rusage usage{};
    ::getrusage(whose, &usage);
    const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

inline Bytes data_of(std::size_t size, std::uint8_t first = 1) {
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(first + i);
    return data;
}

// A raw socket on the bus, faster than any program.
class BusSocket {
public:
    explicit BusSocket(const char* interface) : fd_{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)} {
        const int on = 1;
        ::setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
        sockaddr_can address{};
        address.can_family = AF_CAN;
        address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
        EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    ~BusSocket() { ::close(fd_); }
    void send(const Bytes& frame, const CanSettings& can = {}, std::size_t leave_out = SIZE_MAX) {
        const std::span<const std::uint8_t> waiting = frame;
        const auto pieces = cutter(can).cut({&waiting, 1});
        for (std::size_t i = 0; i < pieces.size(); ++i)
            if (i != leave_out) put(pieces[i], can);
    }
    void put(const CanCutter::Piece& piece, const CanSettings& can) {
        canfd_frame out{};
        out.can_id = piece.id | (can.extended ? CAN_EFF_FLAG : 0);
        out.len = piece.size;
        std::copy(piece.bytes.begin(), piece.bytes.end(), out.data);
        if (::write(fd_, &out, can.fd ? CANFD_MTU : CAN_MTU) < 0) FAIL() << "write: " << errno;
    }

private:
    static CanCutter& cutter(const CanSettings& can) {
        static CanCutter cutter{can};
        return cutter = CanCutter{can};
    }
    int fd_;
};

struct Can : testing::Test {
    static void SetUpTestSuite() { have_vcan(); }    // enters the namespace, before a socket is made
    void SetUp() override {
        if (!have_vcan()) {
            if (std::getenv("ANOGATE_IN_VM")) FAIL() << "no vcan in the test machine";
            GTEST_SKIP() << "this kernel has no vcan, or we may not make one; tests/vm/run runs it in a machine that has";
        }
        make_bus();
    }
    void TearDown() override {
        if (have_vcan()) run("ip link del vcan0 2>/dev/null");
    }
    static void make_bus() { ASSERT_EQ(run("ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 up"), 0); }

    /// Starts candump; it receives frames when this returns.
    std::unique_ptr<Shell> dump(const std::string& options = "-L vcan0") {
        const auto listeners = [] {
            std::ifstream list{"/proc/self/net/can/rcvlist_all"};
            std::size_t lines = 0;
            for (std::string line; std::getline(list, line);) ++lines;
            return lines;
        };
        const std::size_t before = listeners();
        auto process = std::make_unique<Shell>("candump " + options);
        EXPECT_TRUE(loop.until([&] { return listeners() > before; }));
        return process;
    }
    /// The output of candump -L for the next `count` frames, without their times.
    std::vector<std::string> dumped(Shell& dump, std::size_t count) {
        std::string text;
        loop.until([&] {
            text += dump.new_output();
            return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) >= count;
        });
        std::vector<std::string> all;
        std::istringstream lines{text};
        for (std::string time, interface, what; lines >> time >> interface >> what;) all.push_back(what);
        return all;
    }
    std::vector<Bytes> received(UdpPeer& from, std::size_t count, std::chrono::seconds patience = 30s) {
        std::vector<Bytes> all;
        loop.until(
            [&] {
                for (Bytes& one : from.frames()) all.push_back(std::move(one));
                return all.size() >= count;
            },
            patience);
        return all;
    }

    Loop loop;
    UdpPeer app;
};

}    // namespace anogate::vm
