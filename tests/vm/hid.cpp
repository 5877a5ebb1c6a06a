// Links to HID devices: the kernel's own uhid lets this test be the device. Needs the machine of tests/vm/machine, or an equivalent one.
#include <support/process.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>
#include <sys/unique_fd.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/uhid.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace hid_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::Loop;
using support::run;
using support::RunningGateway;
using support::UdpPeer;

// A page of the vendor's own, 64 bytes each way.
const Bytes stream_descriptor{0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,
                              0x95, 0x40, 0x09, 0x02, 0x81, 0x02, 0x95, 0x40, 0x09, 0x03, 0x91, 0x02, 0xC0};
// One byte from the device, nothing to it.
const Bytes button_descriptor{0x05, 0x09, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x25,
                              0x01, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xC0};

class HidDevice {
public:
    explicit HidDevice(const Bytes& descriptor = stream_descriptor, std::uint16_t product = 0xA005)
        : fd_{::open("/dev/uhid", O_RDWR | O_CLOEXEC | O_NONBLOCK)} {
        uhid_event event{};
        event.type = UHID_CREATE2;
        std::strcpy(reinterpret_cast<char*>(event.u.create2.name), "ANO Radio");
        std::copy(descriptor.begin(), descriptor.end(), event.u.create2.rd_data);
        event.u.create2.rd_size = static_cast<__u16>(descriptor.size());
        event.u.create2.bus = 3;    // BUS_USB
        event.u.create2.vendor = 0x0483;
        event.u.create2.product = product;
        write(event);
    }
    bool is_there() const { return fd_ && failed_ == 0; }
    void send_report(const Bytes& report) {
        uhid_event event{};
        event.type = UHID_INPUT2;
        event.u.input2.size = static_cast<__u16>(report.size());
        std::copy(report.begin(), report.end(), event.u.input2.data);
        write(event);
    }
    /// As the vendor's firmware: up to 63 bytes in each report.
    void send(const Bytes& stream) {
        for (std::size_t at = 0; at < stream.size(); at += 63) {
            const std::size_t size = std::min<std::size_t>(63, stream.size() - at);
            Bytes report(64, 0x55);
            report[0] = static_cast<std::uint8_t>(size);
            std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), size, report.begin() + 1);
            send_report(report);
        }
    }
    /// The bytes received so far.
    const Bytes& heard() {
        for (uhid_event event{}; ::read(fd_.get(), &event, sizeof event) > 0;) {
            if (event.type != UHID_OUTPUT) continue;
            const std::uint8_t* const report = event.u.output.data;    // begins with the number 0
            EXPECT_EQ(event.u.output.size, 65);
            EXPECT_LE(report[1], 32);
            heard_.insert(heard_.end(), report + 2, report + 2 + report[1]);
        }
        return heard_;
    }

private:
    void write(const uhid_event& event) {
        if (::write(fd_.get(), &event, sizeof event) != sizeof event) ++failed_;
    }

    anogate::UniqueFd fd_;
    int failed_ = 0;
    Bytes heard_;
};

Bytes data_of(std::size_t size, std::uint8_t first) {
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(first + i);
    return data;
}

class Hid : public testing::Test {
protected:
    void SetUp() override {
        if (std::getenv("ANOGATE_IN_VM") == nullptr) GTEST_SKIP() << "needs the kernel's uhid: only in tests/vm/machine";
        ASSERT_EQ(run("modprobe -a uhid hid-generic"), 0);
    }
    std::size_t frames_at_app(std::size_t count) {
        std::size_t received = 0;
        loop.until([&] { return (received += app.frames().size()) >= count; });
        return received;
    }
    Loop loop;
    UdpPeer app;
};

TEST_F(Hid, a_device_is_found_by_its_id_each_time_it_is_plugged_in) {
    RunningGateway gateway{loop, {"hid:0483:A005,name=radio", app.link("app")}};
    EXPECT_EQ(gateway.link("radio")["state"], "waiting");
    EXPECT_EQ(gateway.link("radio")["error_id"], "absent");
    for (std::uint8_t turn = 0; turn < 5; ++turn) {
        HidDevice other{stream_descriptor, 0xA006};    // changes the number of the device
        HidDevice device;
        ASSERT_TRUE(device.is_there());
        ASSERT_TRUE(loop.until([&] { return gateway.up("radio"); })) << int{turn} << gateway.link("radio");
        Bytes stream;
        for (std::uint8_t n = 0; n < 20; ++n) {
            const Bytes one = frame(0xDC, 0xFE, 0x03, data_of(100, n));
            stream.insert(stream.end(), one.begin(), one.end());
        }
        device.send(stream);
        EXPECT_EQ(frames_at_app(20), 20u) << int{turn};
        Bytes wanted;
        for (std::uint8_t n = 0; n < 20; ++n) {
            const Bytes one = frame(0xFE, 0xDC, 0xE1, data_of(20, n));
            wanted.insert(wanted.end(), one.begin(), one.end());
            app.send(gateway.port("app"), one);
        }
        EXPECT_TRUE(loop.until([&] { return device.heard().size() >= wanted.size(); })) << int{turn};
        EXPECT_EQ(device.heard(), wanted) << int{turn};
        if (turn == 4) break;
        device = HidDevice{button_descriptor};    // unplugged, and a button with the same id plugged in
        ASSERT_TRUE(loop.until([&] { return !gateway.up("radio"); })) << int{turn};
    }
}

TEST_F(Hid, devices_that_carry_no_stream_and_damaged_reports_are_named) {
    HidDevice button{button_descriptor};
    RunningGateway gateway{loop, {"hid:/dev/hidraw0,name=button", "hid:0483:A005,name=radio", app.link("app")}};
    EXPECT_TRUE(loop.until([&] { return gateway.link("button")["error_id"] == "unusable"; })) << gateway.link("button");
    EXPECT_EQ(gateway.link("radio")["error_id"], "absent") << gateway.link("radio");
    {
        HidDevice first;
        ASSERT_TRUE(loop.until([&] { return gateway.up("radio"); })) << gateway.link("radio");
        first.send_report(Bytes(64, 0xFF));
        first.send(frame(0xDC, 0xFE, 0x03, data_of(30, 1)));
        EXPECT_EQ(frames_at_app(1), 1u);
        EXPECT_EQ(gateway.link("radio")["bad_reports"], 1) << gateway.link("radio");
    }
    ASSERT_TRUE(loop.until([&] { return !gateway.up("radio"); }));
    HidDevice one, two;
    EXPECT_TRUE(loop.until([&] { return gateway.link("radio")["error_id"] == "unusable"; })) << gateway.link("radio");
}

TEST_F(Hid, a_v7_device_is_a_device_of_the_gateway) {
    RunningGateway gateway{loop, {"hid:0483:A005,name=fc,protocol=v7,v7_device=0xDB", app.link("app")}};
    HidDevice device;
    ASSERT_TRUE(loop.until([&] { return gateway.up("fc"); })) << gateway.link("fc");
    device.send({0xAA, 0xFF, 0x03, 0x07, 0x10, 0x00, 0x20, 0x00, 0x30, 0x00, 0x00, 0x13, 0x37});
    EXPECT_TRUE(loop.until([&] { return gateway.count("fc", "frames_in") == 1; })) << gateway.link("fc");
}

}    // namespace
}    // namespace hid_tests
