#include <gtest/gtest.h>
#include <anoctl/ports/can_figures.hpp>
#include <anoctl/ports/port_list.hpp>
#include <anoctl/ports/ports.hpp>
#include <link/serial/port_identity.hpp>
#include <nlohmann/json.hpp>

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/files.hpp>
#include <support/temp_dir.hpp>

namespace ports_tests {
namespace {

namespace fs = std::filesystem;
using Asker = anogate::DeviceUser;
using anoctl::Holder;

/// The /sys, /proc, /dev and /etc of a computer, as far as serial ports need them.
class Computer {
public:
    const fs::path& root() const { return folder_.path(); }

    void file(const std::string& path, const std::string& text) {
        fs::create_directories((root() / path).parent_path());
        folder_.write(path, text + "\n");
    }
    void link(const std::string& path, const std::string& target) {
        fs::create_directories((root() / path).parent_path());
        fs::create_symlink(target, root() / path);
    }
    /// A port `name` whose folder in sysfs is `device`, below sys/devices.
    void port(const std::string& name, const std::string& device, const std::string& driver) {
        const fs::path at = "sys/devices/" + device;
        fs::create_directories(root() / at);
        fs::create_directories(root() / "sys/class/tty" / name);
        fs::create_symlink(root() / at, root() / "sys/class/tty" / name / "device");
        if (!driver.empty()) link(at / "driver", "../../bus/drivers/" + driver);
        file("dev/" + name, "");
        fs::permissions(root() / "dev" / name, fs::perms{0660});
    }
    void usb(const std::string& name, const std::string& device, const std::string& driver, const std::string& product) {
        port(name, device + "/1-1:1.0/" + name, driver);
        file("sys/devices/" + device + "/idVendor", "1a86");
        file("sys/devices/" + device + "/idProduct", "7523");
        file("sys/devices/" + device + "/product", product);
    }
    void process(int pid, const std::string& program, const std::string& opened = {}) {
        const std::string at = "proc/" + std::to_string(pid);
        file(at + "/comm", program);
        if (!opened.empty()) link(at + "/fd/5", opened);
    }
    /// The notation of a file in /proc/locks.
    std::string inode(const std::string& path) const {
        struct stat s {};
        ::stat((root() / path).c_str(), &s);
        char text[64];
        std::snprintf(text, sizeof text, "%02x:%02x:%lu", major(s.st_dev), minor(s.st_dev), static_cast<unsigned long>(s.st_ino));
        return text;
    }
    gid_t group_of(const std::string& path) const {
        struct stat s {};
        ::stat((root() / path).c_str(), &s);
        return s.st_gid;
    }
    std::string shown(const Asker& asker, bool json = false) const {
        std::ostringstream out;
        anoctl::write_ports(root(), asker, json, out);
        return out.str();
    }

private:
    support::TempDir folder_;
};

const Asker administrator{0, "root", {}};

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in{text};
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

TEST(Ports, are_shown_with_driver_product_and_stable_name) {
    Computer computer;
    computer.usb("ttyUSB10", "usb1/1-2", "cp210x", "CP2102N");
    computer.usb("ttyUSB2", "usb1/1-1", "ch341-uart", "USB Serial");
    computer.link("dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0", "../../ttyUSB2");
    computer.link("dev/serial/by-id/usb-1a86_USB_Serial-if00-port0", "../../ttyUSB2");
    computer.link("dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0", "../../ttyUSB10");
    computer.file("sys/devices/usb1/1-1/serial", "7A21");
    computer.file("sys/devices/usb1/1-2/serial", "7A22");
    EXPECT_EQ(computer.shown(administrator),
              "/dev/ttyUSB2 ch341-uart USB Serial (1a86:7523)\n"
              "    /dev/serial/by-id/usb-1a86_USB_Serial-if00-port0\n"
              "/dev/ttyUSB10 cp210x CP2102N (1a86:7523)\n"
              "    /dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0\n"
              "no CAN interface found\n");
}

// Two CH340: udev gives both the same name, which belongs to the one plugged in last.
TEST(Ports, of_adapters_without_a_serial_number_are_named_by_their_usb_port) {
    Computer computer;
    computer.usb("ttyUSB0", "usb1/1-1", "ch341-uart", "USB Serial");
    computer.usb("ttyUSB1", "usb1/1-2", "cp210x", "CP2102");
    computer.usb("ttyUSB2", "usb1/1-3", "cp210x", "CP2102");
    computer.file("sys/devices/usb1/1-2/serial", "0001");    // the same for all of them
    computer.file("sys/devices/usb1/1-3/serial", "53FF");
    for (int i = 0; i < 3; ++i) {
        const std::string n = std::to_string(i);
        computer.link("dev/serial/by-path/pci-0000:00:14.0-usb-0:" + n + ":1.0-port0", "../../ttyUSB" + n);
        computer.link("dev/serial/by-id/usb-maker_" + n + "-if00-port0", "../../ttyUSB" + n);
    }
    const auto ports = anoctl::serial_ports(computer.root(), administrator);
    ASSERT_EQ(ports.size(), 3u);
    EXPECT_EQ(ports[0].stable, "/dev/serial/by-path/pci-0000:00:14.0-usb-0:0:1.0-port0");
    EXPECT_EQ(ports[1].stable, "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0");
    EXPECT_EQ(ports[2].stable, "/dev/serial/by-id/usb-maker_2-if00-port0");
    EXPECT_NE(computer.shown(administrator).find("named by USB socket: the adapter has no unique serial number"),
              std::string::npos);
    EXPECT_TRUE(nlohmann::json::parse(lines_of(computer.shown(administrator, true)).at(0))["by_place"].get<bool>());
    const auto fault = [&](const std::string& device) { return anogate::fault_of_by_id(computer.root(), device); };
    EXPECT_EQ(
        fault("/dev/serial/by-id/usb-maker_0-if00-port0"),
        "its adapter has no serial number, so after replugging this name may belong to another adapter of the same model: use "
        "/dev/serial/by-path/pci-0000:00:14.0-usb-0:0:1.0-port0, which belongs to the USB port");
    EXPECT_NE(fault("/dev/serial/by-id/usb-maker_1-if00-port0"), "");
    EXPECT_EQ(fault("/dev/serial/by-id/usb-maker_2-if00-port0"), "");
    EXPECT_EQ(fault("/dev/serial/by-path/pci-0000:00:14.0-usb-0:0:1.0-port0"), "");
    EXPECT_EQ(fault("/dev/ttyUSB0"), "");
    EXPECT_NE(fault("/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0"), "") << "not plugged in: a CH340 by its name";
    EXPECT_EQ(fault("/dev/serial/by-id/usb-FTDI_FT232R_A50285BI-if00-port0"), "") << "not plugged in";
}

// Both are unplugged and plugged in again in the other order: the name of by-id leads to the other vehicle.
TEST(Ports, whose_name_refers_to_the_twin_after_replugging_are_detected) {
    Computer computer;
    const auto plug = [&](const std::string& socket) {
        fs::remove_all(computer.root() / "sys");
        fs::remove_all(computer.root() / "dev");
        computer.usb("ttyUSB0", "usb1/1-" + socket, "ch341-uart", "USB Serial");
        computer.link("dev/serial/by-id/usb-1a86_USB_Serial-if00-port0", "../../ttyUSB0");
    };
    const auto plug_twin = [&](const std::string& socket) {
        computer.usb("ttyUSB1", "usb1/1-" + socket, "ch341-uart", "USB Serial");
    };
    anogate::SocketWatch watch;
    const auto open = [&] { watch.opened(computer.root(), "/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0"); };
    plug("1");
    plug_twin("2");
    open();
    EXPECT_EQ(watch.twin(), "");
    EXPECT_EQ(watch.beside(), "/dev/ttyUSB1") << "both may have been plugged again before";
    plug("2");
    plug_twin("1");
    open();
    EXPECT_EQ(watch.twin(), "/dev/ttyUSB1");
    EXPECT_EQ(watch.from() + " " + watch.to(), "1-1 1-2");
    plug("3");
    open();
    EXPECT_EQ(watch.twin(), "") << "it was plugged into another socket, and is the only one";
    EXPECT_EQ(watch.beside(), "");
    EXPECT_TRUE(watch.awaits_twin());
    plug_twin("1");
    watch.look_for_twin(computer.root(), "/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0");
    EXPECT_EQ(watch.twin(), "/dev/ttyUSB1") << "it is the twin, and the first one returns";
    EXPECT_FALSE(watch.awaits_twin());
    plug("1");
    plug_twin("2");
    open();
    EXPECT_EQ(watch.twin(), "");
}

TEST(Ports, of_the_same_kind_are_twins_unless_their_serial_numbers_differ) {
    Computer computer;
    computer.usb("ttyUSB0", "usb1/1-1", "ch341-uart", "USB Serial");
    computer.usb("ttyUSB1", "usb1/1-2", "ch341-uart", "USB Serial");
    const auto twins = [&] {
        return anogate::twins_of(computer.root(), anogate::port_identity(computer.root(), "/dev/ttyUSB0"));
    };
    EXPECT_EQ(twins(), (std::vector<std::string>{"/dev/ttyUSB1"}));
    computer.file("sys/devices/usb1/1-1/serial", "7A21");
    EXPECT_TRUE(twins().empty());
    computer.file("sys/devices/usb1/1-2/serial", "7A21");
    EXPECT_EQ(twins().size(), 1u) << "a maker who gives all the same number";
    EXPECT_EQ(anogate::port_identity(computer.root(), "/dev/ttyUSB0").place, "1-1");
    EXPECT_TRUE(anogate::twins_of(computer.root(), anogate::port_identity(computer.root(), "/dev/nothing")).empty());
}

TEST(Ports, list_only_real_ports) {
    Computer computer;
    fs::create_directories(computer.root() / "sys/class/tty/tty1");    // a console has no device
    fs::create_directories(computer.root() / "sys/class/tty/rfcomm0");
    computer.port("ttyS0", "platform/serial8250/ttyS0", "serial8250");
    computer.file("sys/class/tty/ttyS0/type", "4");
    computer.port("ttyS1", "platform/serial8250/ttyS1", "serial8250");
    computer.file("sys/class/tty/ttyS1/type", "0");    // no UART exists there
    const auto ports = anoctl::serial_ports(computer.root(), administrator);
    ASSERT_EQ(ports.size(), 2u);
    EXPECT_EQ(ports[0].device, "/dev/rfcomm0");
    EXPECT_EQ(ports[1].device, "/dev/ttyS0");
}

TEST(Ports, show_the_driver_of_the_parent_of_internal_kernel_devices) {
    Computer computer;
    computer.port("ttyAMA0", "platform/fe201000.serial/ctrl0/port0", "port");
    computer.link("sys/devices/platform/fe201000.serial/ctrl0/driver", "../../bus/drivers/ctrl");
    computer.link("sys/devices/platform/fe201000.serial/driver", "../../bus/drivers/uart-pl011");
    computer.link("dev/serial0", "ttyAMA0");
    EXPECT_EQ(computer.shown(administrator), "/dev/ttyAMA0 uart-pl011\n    /dev/serial0\nno CAN interface found\n");
}

TEST(Ports, name_the_process_that_has_them_open_or_locked) {
    Computer computer;
    for (const char* name : {"ttyUSB0", "ttyUSB1", "ttyUSB2", "ttyUSB3"})
        computer.usb(name, "usb1/" + std::string{name}, "ftdi_sio", "x");
    computer.process(812, "minicom", "/dev/ttyUSB0");
    computer.process(90, "anogated");    // of another user: we can't read its descriptors
    computer.process(91, "pppd");
    computer.process(92, "somebody", "/dev/ttyUSB11");
    computer.file("proc/locks", "1: FLOCK  ADVISORY  WRITE 90 " + computer.inode("dev/ttyUSB1") + " 0 EOF\n" +    //
                                    "1: -> FLOCK  ADVISORY  WRITE 92 " + computer.inode("dev/ttyUSB1") + " 0 EOF\n" +
                                    "2: POSIX  ADVISORY  WRITE 92 " + computer.inode("dev/ttyUSB3") + " 0 EOF\n" +
                                    "3: FLOCK  ADVISORY  WRITE 812 " + computer.inode("dev/ttyUSB0") + " 0 EOF");
    computer.file("run/lock/LCK..ttyUSB2", "        91");
    computer.file("run/lock/LCK..ttyUSB3", "     77777");    // of a process that has ended
    const auto ports = anoctl::serial_ports(computer.root(), administrator);
    ASSERT_EQ(ports.size(), 4u);
    EXPECT_EQ(ports[0].holders, (std::vector<Holder>{{812, "minicom"}}));
    EXPECT_EQ(ports[1].holders, (std::vector<Holder>{{90, "anogated"}}));
    EXPECT_EQ(ports[2].holders, (std::vector<Holder>{{91, "pppd"}}));
    EXPECT_TRUE(ports[3].holders.empty());
    EXPECT_EQ(anoctl::holders_of(computer.root(), "/dev/ttyUSB1"), ports[1].holders);
    EXPECT_NE(computer.shown(administrator).find("\n    in use by anogated (pid 90)\n"), std::string::npos);
}

TEST(Ports, report_the_missing_permission_and_how_to_get_it) {
    Computer computer;
    computer.usb("ttyUSB0", "usb1/1-1", "cp210x", "x");
    constexpr gid_t usual = 20;    // if the test may not change the group of the port, it is our own
    const bool is_given = ::chown((computer.root() / "dev/ttyUSB0").c_str(), uid_t(-1), usual) == 0;
    const gid_t group = computer.group_of("dev/ttyUSB0");
    ASSERT_TRUE(!is_given || group == usual);
    computer.file("etc/group", "root:x:0:\ndialout:x:" + std::to_string(group) + ":ann,bob");
    const fs::path node = computer.root() / "dev/ttyUSB0";
    const auto missing = [&](const Asker& asker) { return anogate::missing_permission(computer.root(), "/dev/ttyUSB0", asker); };
    const Asker stranger{54321, "eve", {54321}}, late{54321, "bob", {54321}}, member{54321, "ann", {group}};
    EXPECT_EQ(missing(administrator), "");
    EXPECT_EQ(missing(member), "") << "of its group";
    if (group != 0) {
        EXPECT_EQ(missing(stranger), "it belongs to the group dialout: sudo usermod -aG dialout $USER, and log in again");
        EXPECT_EQ(missing(late), "you were added to its group dialout after your last login: log in again");
        EXPECT_EQ(missing({999, "anogate", {999}}),
                  "it belongs to the group dialout: sudo usermod -aG dialout anogate, and restart the service");
        EXPECT_EQ(missing({998, "ann", {998}}),
                  "its user ann was added to the group dialout after the last start: restart the service");
    }
    fs::permissions(node, fs::perms{0600});
    if (::geteuid() == 0) {
        EXPECT_EQ(missing(member), "only root may open it: add a udev rule for a group (GROUP=\"dialout\", MODE=\"0660\")");
        ASSERT_EQ(::chown(node.c_str(), 54322, gid_t(-1)), 0);
        EXPECT_EQ(missing(member),
                  "it belongs to user 54322, and its mode denies access to others: sudo chmod a+rw /dev/ttyUSB0");
        fs::permissions(node, fs::perms{0060});
        EXPECT_EQ(missing({54322, "owner", {group}}), "you own it, but its mode denies access: chmod u+rw /dev/ttyUSB0");
        ASSERT_EQ(::chown(node.c_str(), 0, gid_t(-1)), 0);
    }
    fs::permissions(node, fs::perms{0666});
    EXPECT_EQ(missing(stranger), "");
    computer.file("etc/group", "tty:x:" + std::to_string(group) + ":");
    fs::permissions(node, fs::perms{0620});
    EXPECT_EQ(missing(stranger), "a login console uses it: sudo systemctl disable --now serial-getty@ttyUSB0, and restart");
    fs::rename(node, node.parent_path() / "ttyTHS1");
    EXPECT_EQ(missing_permission(computer.root(), "/dev/ttyTHS1", stranger),
              "a login console uses it: sudo systemctl disable --now nvgetty, and restart");
}

TEST(Ports, as_text_fit_80_columns_without_cutting_names) {
    Computer computer;
    const std::string product = "CP2102 USB to UART Bridge Controller of a maker with very much to say about it";
    const std::string name = "/dev/serial/by-id/usb-Silicon_Labs_CP2102_USB_to_UART_Bridge_Controller_0001-if00-port0";
    computer.usb("ttyUSB0", "usb1/1-1", "cp210x", product);
    computer.link(name.substr(1), "../../ttyUSB0");
    computer.process(123456, "ModemManager", "/dev/ttyUSB0");
    fs::permissions(computer.root() / "dev/ttyUSB0", fs::perms{0600});
    const std::string shown = computer.shown({54321, "eve", {}});
    for (const std::string& line : lines_of(shown)) EXPECT_TRUE(line.size() <= 80 || line == name) << line;
    EXPECT_NE(shown.find("\n" + name + "\n"), std::string::npos) << shown;
    EXPECT_NE(
        shown.find(::geteuid() == 0 ? "    permission denied: only root may open it:" : "    permission denied: it belongs to "),
        std::string::npos)
        << shown;
}

TEST(Ports, as_json_are_one_object_per_line) {
    Computer computer;
    computer.usb("ttyUSB0", "usb1/1-1", "ch341-uart", "\x1B[31mevil\xFF");
    computer.process(812, "minicom", "/dev/ttyUSB0");
    computer.file("sys/class/net/can0/type", "280");
    computer.file("sys/class/net/can0/flags", "0x40081");
    computer.link("sys/class/net/can0/device/driver", "../drivers/gs_usb");
    const auto lines = lines_of(computer.shown(administrator, true));
    ASSERT_EQ(lines.size(), 2u);
    const auto port = nlohmann::json::parse(lines[0]);
    EXPECT_EQ(port["kind"], "serial");
    EXPECT_EQ(port["device"], "/dev/ttyUSB0");
    EXPECT_EQ(port["usb"], "1a86:7523");
    EXPECT_EQ(port["product"], "?[31mevil\xEF\xBF\xBD") << "what a device says does not command a terminal";
    EXPECT_EQ(port["holders"], nlohmann::json::parse(R"([{"pid": 812, "program": "minicom"}])"));
    EXPECT_EQ(port["permission"], true);
    const auto can = nlohmann::json::parse(lines[1]);
    EXPECT_EQ(can["kind"], "can");
    EXPECT_EQ(can["interface"], "can0");
    EXPECT_EQ(can["driver"], "gs_usb");
    EXPECT_EQ(can["up"], true);
}

TEST(Ports, of_hid_devices_are_shown_with_the_link) {
    Computer computer;
    const std::string stream{"\x06\0\xFF\x09\x01\xA1\x01\x75\x08\x95\x40\x09\x02\x81\x02\x09\x03\x91\x02\xC0", 20};
    const auto add = [&](const std::string& name, const std::string& id, const std::string& descriptor) {
        computer.file("sys/class/hidraw/" + name + "/device/uevent", "HID_ID=0003:" + id + "\nHID_NAME=ANO Radio");
        std::ofstream{computer.root() / "sys/class/hidraw" / name / "device/report_descriptor"} << descriptor;
        computer.file("dev/" + name, "");
    };
    add("hidraw0", "0000046D:0000C31C", stream);    // of another manufacturer
    add("hidraw1", "00000483:0000A005", stream);
    add("hidraw2", "000066CC:00000001", stream);
    add("hidraw3", "000066CC:00000001", stream);
    add("hidraw4", "000066CC:00000002", "");
    EXPECT_EQ(computer.shown(administrator),
              "/dev/hidraw1 HID ANO Radio (0483:A005)\n    link: hid:0483:A005\n"
              "/dev/hidraw2 HID ANO Radio (66CC:0001)\n    link: hid:/dev/hidraw2\n"
              "/dev/hidraw3 HID ANO Radio (66CC:0001)\n    link: hid:/dev/hidraw3\n"
              "/dev/hidraw4 HID ANO Radio (66CC:0002)\n    carries no byte stream\nno CAN interface found\n");
    const auto json = nlohmann::json::parse(lines_of(computer.shown(administrator, true)).at(0));
    EXPECT_EQ(json["kind"], "hid");
    EXPECT_EQ(json["link"], "hid:0483:A005");
    EXPECT_TRUE(json["permission"].get<bool>()) << json;
}

TEST(Ports, of_can_are_shown_with_the_command_that_brings_them_up) {
    Computer computer;
    computer.file("sys/class/net/eth0/type", "1");
    for (const char* name : {"can0", "vcan0"}) computer.file(std::string{"sys/class/net/"} + name + "/type", "280");
    computer.file("sys/class/net/can0/flags", "0x40080");
    computer.file("sys/class/net/vcan0/flags", "0xc1");
    computer.link("sys/class/net/can0/device/driver", "../drivers/mcp251x");
    EXPECT_EQ(computer.shown(administrator),
              "can0 mcp251x down; to bring it up:\n"
              "    sudo ip link set can0 up type can bitrate 500000 restart-ms 100\n"
              "vcan0 virtual up\n"
              "no serial port found; check that the adapter is plugged in (kernel messages:\nsudo dmesg)\n");
}

// --- netlink ----------------------------------------------------------------------------------------------------------

using support::Bytes;

template <class Value>
Bytes bytes_of(const Value& value) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(&value);
    return {first, first + sizeof value};
}

Bytes attribute(unsigned short type, Bytes value) {
    using support::operator+;
    const rtattr head{static_cast<unsigned short>(sizeof(rtattr) + value.size()), type};
    value.resize((value.size() + 3) / 4 * 4);
    return bytes_of(head) + value;
}

Bytes new_link(const Bytes& info) {
    using support::operator+;
    nlmsghdr head{};
    head.nlmsg_type = RTM_NEWLINK;
    return bytes_of(head) + bytes_of(ifinfomsg{}) + attribute(IFLA_IFNAME, {'c', 'a', 'n', '0', 0}) +
           attribute(IFLA_LINKINFO, info);
}

Bytes can_info(const char* kind = "can") {
    using support::operator+;
    can_bittiming slow{}, fast{};
    slow.bitrate = 500000;
    fast.bitrate = 2000000;
    const std::string text{kind};
    return attribute(IFLA_INFO_KIND, Bytes(text.begin(), text.end()) + Bytes{0}) +
           attribute(IFLA_INFO_DATA, attribute(IFLA_CAN_STATE, bytes_of(std::uint32_t{CAN_STATE_ERROR_PASSIVE})) +
                                         attribute(IFLA_CAN_BITTIMING, bytes_of(slow)) +
                                         attribute(IFLA_CAN_DATA_BITTIMING, bytes_of(fast)));
}

TEST(CanFigures, are_read_from_a_netlink_message) {
    EXPECT_EQ(anoctl::can_figures_in(new_link(can_info())), (anoctl::CanFigures{"error-passive", 500000, 2000000}));
    EXPECT_EQ(anoctl::can_figures_in(new_link(can_info("vlan"))), anoctl::CanFigures{}) << "of another sort";
    EXPECT_EQ(anoctl::can_figures_in(new_link({})), anoctl::CanFigures{});
}

TEST(CanFigures, of_a_truncated_or_damaged_message_are_read_within_its_bytes) {
    const Bytes whole = new_link(can_info());
    for (std::size_t n = 0; n < whole.size(); ++n) {
        const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));    // a heap block of its own for ASan
        EXPECT_LE(anoctl::can_figures_in(cut).bitrate, 500000u);
        Bytes damaged = whole;
        damaged[n] = 0xFF;
        anoctl::can_figures_in(damaged);
    }
}

}    // namespace
}    // namespace ports_tests
