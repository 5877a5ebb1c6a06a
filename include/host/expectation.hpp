// The answer that ends a request (protocol text, section 3).
#pragma once
#include <ano/conversation.hpp>
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>

namespace ano::host {

/// An answer is either the check frame (0x00) that repeats the id and both check bytes of the request, or the answer with data
/// whose content fits: there is no sequence number. Its source must be the device that was asked, and its destination the host
/// that asked.
class Expectation {
public:
    /// The expectation of `request`; std::nullopt for streams and for frames that are not requests, which no answer ends.
    static std::optional<Expectation> of(FrameView request) noexcept;

    /// Whether `frame` ends the request. Answers shorter than their layout do not.
    bool is_met_by(FrameView frame) const noexcept;
    /// Whether `frame` has the form of the answer but does not end the request: an acknowledgement of the right id with other
    /// check bytes, or a step of an upgrade that does not answer this one.
    bool is_missed_by(FrameView frame) const noexcept;
    bool is_acknowledgement() const noexcept { return answer_.is_acknowledgement(); }
    /// A write, a command or a step of an upgrade: only one of these is sent to a device at a time.
    bool is_alone() const noexcept { return is_acknowledgement() || kind_ != Kind::answer; }

    friend bool operator==(const Expectation&, const Expectation&) = default;

private:
    enum class Kind : std::uint8_t {
        answer,    // as in the table of conversations
        firmware_info,
        firmware_erase,
        firmware_frame,
        firmware_check,
    };

    Expectation(FrameView request, Kind kind, Answer answer, std::uint16_t frame_num = 0) noexcept
        : asked_{request.destination()},
          asker_{request.source()},
          id_{request.id()},
          kind_{kind},
          answer_{answer},
          frame_num_{frame_num} {}
    static std::optional<Expectation> of_firmware(FrameView request) noexcept;
    bool is_for_it(FrameView frame) const noexcept;
    bool fits(FrameView frame) const noexcept;
    bool fits_firmware(FrameView frame) const noexcept;

    std::uint8_t asked_;
    std::uint8_t asker_;
    std::uint8_t id_;
    Kind kind_;
    Answer answer_;
    std::uint16_t frame_num_;    // of a frame of the image
};

/// Whether a frame from `source` can be from the device that was asked at `asked`: a port id stands for any device behind the
/// port. The link of the frame is not checked: for a port id, Device::take() must be called only with frames received on the
/// port's links.
bool may_be_of(std::uint8_t source, std::uint8_t asked) noexcept;

}    // namespace ano::host
