#include <link/hid/hid_device.hpp>
#include <link/hid/hid_report.hpp>
#include <support/bytes.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <filesystem>

namespace hid_report_tests {
namespace {

using namespace anogate::hid;
using support::Bytes;

// As of the vendor's devices: a page of its own, 64 bytes each way.
const Bytes vendor_descriptor{0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,
                              0x95, 0x40, 0x09, 0x02, 0x81, 0x02, 0x95, 0x40, 0x09, 0x03, 0x91, 0x02, 0xC0};
// Of a keyboard: modifiers, a reserved byte and six keys; five lamps and three bits of padding.
const Bytes keyboard_descriptor{0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0x05, 0x07, 0x19, 0xE0, 0x29, 0xE7, 0x15, 0x00, 0x25, 0x01,
                                0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0x95, 0x01, 0x75, 0x08, 0x81, 0x01, 0x95, 0x05, 0x75, 0x01,
                                0x05, 0x08, 0x19, 0x01, 0x29, 0x05, 0x91, 0x02, 0x95, 0x01, 0x75, 0x03, 0x91, 0x01, 0x95, 0x06,
                                0x75, 0x08, 0x15, 0x00, 0x25, 0x65, 0x05, 0x07, 0x19, 0x00, 0x29, 0x65, 0x81, 0x00, 0xC0};

Bytes with(Bytes descriptor, std::size_t at, std::uint8_t byte) {
    descriptor.at(at) = byte;
    return descriptor;
}

TEST(HidReport, sizes_are_those_of_the_descriptor) {
    EXPECT_EQ(report_sizes(vendor_descriptor), (ReportSizes{64, 64}));
    EXPECT_EQ(report_sizes(with(vendor_descriptor, 21, 0x20)), (ReportSizes{64, 32}));
}

TEST(HidReport, of_a_keyboard_carries_no_stream) { EXPECT_EQ(report_sizes(keyboard_descriptor), std::nullopt); }

TEST(HidReport, sizes_of_a_damaged_descriptor_are_unknown) {
    EXPECT_EQ(report_sizes({}), std::nullopt);
    for (std::size_t size = 0; size < vendor_descriptor.size(); ++size)
        EXPECT_EQ(report_sizes(std::span{vendor_descriptor}.first(size)).value_or(ReportSizes{64, 64}), (ReportSizes{64, 64}));
    EXPECT_EQ(report_sizes(with(vendor_descriptor, 12, 0x85)), std::nullopt) << "a report id";
    EXPECT_EQ(report_sizes(with(vendor_descriptor, 15, 0x41)), std::nullopt) << "longer than a report";
    EXPECT_EQ(report_sizes(with(vendor_descriptor, 13, 0x07)), (ReportSizes{56, 56}));
    Bytes huge = vendor_descriptor;
    huge.insert(huge.begin() + 16, {0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x77, 0xFF, 0xFF, 0xFF, 0xFF});
    EXPECT_EQ(report_sizes(huge), std::nullopt);
}

TEST(HidReport, has_as_many_bytes_as_its_first_byte_says) {
    Bytes report(64, 7);
    report[0] = 3;
    ASSERT_TRUE(bytes_of_report(report));
    EXPECT_EQ(bytes_of_report(report)->size(), 3u);
    EXPECT_EQ(bytes_of_report(report)->data(), report.data() + 1);
    report[0] = 0;
    EXPECT_TRUE(bytes_of_report(report)->empty());
    report[0] = 63;
    EXPECT_EQ(bytes_of_report(report)->size(), 63u);
    report[0] = 64;
    EXPECT_EQ(bytes_of_report(report), std::nullopt);
    EXPECT_EQ(bytes_of_report(Bytes{}), std::nullopt);
}

TEST(HidReport, to_a_device_has_at_most_32_bytes) {
    EXPECT_EQ(bytes_per_report(64), 32u);
    EXPECT_EQ(bytes_per_report(33), 32u);
    EXPECT_EQ(bytes_per_report(16), 15u);
    EXPECT_EQ(bytes_per_report(2), 1u);
}

TEST(HidUsbId, is_a_vendor_or_a_vendor_and_a_product) {
    ASSERT_TRUE(UsbId::parse("0483:a005"));
    EXPECT_EQ(UsbId::parse("0483:a005")->product, 0xA005);
    EXPECT_TRUE(UsbId::parse("66CC")->matches({0x66CC, 0x1234}));
    EXPECT_FALSE(UsbId::parse("66CC:1235")->matches({0x66CC, 0x1234}));
    EXPECT_FALSE(UsbId::parse("66CD")->matches({0x66CC, 0x1234}));
    for (const char* text : {"", "66C", "66CCC", "66CC:", "66CC:123", "66CG", "66CC:12345", "0x66CC", "+6CC", " 6CC"})
        EXPECT_FALSE(UsbId::parse(text)) << text;
}

class HidDevices : public testing::Test {
protected:
    void add(const std::string& name, const std::string& id, const Bytes& descriptor) {
        const std::string folder = "sys/class/hidraw/" + name + "/device/";
        std::filesystem::create_directories(dir / folder);
        dir.write(folder + "uevent", "DRIVER=hid-generic\nHID_ID=" + id + "\nHID_NAME=ANO Radio\nHID_PHYS=usb\n");
        dir.write(folder + "report_descriptor", std::string{descriptor.begin(), descriptor.end()});
    }
    support::TempDir dir;
};

TEST_F(HidDevices, are_listed_by_number) {
    add("hidraw10", "0003:00000483:0000A005", vendor_descriptor);
    add("hidraw9", "0003:000066CC:00000001", vendor_descriptor);
    add("hidraw0", "0003:0000046D:0000C31C", keyboard_descriptor);
    add("hidraw1", "damaged", keyboard_descriptor);
    const auto all = devices(dir / "");
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].path, "/dev/hidraw0");
    EXPECT_FALSE(all[0].reports);
    EXPECT_EQ(all[1].path, "/dev/hidraw9");
    EXPECT_EQ(all[1].id.vendor, 0x66CC);
    EXPECT_EQ(all[1].name, "ANO Radio");
    EXPECT_EQ(all[2].path, "/dev/hidraw10");
    EXPECT_EQ(all[2].reports, (ReportSizes{64, 64}));
}

TEST_F(HidDevices, are_none_without_hidraw) { EXPECT_TRUE(devices(dir / "").empty()); }

}    // namespace
}    // namespace hid_report_tests
