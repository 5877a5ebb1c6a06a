// Finds frames that a V7 device must not receive within the frames that are sent to it.
#pragma once
#include <ano/v7.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate {

/// Whether DATA of 0xE0 are the command that erases the firmware of an LX IMU.
constexpr bool v7_erases_firmware(std::span<const std::uint8_t> command) noexcept {
    return command.size() >= 3 && command[0] == 0x01 && command[1] == 0x20 && command[2] == 0xAA;
}

/// For one line. A device that lost the header of a frame searches in the rest, where it may find another one, which begins in the
/// DATA of one frame and ends in those of a later one. No allocation.
class V7NestedFrames {
public:
    enum class Found : std::uint8_t {
        nothing,
        within,          // the frame is one that the device must not receive, or contains one
        begun_before,    // it completes one that began in frames before
    };

    /// Whether a device without knowledge of the sender would take a frame with this id for a measurement of its own.
    static constexpr bool is_of_own_sensor(std::uint8_t id) noexcept {
        return (id >= 0x01 && id <= 0x0F) || id == 0x20 || id == 0x21;
    }

    /// A frame to be sent next. Unless nothing is found, it must not be sent, and is not added.
    Found add(std::span<const std::uint8_t> frame) noexcept {
        std::span<const std::uint8_t> all = frame;
        if (size_ > 0) {
            std::copy(frame.begin(), frame.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
            all = std::span{bytes_}.first(size_ + frame.size());
        }
        std::size_t unfinished = all.size();
        for (auto at = all.begin(); (at = std::find(at, all.end(), ano::v7::head)) != all.end(); ++at) {
            const std::span<const std::uint8_t> rest{at, all.end()};
            const auto found = rest.size() == frame.size() ? std::optional{ano::v7::FrameView{frame}} : ano::v7::frame_at(rest);
            if (found && is_forbidden(*found)) {
                is_erasing_ = found->id() == 0xE0;
                return rest.size() > frame.size() ? Found::begun_before : Found::within;
            }
            if (!found && is_unfinished(rest)) unfinished = std::min(unfinished, all.size() - rest.size());
        }
        std::copy(all.begin() + static_cast<std::ptrdiff_t>(unfinished), all.end(), bytes_.begin());
        size_ = all.size() - unfinished;
        return Found::nothing;
    }
    /// What was found last: the command that erases firmware; otherwise a measurement.
    bool is_erasing() const noexcept { return is_erasing_; }
    /// The connection was lost.
    void reset() noexcept { size_ = 0; }

private:
    static constexpr bool is_forbidden(ano::v7::FrameView frame) noexcept {
        return is_of_own_sensor(frame.id()) || (frame.id() == 0xE0 && v7_erases_firmware(frame.data()));
    }
    // Whether a frame that must not be received begins here and may be completed by the next ones.
    static constexpr bool is_unfinished(std::span<const std::uint8_t> rest) noexcept {
        if (rest.size() > 2 && !is_of_own_sensor(rest[2]) && rest[2] != 0xE0) return false;
        return rest.size() < ano::v7::header_size || rest.size() < ano::v7::overhead + rest[3];
    }

    // The bytes from the first unfinished frame on, at most max_frame_size - 1, and room for the next frame.
    std::array<std::uint8_t, 2 * ano::v7::max_frame_size> bytes_{};
    std::size_t size_ = 0;
    bool is_erasing_ = false;
};

}    // namespace anogate
