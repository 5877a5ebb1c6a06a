// Serial links on real drivers: a USB port of dummy_hcd and g_serial that is plugged in and unplugged, and two 16550 UARTs
// connected as a null modem. Needs the machine of tests/vm/machine, or an equivalent one.
#include <support/child.hpp>
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <termios.h>

#include <filesystem>
#include <fstream>

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
