// Receives an image like a boot loader (protocol text, section 4, 0xF0): info, erase, frames, all sent, check.
//
// Flow:    device.firmware().allow({.max_size = 1 << 20, .install = [](const Image& image) { return write(image); }});
#pragma once
#include <ano/crc16.hpp>
#include <ano/firmware_codes.hpp>
#include <ano/time.hpp>
#include <ano/typed.hpp>
#include <device/info.hpp>
#include <device/outgoing.hpp>
#include <device/profile.hpp>
#include <device/reply.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace ano::device {

/// The description of an image in 0xF0 0x01. For a .bin, all fields except size, frame size and CRC are 0.
struct ImageInfo {
    std::uint32_t size = 0;          // bytes
    std::uint16_t frame_size = 0;    // bytes of image in each frame but the last, which may be shorter
    std::uint16_t crc = 0;
    std::uint16_t version = 0;
    std::uint8_t hw_type = 0;        // 0: for any
    std::uint16_t hw_ver_min = 0;    // both 0: for any
    std::uint16_t hw_ver_max = 0;
    std::uint32_t cmd = 0;
};

/// A complete image with a correct CRC.
struct Image {
    ImageInfo info;
    Bytes bytes;    // valid during the call
};

/// Which images the device accepts, and how it installs them.
struct Flash {
    std::size_t max_size = 0;                          // bytes of an image; the memory is allocated at erase
    std::function<bool(const Image&)> install{};       // true: passed
    std::function<bool(const ImageInfo&)> accept{};    // called after the device's own checks; empty: yes
    std::function<bool()> erase{};                     // false: erase failed; empty: no erase is necessary
    std::uint8_t hw_type = 0;                          // 0: the device's id
    std::optional<Crc16> crc = usual_crc16;            // std::nullopt: not checked
    Duration erase_time{}, check_time{};               // delay of the answer, to simulate slow flash
};

class Firmware {
public:
    enum class State : std::uint8_t { idle, accepted, erasing, receiving, checking, passed, failed };

    Firmware(const Info& info, const Profile& profile) noexcept : device_{info}, profile_{profile} {}

    /// Before this is called, the device does not answer 0xF0.
    void allow(Flash flash) { flash_ = std::move(flash); }

    State state() const noexcept { return state_; }
    /// The description of the image that was accepted last.
    const ImageInfo& image() const noexcept { return image_; }
    /// The number of different frames that were written.
    std::size_t written() const noexcept { return written_; }

    Outcome process(const View<"firmware", "info">& info, Reply& reply);
    Outcome process(const View<"firmware", "image">& frame, Reply& reply);
    /// Handles "erase" and "all sent"; the other codes are answers. The frames after "erase" are answered in its byte order.
    Outcome process(const FirmwareCode& code, TimePoint now, Reply& reply);

    /// When the answer to a slow step is due; std::nullopt: none is in progress.
    std::optional<TimePoint> due() const noexcept { return due_; }
    /// Ends the slow step if it is due; returns the answer and its receiver.
    struct Late {
        Asker asker;
        Draft<"firmware"> answer;
    };
    std::optional<Late> run(TimePoint now);

private:
    Outcome erase(TimePoint now, Reply& reply);
    Outcome check(TimePoint now, Reply& reply);
    std::uint16_t end_erasing();
    std::uint16_t end_checking();
    Outcome send_code(Reply& reply, std::uint16_t code) const noexcept { return reply.send(firmware_step(code, order_)); }
    bool is_ours(const ImageInfo& info) const;
    bool store(std::size_t number, Bytes bytes);
    std::size_t frames() const noexcept { return (image_.size + image_.frame_size - 1u) / image_.frame_size; }

    const Info& device_;
    const Profile& profile_;
    Flash flash_;
    ImageInfo image_;
    State state_ = State::idle;
    ByteOrder order_ = ByteOrder::little;
    std::optional<Asker> asker_;    // the sender of the image
    std::optional<TimePoint> due_;
    std::vector<std::uint8_t> bytes_;
    std::vector<bool> has_;    // by frame: whether it was written
    std::size_t written_ = 0;
};

}    // namespace ano::device
