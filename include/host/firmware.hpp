// Upgrades the firmware of a device (0xF0; protocol text, section 4).
//
// Flow:    Firmware upgrade{device, *read_firmware(file).image};
//          upgrade.start(now);      // then drive the device until upgrade.end()
//          upgrade.progress(), upgrade.bytes_a_second(now), upgrade.time_left(now), upgrade.repeats()
#pragma once
#include <host/firmware_image.hpp>
#include <host/task.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano::host {

struct FirmwareOptions {
    bool force = false;    // skips the check against the hardware that the device reports
    std::size_t frame_len =
        195;    // bytes of image in a frame: device parsers take 198 bytes of DATA; less where the line takes less
    std::optional<DeviceInfo> info{};    // read earlier, for a device that was left in its loader and may not report it
};

/// Device info, info, erase, each frame until it is "written", all sent, and the device's check of the image. "Erase" is sent once
/// and has 60 s, "all sent" once and 30 s: writing flash takes long, and a loader that gets them twice may start again.
///
/// Done: only after the device said that its check passed. Refused: by the device, before anything was changed. Failed: it could not
/// erase, write or check. Timeout: it fell silent. Invalid: the image is not for it. The text of every failure after the erase says
/// that the device is left in its loader.
class Firmware final : public Task {
public:
    static constexpr std::size_t max_frames = 0x10000;    // frame_num is a u16
    static constexpr unsigned max_failures = 5;           // "frame failed" in a row, of one frame

    Firmware(Device& device, FirmwareImage image, FirmwareOptions options = {});

    void start(TimePoint now);
    /// In bytes written.
    Progress progress() const noexcept override;
    /// Long, since giving up leaves the device in its loader.
    Duration max_duration() const noexcept override {
        return std::chrono::minutes{5} + std::chrono::seconds{2} * static_cast<int>(frames());
    }
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

    /// The step in words: "erasing".
    std::string_view step() const noexcept;
    /// How many times a frame was sent again, after silence or "frame failed".
    std::size_t repeats() const noexcept { return repeats_; }
    /// Since the first frame; 0 before.
    double bytes_a_second(TimePoint now) const noexcept;
    /// Estimate for the remaining frames; std::nullopt before the first is written.
    std::optional<Duration> time_left(TimePoint now) const noexcept;
    /// Whether the old firmware is erased and the new one is not complete: the upgrade must be started again.
    bool is_left_in_loader() const noexcept { return erasing_ && !(end() && end()->ending == Ending::done); }

private:
    enum Step : std::uint32_t { identify, describe, erase, send_frame, check };

    std::string_view half_done() const noexcept override { return erasing_ ? "; it is left in its loader, begin again" : ""; }
    void ask_info(TimePoint now);
    void identified(const Ended& ended, TimePoint now);
    void frame_ended(const Ended& ended, TimePoint now);
    void ask_frame(TimePoint now);
    void ask_step(Step step, std::uint16_t code, Duration wait, TimePoint now);
    void give_up(Ending ending, const std::string& what, const Evidence& evidence, TimePoint now);
    std::size_t frames() const noexcept { return (image_.bytes.size() + options_.frame_len - 1) / options_.frame_len; }

    FirmwareImage image_;
    FirmwareOptions options_;
    Step step_ = identify;
    std::uint32_t frame_ = 0;
    std::vector<std::uint8_t> piece_;    // of the image, in that frame
    unsigned failures_ = 0;
    std::size_t repeats_ = 0;
    bool erasing_ = false;
    std::optional<TimePoint> frames_since_;
};

}    // namespace ano::host
