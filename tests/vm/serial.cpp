// Serial links on real drivers: a USB port of dummy_hcd and g_serial that is plugged in and unplugged, and two 16550 UARTs
// connected as a null modem. Needs the machine of tests/vm/machine, or an equivalent one.
#include <support/child.hpp>
#include <support/files.hpp>
#include <support/line_rate.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <termios.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

namespace serial_tests {

using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::Loop;
using support::run;
using support::RunningGateway;
using support::UdpPeer;

namespace {

bool in_vm() { return std::getenv("ANOGATE_IN_VM") != nullptr; }

Bytes data_of(std::size_t size, std::uint8_t first) {
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(first + i);
    return data;
}

// The far end of a serial line, as the firmware of a device uses it.
class Device {
public:
    explicit Device(const std::string& path, speed_t rate = B115200) : fd_{::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)} {
        termios line{};
        ::tcgetattr(fd_, &line);
        ::cfmakeraw(&line);
        ::cfsetspeed(&line, rate);
        ::tcsetattr(fd_, TCSANOW, &line);
    }
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device() { ::close(fd_); }
    int fd() const { return fd_; }
    void send(const Bytes& bytes) {
        if (::write(fd_, bytes.data(), bytes.size()) < 0) ++failed_;
    }
    std::vector<Bytes> frames() {
        std::vector<Bytes> all;
        for (;;) {
            const auto room = parser_.prepare();
            const ssize_t n = ::read(fd_, room.data(), room.size());
            if (n <= 0) return all;
            parser_.commit(static_cast<std::size_t>(n), ano::Clock::now());
            while (const auto f = parser_.next()) all.emplace_back(f->bytes().begin(), f->bytes().end());
        }
    }

private:
    int fd_;
    int failed_ = 0;
    ano::FrameParser parser_{ano::FrameParser::Options{}};
};

struct Serial : testing::Test {
    std::size_t received(Device& from, std::size_t count) {
        std::size_t n = 0;
        loop.until([&] { return (n += from.frames().size()) >= count; });
        return n;
    }
    std::size_t received(UdpPeer& from, std::size_t count) {
        std::size_t n = 0;
        loop.until([&] { return (n += from.frames().size()) >= count; });
        return n;
    }
    Loop loop;
    UdpPeer app;
};

TEST_F(Serial, a_usb_port_is_plugged_and_pulled_ten_times_under_traffic) {
    if (!in_vm()) GTEST_SKIP() << "loads and unloads kernel modules: only in tests/vm/machine";
    ASSERT_EQ(run("modprobe dummy_hcd && modprobe cdc-acm"), 0);
    UdpPeer other;
    RunningGateway gateway{loop, {"serial:/dev/ttyACM0", app.link("app"), other.link("other")}};
    EXPECT_EQ(gateway.link("ttyACM0")["state"], "waiting");
    const std::uint16_t to = gateway.port("app");
    for (std::uint8_t turn = 0; turn < 10; ++turn) {
        ASSERT_EQ(run("modprobe g_serial"), 0);
        ASSERT_TRUE(loop.until([&] { return std::filesystem::exists("/dev/ttyGS0") && gateway.up("ttyACM0"); }))
            << int{turn} << gateway.link("ttyACM0");
        {
            Device device{"/dev/ttyGS0"};
            ASSERT_GE(device.fd(), 0);
            device.send(frame(0xDC, 0xFE, 0x03, data_of(20, turn)));
            EXPECT_GE(received(app, 1), 1u) << int{turn};
            std::size_t got = 0;
            for (std::uint8_t n = 0; n < 20; ++n) app.send(to, frame(0xFE, 0xDC, 0xE1, data_of(20, n)));
            EXPECT_GE(got += received(device, 20), 20u) << int{turn};
            for (std::uint8_t n = 0; n < 50; ++n) {    // the port is unplugged during this
                device.send(frame(0xDC, 0xFE, 0x03, data_of(20, n)));
                app.send(to, frame(0xFE, 0xDC, 0xE1, data_of(20, n)));
            }
            loop.turn();
        }
        ASSERT_EQ(run("modprobe -r g_serial"), 0);
        ASSERT_TRUE(loop.until([&] { return !gateway.up("ttyACM0"); }));
        app.frames();
        other.send(gateway.port("other"), frame(5, 0xFE, 0x03));
        EXPECT_GE(received(app, 1), 1u) << "the other links go on";
    }
    const auto link = gateway.link("ttyACM0");
    EXPECT_GE(link["frames_in"], 10);
    EXPECT_GE(link["frames_out"], 200);
}

TEST_F(Serial, two_uarts_exchange_frames_at_usual_and_odd_baud_rates) {
    if (!in_vm()) GTEST_SKIP() << "needs two UARTs joined: only in tests/vm/machine";
    for (const std::string baud : {"115200", "500000", "57600", "123456", "9600"}) {
        UdpPeer far;
        RunningGateway a{loop, {"serial:/dev/ttyS1,baud=" + baud, app.link("app")}};
        RunningGateway b{loop, {"serial:/dev/ttyS2,baud=" + baud, far.link("app")}};
        ASSERT_TRUE(a.up("ttyS1") && b.up("ttyS2")) << baud << a.link("ttyS1")["error"] << b.link("ttyS2")["error"];
        for (std::uint8_t n = 0; n < 30; ++n) app.send(a.port("app"), frame(0xFE, 0xFF, 0xE1, data_of(50, n)));
        EXPECT_EQ(received(far, 30), 30u) << baud;
        EXPECT_EQ(b.count("ttyS2", "skipped_bytes"), 0u) << baud;
    }
}

/// The bytes that a UART at the rate `read` makes of bytes sent at the rate `sent`: it samples each bit in its middle.
Bytes as_read(const Bytes& bytes, double sent, double read) {
    std::vector<bool> line(20, true);
    for (const std::uint8_t byte : bytes) {
        line.push_back(false);
        for (int bit = 0; bit < 8; ++bit) line.push_back((byte >> bit & 1) != 0);
        line.push_back(true);
    }
    line.insert(line.end(), 20, true);
    const double step = sent / read;    // a bit of the reader, in bits of the sender
    const auto level = [&](double at) { return line.at(std::min(static_cast<std::size_t>(at), line.size() - 1)); };
    Bytes all;
    for (double at = 1; at < static_cast<double>(line.size()) - 1; at += 0.05) {
        if (level(at)) continue;
        unsigned byte = 0;
        for (int bit = 0; bit < 8; ++bit) byte |= unsigned{level(at + step * (1.5 + bit))} << bit;
        all.push_back(static_cast<std::uint8_t>(byte));
        at += step * 9.5;
    }
    return all;
}

/// A device that sends frames at its rate on /dev/ttyS2 until it is destroyed. QEMU's UARTs have no rates, so it sends what
/// /dev/ttyS1 would read at the rate that is set there.
class DeviceAtRate {
public:
    explicit DeviceAtRate(std::uint32_t rate)
        : far_{::open("/dev/ttyS1", O_RDWR | O_NOCTTY | O_NONBLOCK)}, thread_{[this, rate] {
              Device device{"/dev/ttyS2"};
              const Bytes sent = frame(0xDC, 0xFE, 0x03, data_of(7, 0x7B));
              for (; !over_; std::this_thread::sleep_for(20ms)) {
                  device.send(as_read(sent, rate, support::rate_of(far_)));
                  ::tcdrain(device.fd());    // bytes for an earlier rate must not wait
              }
          }} {}
    ~DeviceAtRate() {
        over_ = true;
        thread_.join();
        ::close(far_);
    }

private:
    int far_;
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

/// The first link that `anoctl setup` writes for a port.
nlohmann::json link_of_setup(const std::string& port) {
    const support::TempDir dir;
    const std::string config = dir / "anogate.json", systemctl = dir.write("systemctl", "#!/bin/sh\n");
    std::filesystem::permissions(systemctl, std::filesystem::perms{0700});
    support::Process setup{ANOCTL, {"setup", "--into", config, port, "--yes"}, {"PATH=" + dir.path().string()}};
    EXPECT_EQ(setup.wait(), 0) << setup.output();
    support::Process check{ANOGATED, {"--check", "--config", config}};
    EXPECT_EQ(check.wait(), 0) << check.output();
    return nlohmann::json::parse(support::file_text(config), nullptr, true, true).at("links").at(0);
}

TEST_F(Serial, setup_finds_the_rate_of_a_device_on_a_uart) {
    if (!in_vm()) GTEST_SKIP() << "needs two UARTs joined: only in tests/vm/machine";
    for (const std::uint32_t rate : {115200u, 57600u, 9600u}) {
        const DeviceAtRate device{rate};
        EXPECT_EQ(link_of_setup("/dev/ttyS1").at("baud"), rate);
        EXPECT_EQ(link_of_setup("/dev/ttyS1").at("baud"), rate) << "the driver keeps the rate instead of one that it can't set";
    }
}

TEST_F(Serial, setup_needs_no_rate_for_a_usb_device) {
    if (!in_vm()) GTEST_SKIP() << "loads and unloads kernel modules: only in tests/vm/machine";
    ASSERT_EQ(run("modprobe dummy_hcd && modprobe cdc-acm && modprobe g_serial"), 0);
    ASSERT_TRUE(loop.until([] { return std::filesystem::exists("/dev/ttyGS0") && std::filesystem::exists("/dev/ttyACM0"); }));
    {
        std::atomic<bool> over = false;
        std::thread sender{[&] {
            Device device{"/dev/ttyGS0"};
            for (; !over; std::this_thread::sleep_for(20ms)) device.send(frame(0xDC, 0xFE, 0x03, data_of(7, 0x7B)));
        }};
        const auto link = link_of_setup("/dev/ttyACM0");
        over = true;
        sender.join();
        EXPECT_FALSE(link.contains("baud")) << link;
        EXPECT_EQ(link.at("profile"), "vendor");
    }
    ASSERT_EQ(run("modprobe -r g_serial"), 0);
}

TEST_F(Serial, a_command_overtakes_frames_that_a_slow_line_has_not_sent_yet) {
    if (!in_vm()) GTEST_SKIP() << "needs two UARTs joined: only in tests/vm/machine";
    UdpPeer far;
    RunningGateway a{loop, {"serial:/dev/ttyS1,baud=9600", app.link("app")}};
    RunningGateway b{loop, {"serial:/dev/ttyS2,baud=9600", far.link("app")}};
    for (std::uint8_t n = 0; n < 40; ++n) app.send(a.port("app"), frame(0xFE, 0xFF, 0xB0, data_of(50, n)));
    ASSERT_TRUE(loop.until([&] { return a.count("ttyS1", "waiting") > 30; })) << "the driver would take 4096 bytes at once";
    EXPECT_EQ(a.count("ttyS1", "paced"), 960u);
    app.send(a.port("app"), frame(0xFE, 0xFF, 0xC0, data_of(11, 0)));
    std::size_t images = 0;
    const auto commanded = [&] {
        for (const Bytes& f : far.frames())
            if (f[3] == 0xC0) return true;
            else ++images;
        return false;
    };
    EXPECT_TRUE(loop.until(commanded));
    EXPECT_LE(images, 10u) << "of 40";
}

TEST_F(Serial, modem_lines_are_set_as_configured) {
    if (!in_vm()) GTEST_SKIP() << "needs a UART: only in tests/vm/machine";
    for (const bool on : {true, false}) {
        const std::string word = on ? "true" : "false";
        RunningGateway gateway{loop, {"serial:/dev/ttyS1,baud=115200,dtr=" + word + ",rts=" + word}};
        ASSERT_TRUE(gateway.up("ttyS1")) << gateway.link("ttyS1")["error"];
        std::ifstream ports{"/proc/tty/driver/serial"};    // opening the port would increase them
        std::string port;
        while (std::getline(ports, port) && !port.starts_with("1:")) {}
        EXPECT_EQ(port.find("DTR") != port.npos, on) << port;
        EXPECT_EQ(port.find("RTS") != port.npos, on) << port;
    }
}

TEST_F(Serial, other_users_can_open_a_port_only_after_the_gateway_has_ended) {
    if (!in_vm()) GTEST_SKIP() << "needs a UART: only in tests/vm/machine";
    ASSERT_EQ(run("chmod 666 /dev/ttyS1"), 0);
    const auto open_as_nobody = [] {
        return support::Child{[] {
                   if (!support::become_nobody()) return 1;
                   return ::open("/dev/ttyS1", O_RDWR | O_NOCTTY | O_NONBLOCK) >= 0 ? 0 : errno;
               }}
            .wait();
    };
    int ready[2];
    ASSERT_EQ(::pipe(ready), 0);
    support::Child killed{[&] {
        Loop own;
        RunningGateway gateway{own, {"serial:/dev/ttyS1,baud=115200"}};
        return gateway.up("ttyS1") && ::write(ready[1], "", 1) == 1 ? ::pause() : 1;
    }};
    ::close(ready[1]);
    char byte;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    EXPECT_EQ(open_as_nobody(), EBUSY);
    ::kill(killed.pid(), SIGKILL);
    killed.wait();
    EXPECT_EQ(open_as_nobody(), 0);
    ::close(ready[0]);
}

}    // namespace
}    // namespace serial_tests
