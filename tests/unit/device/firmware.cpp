#include <gtest/gtest.h>
#include <ano/crc16.hpp>
#include <device/device.hpp>

#include <numeric>
#include <optional>
#include <vector>

#include "talk.hpp"

namespace firmware_tests {
namespace {

using ano::device::Device;
using ano::device::Flash;
using ano::device::Image;
using ano::device::ImageInfo;
using ano::device::Profile;
using State = ano::device::Firmware::State;
using namespace std::chrono_literals;
using namespace talk;
using support::operator+;

Bytes le(std::uint64_t value, std::size_t size) {
    Bytes result;
    for (std::size_t i = 0; i < size; ++i) result.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return result;
}
Bytes code(std::uint16_t code) { return ask(0xF0, Bytes{0} + le(code, 2)); }
Bytes code_reply(std::uint16_t code) { return expected_reply(0xF0, Bytes{0} + le(code, 2)); }
Bytes frame_reply(std::uint16_t code, std::uint16_t number) {
    return expected_reply(0xF0, Bytes{0} + le(code, 2) + le(number, 2));
}
Bytes image_info(const ImageInfo& i) {
    return ask(0xF0, Bytes{1} + le(i.size, 4) + le(i.frame_size, 2) + le(i.crc, 2) + le(i.version, 2) + le(i.hw_type, 1) +
                         le(i.hw_ver_min, 2) + le(i.hw_ver_max, 2) + le(i.cmd, 4));
}
Bytes image_frame(std::uint16_t number, const Bytes& bytes) { return ask(0xF0, Bytes{0x10} + le(number, 2) + bytes); }

const Bytes erase = code(0x0110), all_sent = code(0x1010);

// A .bia as a host reads it: 100 bytes of header, then the image.
struct BiaFile {
    Bytes bytes;
    ImageInfo info(std::uint16_t frame_size) const {
        const auto u16 = [&](std::size_t at) { return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8); };
        return {.size = static_cast<std::uint32_t>(bytes.size() - 100),
                .frame_size = frame_size,
                .crc = u16(12),
                .version = u16(10),
                .hw_type = bytes[20],
                .hw_ver_min = u16(30),
                .hw_ver_max = u16(32),
                .cmd = static_cast<std::uint32_t>(u16(50) | u16(52) << 16)};
    }
    Bytes image() const { return {bytes.begin() + 100, bytes.end()}; }
};

// A device with a boot loader, an image of 25 bytes, and a host that sends 10 at a time.
struct Loader {
    explicit Loader(const Profile& profile = {}) : device{{.id = self, .hw_ver = 3}, profile} {
        std::iota(image.begin(), image.end(), std::uint8_t{100});
        flash.max_size = 64;
        flash.install = [this](const Image& whole) {
            ++installs;
            installed.assign(whole.bytes.begin(), whole.bytes.end());
            version = whole.info.version;
            return works;
        };
    }
    ImageInfo info() const { return {.size = 25, .frame_size = 10, .crc = ano::crc16_of(image)}; }
    Bytes part(std::size_t number) const {
        const std::size_t begin = number * 10, end = std::min<std::size_t>(begin + 10, image.size());
        return {image.begin() + static_cast<std::ptrdiff_t>(begin), image.begin() + static_cast<std::ptrdiff_t>(end)};
    }
    Bytes frame(std::uint16_t number) const { return image_frame(number, part(number)); }
    void begin() {
        device.firmware().allow(flash);
        ASSERT_EQ(answer(device, image_info(info())), code_reply(0x0102));
        ASSERT_EQ(answer(device, erase), code_reply(0x0112));
    }
    void write(std::uint16_t number) { ASSERT_EQ(answer(device, frame(number)), frame_reply(0x1002, number)) << number; }

    Device device;
    Flash flash;
    Bytes image = Bytes(25);
    Bytes installed;
    std::uint16_t version = 0;
    int installs = 0;
    bool works = true;
};

TEST(Firmware, accepts_a_bin) {
    Loader loader;
    loader.begin();
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(loader.installed, loader.image);
    EXPECT_EQ(loader.device.firmware().state(), State::passed);
}

TEST(Firmware, sends_codes_high_byte_first_if_its_profile_requires_it) {
    Loader loader{Profile{.firmware_order = ano::ByteOrder::big}};
    loader.device.firmware().allow(loader.flash);
    EXPECT_EQ(answer(loader.device, image_info(loader.info())), expected_reply(0xF0, {0, 0x01, 0x02}));
    EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 0x01, 0x10})), expected_reply(0xF0, {0, 0x01, 0x12}));
    EXPECT_EQ(answer(loader.device, image_frame(2, {})), expected_reply(0xF0, {0, 0x10, 0x01, 2, 0})) << "failed";
    for (const std::uint8_t number : Bytes{0, 1, 2})
        EXPECT_EQ(answer(loader.device, loader.frame(number)), expected_reply(0xF0, {0, 0x10, 0x02, number, 0}));
    EXPECT_EQ(answer(loader.device, all_sent), expected_reply(0xF0, {0, 0x10, 0x12}));
    EXPECT_EQ(loader.installed, loader.image);
}

TEST(Firmware, accepts_an_erase_in_both_byte_orders_and_continues_in_that_order) {
    for (const auto order : {ano::ByteOrder::little, ano::ByteOrder::big}) {
        Loader loader{Profile{.firmware_order = order}};
        loader.device.firmware().allow(loader.flash);
        answer(loader.device, image_info(loader.info()));
        EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 0x10, 0x01})), expected_reply(0xF0, {0, 0x12, 0x01})) << "little";
        loader.write(0);
        EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 0x01, 0x10})), expected_reply(0xF0, {0, 0x01, 0x12})) << "big";
        EXPECT_EQ(answer(loader.device, loader.frame(0)), expected_reply(0xF0, {0, 0x10, 0x02, 0, 0}));
    }
    Loader loader;
    loader.begin();
    EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 0x01, 0x10, 7, 0})), silence) << "frame 7 failed, of another loader: no erase";
    EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 0x10, 0x01, 7, 0})), silence);
    loader.write(0);
}

TEST(Firmware, accepts_a_bia_only_for_its_hardware) {
    Loader loader;
    Bytes header(100);
    header[0] = 'b', header[1] = 'i', header[2] = 'a';
    header[10] = 42;
    header[12] = static_cast<std::uint8_t>(loader.info().crc), header[13] = static_cast<std::uint8_t>(loader.info().crc >> 8);
    header[20] = self, header[30] = 2, header[32] = 4, header[52] = 7;
    const BiaFile file{header + loader.image};
    ASSERT_EQ(file.info(10).size, 25u);
    loader.device.firmware().allow(loader.flash);
    for (const auto& [at, wrong] : std::vector<std::pair<std::size_t, std::uint8_t>>{{20, 0x22}, {30, 4}, {32, 2}}) {
        BiaFile other = file;
        other.bytes[at] = wrong;
        EXPECT_EQ(answer(loader.device, image_info(other.info(10))), code_reply(0x0101)) << at;
    }
    ASSERT_EQ(answer(loader.device, image_info(file.info(10))), code_reply(0x0102));
    EXPECT_EQ(loader.device.firmware().image().cmd, 0x70000u);
    ASSERT_EQ(answer(loader.device, erase), code_reply(0x0112));
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(loader.version, 42);
}

TEST(Firmware, rejects_an_image_that_it_cannot_store_or_count) {
    Loader loader;
    loader.flash.accept = [](const ImageInfo& i) { return i.version != 13; };
    loader.device.firmware().allow(loader.flash);
    for (const ImageInfo& wrong : std::vector<ImageInfo>{{.size = 0, .frame_size = 10},
                                                         {.size = 65, .frame_size = 10},
                                                         {.size = 25, .frame_size = 0},
                                                         {.size = UINT32_MAX, .frame_size = 1},
                                                         {.size = 25, .frame_size = 65533},
                                                         {.size = 25, .frame_size = 10, .version = 13}})
        EXPECT_EQ(answer(loader.device, image_info(wrong)), code_reply(0x0101)) << wrong.size << " " << wrong.frame_size;
    EXPECT_EQ(answer(loader.device, erase), code_reply(0x0111)) << "nothing was accepted";
    EXPECT_EQ(answer(loader.device, image_info({.size = 64, .frame_size = 1})), code_reply(0x0102));
    loader.flash.max_size = 70000;
    loader.device.firmware().allow(loader.flash);
    EXPECT_EQ(answer(loader.device, image_info({.size = 65536, .frame_size = 1})), code_reply(0x0102));
    EXPECT_EQ(answer(loader.device, image_info({.size = 65537, .frame_size = 1})), code_reply(0x0101)) << "frame 65536";
    Bytes too_short = image_info(loader.info());
    too_short = ask(0xF0, Bytes(too_short.begin() + 6, too_short.end() - 3));
    EXPECT_EQ(answer(loader.device, too_short), silence);
}

TEST(Firmware, accepts_frames_in_any_order_and_repeatedly) {
    Loader loader;
    loader.begin();
    loader.write(2);
    loader.write(0);
    loader.write(0);
    EXPECT_EQ(loader.device.firmware().written(), 2u);
    EXPECT_EQ(answer(loader.device, image_frame(0, Bytes(10))), frame_reply(0x1001, 0)) << "something else in its place";
    loader.write(1);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(loader.installed, loader.image);
}

TEST(Firmware, accepts_a_padded_last_frame) {
    Loader loader;
    loader.begin();
    loader.write(0);
    loader.write(1);
    EXPECT_EQ(answer(loader.device, image_frame(2, loader.part(2) + Bytes(6))), frame_reply(0x1001, 2)) << "too long";
    EXPECT_EQ(answer(loader.device, image_frame(2, loader.part(2) + Bytes(5, 0xFF))), frame_reply(0x1002, 2));
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(loader.installed, loader.image);
}

TEST(Firmware, fails_a_frame_that_is_too_short_too_long_or_after_the_end) {
    Loader loader;
    loader.begin();
    EXPECT_EQ(answer(loader.device, image_frame(0, Bytes(9))), frame_reply(0x1001, 0));
    EXPECT_EQ(answer(loader.device, image_frame(0, Bytes(11))), frame_reply(0x1001, 0));
    EXPECT_EQ(answer(loader.device, image_frame(3, Bytes(10))), frame_reply(0x1001, 3));
    EXPECT_EQ(answer(loader.device, image_frame(65535, {})), frame_reply(0x1001, 65535));
    EXPECT_EQ(loader.device.firmware().written(), 0u);
}

TEST(Firmware, with_a_gap_or_damage_does_not_pass) {
    Loader loader;
    loader.begin();
    loader.write(0);
    loader.write(2);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011)) << "frame 1 is missing";
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011));
    EXPECT_EQ(answer(loader.device, loader.frame(1)), frame_reply(0x1001, 1)) << "it has to begin again";
    loader.begin();
    loader.write(0);
    EXPECT_EQ(answer(loader.device, image_frame(1, Bytes(10))), frame_reply(0x1002, 1));
    loader.write(2);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011)) << "another CRC";
    EXPECT_EQ(loader.installs, 0);
}

TEST(Firmware, checks_the_configured_crc) {
    Loader loader;
    loader.flash.crc = ano::find_crc16("crc16/modbus");
    loader.begin();
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011));
    loader.flash.crc.reset();
    loader.begin();
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012)) << "not checked";
}

TEST(Firmware, is_installed_once_however_often_the_host_requests_it) {
    Loader loader;
    loader.begin();
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1012));
    EXPECT_EQ(loader.installs, 1);
    loader.works = false;
    loader.begin();
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011)) << "its user says so";
    EXPECT_EQ(loader.installs, 2);
}

TEST(Firmware, fails_steps_that_arrive_out_of_order) {
    Loader loader;
    loader.device.firmware().allow(loader.flash);
    EXPECT_EQ(answer(loader.device, loader.frame(0)), frame_reply(0x1001, 0));
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011));
    answer(loader.device, image_info(loader.info()));
    EXPECT_EQ(answer(loader.device, loader.frame(0)), frame_reply(0x1001, 0)) << "not erased";
    EXPECT_EQ(answer(loader.device, all_sent), code_reply(0x1011));
    loader.begin();
    const Bytes of_another = support::frame(0xD2, self, 0xF0, {0, 0x10, 0x10});
    EXPECT_EQ(answer(loader.device, of_another), support::frame(self, 0xD2, 0xF0, {0, 0x11, 0x10}));
    const Bytes part_of_another = loader.frame(0);
    const Bytes frame_of_another = support::frame(0xD2, self, 0xF0,
                                                  Bytes(part_of_another.begin() + 6, part_of_another.end() - 2));
    EXPECT_EQ(answer(loader.device, frame_of_another), support::frame(self, 0xD2, 0xF0, {0, 0x01, 0x10, 0, 0}));
    EXPECT_EQ(loader.device.firmware().written(), 0u);
    EXPECT_EQ(loader.device.firmware().state(), State::receiving) << "and goes on";
}

TEST(Firmware, reports_that_its_flash_cannot_be_erased) {
    Loader loader;
    loader.flash.erase = [] { return false; };
    loader.device.firmware().allow(loader.flash);
    answer(loader.device, image_info(loader.info()));
    EXPECT_EQ(answer(loader.device, erase), code_reply(0x0111));
    EXPECT_EQ(answer(loader.device, loader.frame(0)), frame_reply(0x1001, 0));
}

TEST(Firmware, answers_a_slow_step_when_it_is_done) {
    Loader loader;
    loader.flash.erase_time = 3s;
    loader.flash.check_time = 2s;
    Device& device = loader.device;
    device.firmware().allow(loader.flash);
    answer(device, image_info(loader.info()));
    EXPECT_EQ(answer(device, erase), silence);
    EXPECT_EQ(device.due(), start + 3s);
    EXPECT_EQ(answer(device, erase, start + 1s), silence) << "the one answer is for both";
    EXPECT_EQ(answer(device, image_info(loader.info()), start + 1s), silence);
    device.run(start + 3s);
    EXPECT_EQ(heard(device), (std::vector<Bytes>{code_reply(0x0112)}));
    EXPECT_FALSE(device.due());
    for (const std::uint8_t number : Bytes{0, 1, 2}) loader.write(number);
    EXPECT_EQ(answer(device, all_sent, start + 4s), silence);
    EXPECT_EQ(answer(device, all_sent, start + 5s), silence);
    EXPECT_EQ(answer(device, loader.frame(0), start + 5s), frame_reply(0x1001, 0)) << "nothing is written while it is checked";
    device.run(start + 6s);
    EXPECT_EQ(heard(device), (std::vector<Bytes>{code_reply(0x1012)}));
    EXPECT_EQ(loader.installs, 1);
}

TEST(Firmware, sent_by_broadcast_is_ignored) {
    Loader loader;
    loader.device.firmware().allow(loader.flash);
    Bytes info = image_info(loader.info());
    const Bytes to_all = support::frame(host, everybody, 0xF0, Bytes(info.begin() + 6, info.end() - 2));
    EXPECT_EQ(answer(loader.device, to_all), silence);
    EXPECT_EQ(loader.device.firmware().state(), State::idle);
}

TEST(Firmware, is_ignored_by_a_device_without_a_loader) {
    Loader loader;
    for (const auto& frame : {image_info(loader.info()), erase, loader.frame(0), all_sent})
        EXPECT_EQ(answer(loader.device, frame), silence);
    EXPECT_EQ(loader.device.counters().unknown, 4u);
}

TEST(Firmware, does_not_answer_responses_of_a_loader) {
    Loader loader;
    loader.device.firmware().allow(loader.flash);
    for (const std::uint16_t answered : std::initializer_list<std::uint16_t>{0x0101, 0x0102, 0x0111, 0x0112, 0x1011, 0x1012})
        EXPECT_EQ(answer(loader.device, code(answered)), silence);
    EXPECT_EQ(answer(loader.device, ask(0xF0, {0, 2, 0x10, 0, 0})), silence);
    EXPECT_EQ(loader.device.counters().unanswered, 7u);
    EXPECT_EQ(answer(loader.device, ask(0xF0, {7, 0, 0})), silence) << "no such iap_cmd";
    EXPECT_EQ(answer(loader.device, ask(0xF0, {})), silence);
}

}    // namespace
}    // namespace firmware_tests
