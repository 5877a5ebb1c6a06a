// Upgrades the firmware of a device (0xF0; protocol text, section 4).
//
// Flow:    Firmware upgrade{device, *read_firmware(file).image};
//          upgrade.start(now);      // then drive the device until upgrade.end()
//          upgrade.progress(), upgrade.bytes_a_second(now), upgrade.time_left(now), upgrade.repeats()
#pragma once
#include <ano/firmware_codes.hpp>
#include <ano/limits.hpp>
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
    bool force = false;                             // skips the check against the hardware that the device reports
    std::size_t frame_len = vendor_max_data - 3;    // bytes of image in a frame; fewer if the line accepts fewer
    std::optional<DeviceInfo> info{};               // read earlier, for a device left in its loader, which may not report it
};

/// Device info, info, erase, each frame until it is "written", all sent, and the device's check of the image. "Erase" is sent
/// again only after 60 s: flash is slow, and a loader that receives it twice may start again. For "all sent" the wait is 30 s in
/// all.
///
/// The info is repeated for 30 s: a device may restart into its loader first. A device that meanwhile answers other questions,
/// but not the info for `loader_patience`, has no loader: Unsupported.
///
/// The codes are sent in the byte order in which the device accepted the info; no frame with a code is sent before that.
///
/// On a bad line a frame is repeated until it is acknowledged, so an upgrade survives a lost connection. If most frames get lost,
/// a second info proposes shorter ones, as long as less than half is written; if the device does not accept it, the length stays.
/// A device that lost the state of the upgrade (because it was switched off, for instance) fails every frame or does not answer:
/// then the upgrade starts again, once per frame. It also starts again, with the shortest frames, if frames had to be repeated
/// and the image failed the device's check: the two sums of a frame do not detect every error.
///
/// A device that refuses an info after one without an answer may have accepted the earlier one. If the header of the image names
/// its hardware, and `force` is not set, "erase" is sent; if the device erases, the upgrade continues.
///
/// Done: only after the device reported that its check passed. Refused: by the device, before anything was changed. Failed: it
/// could not erase, write or check. Timeout: it does not answer. Invalid: the image is not for it. The text of every failure
/// after the erase states that the device is left in its loader.
class Firmware final : public Task {
public:
    static constexpr std::size_t max_frames = 0x10000;    // frame_num is a u16
    static constexpr unsigned max_failures = 5;           // "frame failed" in a row, of one frame
    static constexpr unsigned max_erases = 4;             // sends of "erase"
    static constexpr unsigned max_restarts = 3;
    static constexpr unsigned max_checks_failed = 2;    // failed checks, each followed by another try
    /// How long a frame is repeated without an answer: while other frames of the device are received, and while none are, as when
    /// the connection is lost.
    static constexpr Duration patience = std::chrono::seconds{30};
    static constexpr Duration patience_unheard = std::chrono::seconds{65};
    /// Counted from the first info. A restart into the loader takes up to 2.5 s.
    static constexpr Duration loader_patience = std::chrono::seconds{3};
    /// How long to wait for the report on the check.
    static constexpr Duration check_patience = std::chrono::seconds{30};
    /// If `judged` frames in a row took `hard` sends or more, shorter ones are proposed, down to `least_len`. A lost connection
    /// counts as `most_sends`.
    static constexpr unsigned judged = 8, hard = 40, most_sends = 15;
    static constexpr std::size_t least_len = 32;

    Firmware(Device& device, FirmwareImage image, FirmwareOptions options = {});

    void start(TimePoint now);
    /// In bytes written.
    Progress progress() const noexcept override;
    /// Long, since a device is left in its loader when the task gives up.
    Duration max_duration() const noexcept override {
        return std::chrono::minutes{10} + std::chrono::seconds{3} * static_cast<int>(frames());
    }
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;
    void on_unfit_answer(FrameView frame) override;
    void not_meant(const Ended& ended, TimePoint now) override;

    /// The last frame in this step that is not an answer, as a clause; empty: none.
    const std::string& odd_reply() const noexcept { return odd_reply_; }
    /// The step as text: "erasing".
    std::string_view step() const noexcept;
    /// How many times a frame was sent again, after a time-out or "frame failed".
    std::size_t repeats() const noexcept { return repeats_; }
    /// How long the device has not answered; 0 before the info is accepted.
    Duration silent_for(TimePoint now) const noexcept { return erasing_ ? now - answered_at_ : Duration{}; }
    /// Deviations from the usual course, as clauses; empty: none.
    const Fault& remark() const noexcept { return remark_; }
    std::size_t frame_len() const noexcept { return options_.frame_len; }
    /// Since the first frame; 0 before it.
    double bytes_a_second(TimePoint now) const noexcept;
    /// Estimate for the remaining frames; std::nullopt before the first is written.
    std::optional<Duration> time_left(TimePoint now) const noexcept;
    /// Whether the old firmware is erased and the new one is not complete: the upgrade must be started again.
    bool is_left_in_loader() const noexcept { return erasing_ && !(end() && end()->ending == Ending::done); }

private:
    enum Step : std::uint32_t { identify, describe, erase, send_frame, check, probe };
    enum class Purpose : std::uint8_t { begin, shorten, begin_again, begin_after_check };    // of an info

    Fault half_done() const override { return erasing_ ? Fault{"left_in_loader"} : Fault{}; }
    void ask_info(Purpose purpose, std::size_t frame_len, TimePoint now);
    void identified(const Ended& ended, TimePoint now);
    void send_info(TimePoint now);
    void probed(bool answers, const Ended& ended, TimePoint now);
    void described(std::optional<FirmwareCode> code, const Ended& ended, TimePoint now);
    void refused(const Evidence& evidence, TimePoint now);
    void begin_erasing(TimePoint now);
    bool is_tried() const noexcept { return is_refused_ && purpose_ == Purpose::begin; }
    void erased(const FirmwareCode& answer, const Ended& ended, TimePoint now);
    void check_failed(const Evidence& evidence, TimePoint now);
    void check_unanswered(const Ended& ended, TimePoint now);
    void frame_ended(std::uint16_t code, const Ended& ended, TimePoint now);
    void unanswered(const Ended& ended, TimePoint now);
    void frame_unanswered(const Ended& ended, TimePoint now);
    bool is_hard() noexcept;
    Patience patience_of_frame() const noexcept;
    void measure(const Evidence& evidence, bool answered, TimePoint now);
    void begin_again(const Fault& why, Ending or_else, const Evidence& evidence, TimePoint now);
    void ask_frame(TimePoint now);
    void ask_order(Step step, TimePoint now);
    Fault silence(const Evidence& evidence) const;
    std::size_t shorter_len() const noexcept;
    void abandon(Ending ending, Fault fault, const Evidence& evidence, TimePoint now);
    std::size_t frames_of(std::size_t len) const noexcept { return (image_.bytes.size() + len - 1) / len; }
    std::size_t frames() const noexcept { return frames_of(options_.frame_len); }

    FirmwareImage image_;
    FirmwareOptions options_;
    Step step_ = identify;
    Purpose purpose_ = Purpose::begin;
    ByteOrder order_ = ByteOrder::little;
    std::size_t asked_len_ = 0;      // in the last info
    TimePoint described_since_{};    // the first info for the same purpose
    bool answers_probes_ = false;    // the last one
    unsigned infos_ = 0;             // sends of those
    bool is_refused_ = false;        // the last of them was refused, and an earlier one may have been accepted
    unsigned checks_failed_ = 0;
    std::uint32_t frame_ = 0;
    std::vector<std::uint8_t> piece_;    // of the image, in that frame
    unsigned orders_ = 0;                // sends of this step
    unsigned failures_ = 0;
    unsigned sends_ = 0;    // of this frame
    unsigned judged_frames_ = 0;
    unsigned judged_sends_ = 0;    // of these frames
    bool may_shorten_ = true;
    unsigned restarts_ = 0;
    std::optional<std::uint32_t> lost_frame_;    // the reason to start again
    Fault lost_because_;
    Ending lost_ending_ = Ending::timeout;
    std::size_t repeats_ = 0;
    bool erasing_ = false;
    TimePoint answered_at_{};
    static constexpr unsigned repeated_enough = 8;
    std::optional<Duration> frame_wait_;    // for an answer to a frame; std::nullopt: not measured yet
    TimePoint asked_at_{};                  // for this frame
    unsigned repeated_in_a_row_ = 0;        // frames
    Fault remark_;
    std::string odd_reply_;
    std::optional<TimePoint> frames_since_;
};

}    // namespace ano::host
