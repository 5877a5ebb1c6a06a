// Upgrading firmware: valid and invalid files, and loaders that write, refuse, fail and stop answering.
#include <host/firmware.hpp>

#include <support/fake_loader.hpp>

#include <gtest/gtest.h>

namespace ano::host::firmware_tests {
namespace {

using namespace std::chrono_literals;
using support::Bytes;
using support::FakeDevice;
using support::FakeLoader;
using support::Simulation;

Bytes bytes_of(std::size_t n) {
    Bytes bytes(n);
    for (std::size_t i = 0; i < n; ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + i / 256);
    return bytes;
}

Bytes bia(const Bytes& image, std::uint8_t hw_type, std::uint16_t min, std::uint16_t max) {
    Bytes file(100);
    file[0] = 'b', file[1] = 'i', file[2] = 'a';
    store<std::uint16_t>(&file[10], 321);
    store<std::uint16_t>(&file[12], crc16_of(image));
    file[20] = hw_type;
    store(&file[30], min);
    store(&file[32], max);
    store<std::uint32_t>(&file[50], 0x12345678);
    file.insert(file.end(), image.begin(), image.end());
    return file;
}

Bytes all_of(const FirmwareBytes& bytes) {
    Bytes all(bytes.size());
    EXPECT_TRUE(bytes.read(0, all));
    return all;
}

TEST(FirmwareFile, a_large_file_is_read_in_pieces_and_its_crc_covers_the_whole_file) {
    Bytes file = bytes_of(100'001);
    std::size_t largest = 0;
    const FirmwareBytes pieces{file.size(), [&](std::size_t at, std::span<std::uint8_t> into) {
                                   largest = std::max(largest, into.size());
                                   std::copy_n(file.begin() + static_cast<std::ptrdiff_t>(at), into.size(), into.begin());
                                   return true;
                               }};
    for (const Crc16& crc : crcs16) {
        const auto read = read_firmware(pieces, crc);
        ASSERT_TRUE(read.image) << read.wrong.text();
        EXPECT_EQ(read.image->crc, crc16_of(file, crc)) << crc.name;
    }
    EXPECT_LE(largest, 16'384u);
    const FirmwareBytes broken{file.size(), [](std::size_t at, std::span<std::uint8_t>) { return at < 50'000; }};
    EXPECT_EQ(read_firmware(broken).wrong.text(), "the file can't be read");
}

TEST(FirmwareFile, a_bia_is_read_by_its_header) {
    const auto read = read_firmware(bia(bytes_of(500), 0xDC, 90, 110));
    ASSERT_TRUE(read.image) << read.wrong.text();
    EXPECT_EQ(all_of(read.image->bytes), bytes_of(500));
    EXPECT_EQ(read.image->version, 321);
    EXPECT_EQ(read.image->cmd, 0x12345678u);
    EXPECT_TRUE(read.image->misfit({0xDC, 100, 0, 0, 0, ""}).empty());
    EXPECT_EQ(read.image->misfit({0xDD, 100, 0, 0, 0, ""}).text(), "it is for hardware 0xDC, the device is 0xDD");
    EXPECT_EQ(read.image->misfit({0xDC, 111, 0, 0, 0, ""}).text(), "it is for hardware versions 90 to 110, the device is 111");
    EXPECT_FALSE(read.image->misfit({0xDC, 89, 0, 0, 0, ""}).empty());
}

TEST(FirmwareFile, a_bin_is_an_image_for_any_hardware) {
    const auto read = read_firmware(bytes_of(500), *find_crc16("crc16/xmodem"));
    ASSERT_TRUE(read.image);
    EXPECT_EQ(read.image->crc, crc16_of(bytes_of(500), *find_crc16("crc16/xmodem")));
    EXPECT_TRUE(read.image->is_for_any_hardware());
    EXPECT_TRUE(read.image->misfit({0xDD, 1, 0, 0, 0, ""}).empty());
}

TEST(FirmwareFile, an_invalid_file_is_rejected_with_the_reason) {
    EXPECT_EQ(read_firmware({}).wrong.text(), "the file is empty");
    Bytes cut = bia(bytes_of(10), 0xDC, 1, 2);
    cut.resize(100);
    EXPECT_EQ(read_firmware(cut).wrong.text(), "the file ends in its header: it is cut off");
    EXPECT_FALSE(read_firmware(bia(bytes_of(10), 0xDC, 3, 2)).image);
    EXPECT_FALSE(read_firmware(Bytes(FirmwareImage::max_bytes + 1)).image);
    for (std::size_t n = 1; n < 120; ++n) {
        Bytes part = bia(bytes_of(20), 0xDC, 1, 2);
        part.resize(n);
        (void)read_firmware(part);
    }
}

struct Upgrade : testing::Test {
    FakeDevice fake;
    FakeLoader loader;
    Device device{0xDC};
    Simulation simulation{device, fake, {.delay = 5ms}};
    FirmwareImage image = *read_firmware(bia(bytes_of(3000), 0xDC, 90, 110)).image;

    Upgrade() {
        fake.instead = [&](FrameView f) { return loader.take(fake, f); };
    }
    std::unique_ptr<Firmware> run(FirmwareOptions options = {}) {
        auto task = std::make_unique<Firmware>(device, image, std::move(options));
        task->start(simulation.now);
        took = simulation.run(*task);
        EXPECT_TRUE(task->end());
        return task;
    }
    Duration took{};
};

TEST_F(Upgrade, writes_the_image_and_succeeds_after_the_check_of_the_device) {
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(loader.flash, bytes_of(3000));
    EXPECT_EQ(loader.frames, 16u);    // 15 of 195 bytes and one of 75
    EXPECT_EQ(task->progress().done, 3000u);
    EXPECT_EQ(task->repeats(), 0u);
    EXPECT_FALSE(task->is_left_in_loader());
    EXPECT_EQ(loader.info, (Bytes{1,
                                  0xB8,
                                  0x0B,
                                  0,
                                  0,
                                  195,
                                  0,
                                  static_cast<std::uint8_t>(image.crc),
                                  static_cast<std::uint8_t>(image.crc >> 8),
                                  0x41,
                                  1,
                                  0xDC,
                                  90,
                                  0,
                                  110,
                                  0,
                                  0x78,
                                  0x56,
                                  0x34,
                                  0x12}));
}

TEST_F(Upgrade, reports_its_rate_and_the_time_left) {
    Firmware task{device, image};
    bool told = false;
    simulation.each_step = [&](TimePoint now) {
        if (told || task.progress().done != 8u * 195) return;
        told = true;
        EXPECT_NEAR(task.bytes_a_second(now), 19'500, 1);    // 195 bytes in each 10 ms
        ASSERT_TRUE(task.time_left(now));
        EXPECT_NEAR(std::chrono::duration<double>(*task.time_left(now)).count(), 1440 / 19'500.0, 1e-3);
        EXPECT_EQ(task.step(), "sending");
    };
    task.start(simulation.now);
    EXPECT_FALSE(task.time_left(simulation.now));
    simulation.run(task);
    EXPECT_TRUE(told);
}

TEST_F(Upgrade, succeeds_over_a_line_that_loses_duplicates_and_reorders_frames) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        loader = {};
        Device other{0xDC};
        Simulation bad{other, fake, {.delay = 20ms, .jitter = 60ms, .loss = 0.1, .duplicate = 0.1}, seed};
        Firmware task{other, image};
        task.start(bad.now);
        bad.run(task);
        ASSERT_TRUE(task.end());
        EXPECT_EQ(task.end()->ending, Ending::done) << "seed " << seed << ": " << task.end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
        EXPECT_GT(task.repeats(), 0u);
    }
}

TEST_F(Upgrade, ends_before_any_change_if_the_device_refuses_the_image) {
    loader.refuses = true;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::refused);
    EXPECT_EQ(task->end()->fault.text(), "0xDC does not want this image");
    EXPECT_EQ(loader.erases, 0u);
}

TEST_F(Upgrade, repeats_an_erase_only_after_a_minute) {
    loader.erases_silently = true;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC stopped answering: erasing; it is left in its boot loader; start again");
    EXPECT_EQ(loader.erases, 4u);
    EXPECT_GE(took, 240s);
    EXPECT_LT(took, 250s);
}

TEST_F(Upgrade, reports_a_failed_erase) {
    loader.cannot_erase = true;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::failed);
    EXPECT_EQ(task->end()->fault.text(), "the device could not erase; it is left in its boot loader; start again");
}

TEST_F(Upgrade, a_frame_that_failed_is_sent_again_and_counted) {
    loader.fails_frame_7 = 4;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(task->repeats(), 4u);
    EXPECT_EQ(loader.flash, bytes_of(3000));
}

TEST_F(Upgrade, counts_failures_for_each_frame_separately) {
    loader.fails_every_frame_once = true;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(task->repeats(), 16u);
}

TEST_F(Upgrade, ends_when_a_frame_always_fails) {
    loader.fails_frame_7 = 100;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::failed);
    EXPECT_EQ(task->end()->fault.text(), "the device could not write frame 7; it is left in its boot loader; start again");
    EXPECT_TRUE(task->is_left_in_loader());
}

TEST_F(Upgrade, ends_within_its_time_limit_when_the_device_becomes_silent_in_the_middle) {
    loader.dies_at = 9;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC stopped answering: sending; it is left in its boot loader; start again");
    EXPECT_GE(took, 2 * Firmware::patience_unheard);
    EXPECT_LT(took, 2 * Firmware::patience_unheard + 10s);
    EXPECT_EQ(loader.infos, 2u) << "it may have lost the upgrade: begun again once";
}

TEST_F(Upgrade, waits_half_a_minute_for_the_check_of_the_device_after_the_last_frame) {
    loader.checks_silently = true;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(
        task->end()->fault.text(),
        "0xDC has written all 16 frames, but did not report within 30 s whether the image passed its check: it may run the new "
        "firmware already (anoctl devices --scan shows its version); if it does not, begin again");
    EXPECT_EQ(loader.checks, 6u);
    EXPECT_GE(took, Firmware::check_patience);
    EXPECT_LT(took, Firmware::check_patience + 1s);
}

// It receives the info, and restarts into its loader without an answer.
TEST_F(Upgrade, sends_the_info_again_to_a_device_that_restarts_into_its_boot_loader) {
    for (const Duration restart : {Duration{800ms}, Duration{2500ms}, Duration{25s}}) {
        loader = {};
        std::optional<TimePoint> back_at;
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() == 0xF0 && !back_at) back_at = simulation.now + restart;
            if (back_at && simulation.now < *back_at) return std::vector<Bytes>{};
            return loader.take(fake, f);
        };
        const auto task = run();
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
        EXPECT_LT(took, restart + 2s);
    }
}

// It answers questions both before it is in its loader and in it.
TEST_F(Upgrade, sends_the_info_again_to_a_device_that_answers_requests_before_and_after_its_restart) {
    for (const Duration begins : {0ms, 300ms, 900ms, 1200ms, 1900ms}) {
        loader = {};
        std::optional<TimePoint> asked_at;
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() == 0xF0 && !asked_at) asked_at = simulation.now;
            if (!asked_at) return std::nullopt;
            const Duration since = simulation.now - *asked_at;
            if (since < begins) return f.id() == 0xF0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
            if (since < begins + 2500ms) return std::vector<Bytes>{};
            return loader.take(fake, f);
        };
        const auto task = run();
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
    }
}

TEST_F(Upgrade, of_a_device_that_answers_everything_except_an_info_ends_within_five_seconds) {
    for (const bool forced : {false, true}) {
        FirmwareOptions options;
        options.force = forced;
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            return f.id() == 0xF0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
        };
        const auto task = run(options);
        EXPECT_EQ(task->end()->ending, Ending::unsupported);
        EXPECT_EQ(task->end()->fault.text(),
                  "0xDC answers other requests, but not the description of the image: it has no boot loader");
        EXPECT_FALSE(task->is_left_in_loader());
        EXPECT_GE(took, 3s) << "a restart into the loader may take 2.5 s";
        EXPECT_LE(took, 5s);
    }
}

TEST_F(Upgrade, ends_after_half_a_minute_if_the_device_is_silent_after_the_info) {
    fake.instead = [&, is_silent = false](FrameView f) mutable -> std::optional<std::vector<Bytes>> {
        is_silent = is_silent || f.id() == 0xF0;
        return is_silent ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC stopped answering: description of the image");
    EXPECT_FALSE(task->is_left_in_loader());
    EXPECT_GE(took, Firmware::patience);
    EXPECT_LT(took, Firmware::patience + 5s);
}

TEST_F(Upgrade, fails_if_the_image_does_not_pass_the_check_of_the_device) {
    image.crc ^= 1;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::failed);
    EXPECT_TRUE(task->is_left_in_loader());
}

// The two sums of a frame do not detect every error.
TEST_F(Upgrade, sends_an_image_damaged_by_noise_again_in_the_shortest_frames) {
    for (const std::size_t damaged : {std::size_t{1}, std::size_t{2}, std::size_t{99}}) {
        loader = {};
        std::size_t lost = 0;
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() == 0xF0 && f.data()[0] == 0x10 && lost++ == 0) return std::vector<Bytes>{};
            const bool is_last = f.id() == 0xF0 && f.data()[0] == 0 && f.data()[1] == 0x10 && f.data()[2] == 0x10;
            if (is_last && loader.checks < damaged) loader.flash[7] ^= 1;
            return loader.take(fake, f);
        };
        const auto task = run();
        if (damaged == 99) {
            EXPECT_EQ(task->end()->fault.text(),
                      "the image did not pass the device's check; it is left in its boot loader; start again");
            EXPECT_EQ(loader.checks, 3u);
            continue;
        }
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
        EXPECT_EQ(task->frame_len(), 32u);
        EXPECT_TRUE(task->remark().text().starts_with(
            "begun again with frames of 32 bytes, because the image did not pass the device's check"))
            << task->remark().text();
    }
}

TEST_F(Upgrade, sends_an_image_damaged_by_noise_again_even_if_the_loader_rejects_another_info) {
    loader.second_info = FakeLoader::SecondInfo::refuses;
    std::size_t lost = 0;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xF0 && f.data()[0] == 0x10 && lost++ == 0) return std::vector<Bytes>{};
        const bool is_last = f.id() == 0xF0 && f.data()[0] == 0 && f.data()[1] == 0x10 && f.data()[2] == 0x10;
        if (is_last && loader.checks == 0) loader.flash[7] ^= 1;
        return loader.take(fake, f);
    };
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(loader.flash, bytes_of(3000));
    EXPECT_EQ(loader.erases, 2u);
}

TEST_F(Upgrade, erases_although_the_acceptance_of_the_info_was_lost) {
    for (const bool reads_codes : {false, true}) {
        loader = {};
        loader.reads_codes = reads_codes;
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            const bool is_first = f.id() == 0xF0 && loader.infos == 0;
            auto answers = loader.take(fake, f);
            if (!is_first) return answers;
            loader.refuses = true;
            return std::vector<Bytes>{};
        };
        const auto task = run();
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
        EXPECT_EQ(loader.erases, 1u);
    }
    loader = {};
    loader.refuses = true;    // the first refusal is lost
    bool is_lost = false;
    fake.instead = [&](FrameView f) {
        auto answers = loader.take(fake, f);
        return f.id() == 0xF0 && !std::exchange(is_lost, true) ? std::optional{std::vector<Bytes>{}} : answers;
    };
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::refused);
    EXPECT_EQ(task->end()->fault.text(), "0xDC does not want this image");
    EXPECT_FALSE(task->is_left_in_loader());
    EXPECT_EQ(loader.erases, 0u);
}

// The image does not state its hardware, so the device may really refuse it.
TEST_F(Upgrade, does_not_erase_after_a_lost_acceptance_if_the_image_is_not_known_to_fit) {
    const auto ends_refused = [&](FirmwareOptions options) {
        loader = {};
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            const bool is_first = f.id() == 0xF0 && loader.infos == 0;
            auto answers = loader.take(fake, f);
            if (!is_first) return answers;
            loader.refuses = true;
            return std::vector<Bytes>{};
        };
        const auto task = run(std::move(options));
        EXPECT_EQ(task->end()->ending, Ending::refused);
        EXPECT_EQ(
            task->end()->fault.text(),
            "0xDC did not answer the description of the image, and refused it when it came again: it has probably accepted the "
            "first one, and takes no second one until it restarts; nothing was erased: power-cycle it and flash again (with a "
            ".bia for its hardware, without force, the upgrade would have gone on)");
        EXPECT_EQ(loader.erases, 0u);
    };
    FirmwareOptions forced;
    forced.force = true;
    ends_refused(forced);
    image.hw_type = 0;
    image.hw_ver_min = image.hw_ver_max = 0;
    ASSERT_TRUE(image.is_for_any_hardware());
    ends_refused({});
}

TEST_F(Upgrade, repeats_an_erase_with_a_lost_answer_soon_if_the_device_sends_other_frames) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        auto answers = loader.take(fake, f);
        return loader.erases == 1 && loader.frames == 0 ? std::optional{std::vector<Bytes>{}} : answers;
    };
    simulation.each_step = [&](TimePoint now) {
        const Bytes telemetry = support::frame(0xDC, 0xFF, 0x03, Bytes(7));
        device.take(FrameView{telemetry}, now);
    };
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(loader.erases, 2u);
    EXPECT_LT(took, 10s);
}

TEST_F(Upgrade, an_image_for_other_hardware_is_never_sent_unless_forced) {
    image.hw_ver_min = 101;
    EXPECT_EQ(run()->end()->ending, Ending::invalid);
    EXPECT_EQ(loader.infos, 0u);
    EXPECT_EQ(run({.force = true})->end()->ending, Ending::done);
}

TEST_F(Upgrade, of_a_device_without_device_info_requires_stored_info_or_force) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0) return std::vector<Bytes>{};
        return loader.take(fake, f);
    };
    EXPECT_EQ(run()->end()->ending, Ending::timeout);
    EXPECT_EQ(loader.infos, 0u);
    EXPECT_EQ(run({.info = DeviceInfo{0xDC, 100, 1, 1, 1, "fc"}})->end()->ending, Ending::done);
    EXPECT_EQ(run({.force = true})->end()->ending, Ending::done);
}

TEST_F(Upgrade, reports_the_unfinished_state_when_cancelled) {
    Firmware task{device, image};
    simulation.each_step = [&](TimePoint now) {
        if (task.progress().done > 0) task.cancel(now);
    };
    task.start(simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->fault.text(), "cancelled; it is left in its boot loader; start again");
    Firmware early{device, image};
    early.start(simulation.now);
    early.cancel(simulation.now);
    EXPECT_EQ(early.end()->fault.text(), "cancelled, nothing was changed");
}

TEST_F(Upgrade, a_file_that_can_no_longer_be_read_leaves_the_device_in_its_loader) {
    image.bytes = {3000, [](std::size_t at, std::span<std::uint8_t>) { return at < 1000; }};
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::failed);
    EXPECT_EQ(task->end()->fault.text(), "the file can no longer be read; it is left in its boot loader; start again");
    EXPECT_TRUE(task->is_left_in_loader());
}

TEST_F(Upgrade, rejects_an_image_with_more_frames_than_frame_numbers) {
    image.bytes = Bytes(0x10001);
    EXPECT_EQ(run({.frame_len = 1})->end()->ending, Ending::invalid);
    image.bytes = {};
    EXPECT_EQ(run()->end()->ending, Ending::invalid);
}

// Devices in the field send and expect codes high byte first.
TEST_F(Upgrade, sends_codes_in_the_byte_order_of_the_device) {
    loader.reads_codes = true;
    loader.fails_frame_7 = 4;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(loader.flash, bytes_of(3000));
    EXPECT_EQ(task->repeats(), 4u) << "\"frame failed\" is understood as well";
    EXPECT_EQ(fake.heard[2], support::frame(0xFE, 0xDC, 0xF0, {0, 0x01, 0x10})) << "erase, after device info and info";
    loader.reads_codes = false;
    EXPECT_EQ(run()->end()->ending, Ending::done) << "the order is of one upgrade";
}

TEST_F(Upgrade, recognizes_failures_in_both_byte_orders) {
    for (const bool reads : {false, true}) {
        loader = {};
        loader.reads_codes = reads;
        loader.cannot_erase = true;
        EXPECT_EQ(run()->end()->fault.text(), "the device could not erase; it is left in its boot loader; start again");
        loader = {};
        loader.reads_codes = reads;
        loader.refuses = true;
        EXPECT_EQ(run()->end()->fault.text(), "0xDC does not want this image");
        loader = {};
        loader.reads_codes = reads;
        ++image.crc;
        EXPECT_EQ(run()->end()->fault.text(),
                  "the image did not pass the device's check; it is left in its boot loader; start again");
        --image.crc;
    }
}

TEST_F(Upgrade, shows_the_bytes_of_an_invalid_answer) {
    loader.sent_instead = 0x0307;
    const auto task = run();
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC sent 0xF0 with 00 07 03, which is not a valid answer: description of the image");
    EXPECT_EQ(loader.erases, 0u);
}

// The wait for "erased" is up to a minute.
TEST_F(Upgrade, reports_an_invalid_answer_to_the_erase_while_it_waits) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xF0 && f.data()[0] == 0) return std::vector<Bytes>{fake.to_host(f, 0xF0, {0x00, 0x77, 0x12})};
        return loader.take(fake, f);
    };
    Firmware task{device, image, {}};
    task.start(simulation.now);
    simulation.run(task, 1s);
    EXPECT_FALSE(task.end());
    EXPECT_EQ(task.step(), "erasing");
    EXPECT_EQ(task.odd_reply(), "0xDC sent 0xF0 with 00 77 12, which is not a valid answer");
}

// One byte in a hundred is wrong: seven of eight frames of 195 bytes are lost, and one of five orders.
struct Noise : Upgrade {
    struct Result {
        End end;
        Duration took;
        std::size_t frame_len;
        std::string remark;
    };
    Result run_in_noise(std::uint64_t seed, double byte_errors = 0.01) {
        Device other{0xDC};
        Simulation bad{other, fake, {.delay = 5ms, .baud = 115200, .byte_errors = byte_errors}, seed};
        Firmware task{other, image};
        task.start(bad.now);
        const Duration all = bad.run(task, 12h);
        return {task.end().value_or(End{Ending::timeout, {"other", "runs for ever"}, {}}), all, task.frame_len(),
                task.remark().text()};
    }
    Noise() { image = *read_firmware(bia(bytes_of(20'000), 0xDC, 90, 110)).image; }
};

TEST_F(Noise, shortens_the_frames_if_the_loader_accepts_another_info) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        loader = {};
        const auto result = run_in_noise(seed);
        EXPECT_EQ(result.end.ending, Ending::done) << "seed " << seed << ": " << result.end.fault.text();
        EXPECT_EQ(loader.flash, bytes_of(20'000));
        EXPECT_LT(result.frame_len, 195u);
        EXPECT_LT(result.took, 6min);
        EXPECT_NE(result.remark.find("because most longer ones were lost"), std::string::npos) << result.remark;
    }
}

TEST_F(Noise, repeats_the_frames_until_they_are_written_if_the_loader_accepts_no_other_info) {
    for (const auto second : {FakeLoader::SecondInfo::ignores, FakeLoader::SecondInfo::refuses})
        for (std::uint64_t seed = 1; seed <= 30; ++seed) {
            loader = {};
            loader.second_info = second;
            const auto result = run_in_noise(seed);
            EXPECT_EQ(result.end.ending, Ending::done) << "seed " << seed << ": " << result.end.fault.text();
            EXPECT_EQ(loader.flash, bytes_of(20'000));
            EXPECT_EQ(result.frame_len, 195u);
            EXPECT_LT(result.took, 10min);
            EXPECT_EQ(result.remark, "") << "nothing was begun again";
        }
}

struct LostConnection : Upgrade {
    // Both directions are cut once, after frame 5 was written.
    std::unique_ptr<Firmware> run_cut_for(
        Duration time, const std::function<void()>& meanwhile = [] {}) {
        auto task = std::make_unique<Firmware>(device, image);
        std::optional<TimePoint> until;
        simulation.each_step = [&, time, meanwhile](TimePoint now) {
            if (!until && task->progress().done >= 5u * 195) {
                until = now + time;
                meanwhile();
            }
            simulation.there.loss = simulation.back.loss = until && now < *until ? 1 : 0;
        };
        task->start(simulation.now);
        took = simulation.run(*task);
        simulation.each_step = nullptr;
        EXPECT_TRUE(task->end());
        return task;
    }
};

TEST_F(LostConnection, of_a_minute_does_not_restart_the_upgrade_which_continues_after_the_last_frame) {
    const auto task = run_cut_for(60s);
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(loader.flash, bytes_of(3000));
    EXPECT_EQ(loader.erases, 1u);
    EXPECT_EQ(loader.infos, 1u);
    EXPECT_EQ(task->remark().text(), "");
    EXPECT_LT(took, 64s);
}

TEST_F(LostConnection, restarts_the_upgrade_from_the_beginning_if_the_loader_lost_it) {
    for (const bool fails : {true, false}) {
        loader = {};
        loader.fails_when_lost = fails;
        const auto task = run_cut_for(10s, [&] { loader.lose_power(); });
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(loader.flash, bytes_of(3000));
        EXPECT_EQ(loader.erases, 2u);
        EXPECT_EQ(task->end()->fault.text(), "begun again at frame 5, because 0xDC had lost the upgrade");
        EXPECT_LT(took, fails ? 14s : 80s);
    }
}

TEST_F(LostConnection, without_a_return_ends_the_upgrade) {
    const auto task = run_cut_for(1h);
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC stopped answering: sending; it is left in its boot loader; start again");
    EXPECT_LT(took, Firmware::patience_unheard + Firmware::patience + 5s) << "the info that begins it again has its time as well";
}

}    // namespace
}    // namespace ano::host::firmware_tests
