// What ends a request (protocol text, section 3).
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>

namespace ano::host {

/// Either the check frame (0x00) that repeats the id and both check bytes of the request, or the answer with data that fits by its
/// content: there is no sequence number. It must come from the device that was asked and be addressed to the host that asked.
class Expectation {
public:
    /// What ends `request`; std::nullopt for streams and for frames that are no requests, which nothing ends.
    static std::optional<Expectation> of(FrameView request) noexcept;

    /// Whether `frame` ends the request. Answers shorter than their layout do not.
    bool is_met_by(FrameView frame) const noexcept;
    /// Whether `frame` is of the kind that ends the request, and does not: an acknowledgement of the right id with other check bytes, or a
    /// step of an upgrade that is no answer to this one.
    bool is_missed_by(FrameView frame) const noexcept;
    /// Whether a frame with this id can end any request at all. Most frames of devices are sent without a request and can't.
    static bool may_be_met_by(std::uint8_t id) noexcept;
    bool is_acknowledgement() const noexcept { return kind_ == Kind::acknowledgement; }
    /// A write, a command or a step of an upgrade: a device gets one of these at a time.
    bool is_alone() const noexcept { return kind_ == Kind::acknowledgement || kind_ >= Kind::firmware_info; }

    friend bool operator==(const Expectation&, const Expectation&) = default;

private:
    enum class Kind : std::uint8_t {
        acknowledgement,
        device_info,
        parameter_count,
        parameter_value,
        parameter_info,
        command_count,
        command_info,
        waypoint_count,
        waypoint,
        firmware_info,
        firmware_erase,
        firmware_frame,
        firmware_check,
    };

    Expectation(FrameView request, Kind kind, std::uint16_t about = 0) noexcept
        : asked_{request.destination()}, asker_{request.source()}, kind_{kind}, about_{about} {}
    static std::optional<Expectation> of_firmware(FrameView request) noexcept;
    bool is_for_it(FrameView frame) const noexcept;
    bool fits(FrameView frame) const noexcept;
    bool fits_firmware(FrameView frame) const noexcept;

    std::uint8_t asked_;
    std::uint8_t asker_;
    Kind kind_;
    std::uint16_t about_;    // the number of a parameter, command, waypoint or frame; of an acknowledgement the id of the request
    Checks checks_{};        // of an acknowledgement
};

/// Whether a frame from `source` can be of the device that was asked at `asked`: a port id stands for any device behind the port. The
/// link of the frame is not checked: the caller gives Device::take() of a port id only frames that came by the port's links.
bool may_be_of(std::uint8_t source, std::uint8_t asked) noexcept;

}    // namespace ano::host
