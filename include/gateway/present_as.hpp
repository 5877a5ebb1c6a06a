// Shows every host to the devices of a link under one address, because some devices answer only 0xFE.
#pragma once
#include <ano/conversation.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace anogate {

/// Shows all hosts to one link, or to a group of links, under one address. Frames of hosts get that address and new checks. A
/// frame of a device to that address goes to the host that asked for it. A value is matched by the requested number. An
/// acknowledgement (0x00) is matched by its checks, which are changed back to those of the host's frame. If several hosts asked
/// the same, those without an answer come first, then the oldest question. A host that has the address itself is treated like the
/// others. Unrequested frames are not changed.
///
/// Questions are stored for `memory`, at most 256; the oldest are replaced. The sender of a firmware update is stored for
/// `session`. No allocation after construction.
class PresentAs {
public:
    static constexpr ano::Duration memory = std::chrono::seconds{5};
    /// A device may erase its flash for some time before it answers (0xF0).
    static constexpr ano::Duration session = std::chrono::seconds{60};

    /// `max_data` of the link: larger frames pass unchanged, and the outbox refuses them.
    PresentAs(std::uint8_t address, std::size_t max_data);

    std::uint8_t address() const noexcept { return address_; }
    /// The port id of the link: a frame to it reaches devices of any address.
    void add_port(std::uint8_t id) noexcept { everybody_.set(id); }
    /// Call when no link has this port id any more.
    void remove_port(std::uint8_t id) noexcept { everybody_.reset(id); }
    /// Adds a link with this `max_data`. Allocates if it is larger than that of the earlier links.
    void make_room(std::size_t max_data);

    /// Returns a frame to the link as its devices see it. Its source becomes `address` if it is a host address (0xFE, 0xD2), or
    /// if only hosts send such a frame: questions, commands, parameters, waypoints, sticks, firmware. Measurements of other
    /// devices, frames to a host and frames from a device of the link keep their source. `number`, above 0, is the number of the
    /// frame in the gateway: a frame that is sent on several channels is one question. Valid until the next call.
    ano::FrameView outbound(ano::FrameView frame, std::uint64_t number, ano::TimePoint now) noexcept;
    /// Returns a frame from the link as other links see it: addressed to the host that asked for it. Valid until the next call.
    ano::FrameView inbound(ano::FrameView frame, ano::TimePoint now) noexcept;

private:
    using Addresses = std::bitset<256>;

    /// A question that waits for its answers.
    struct Question {
        ano::TimePoint at{};
        Addresses answered_by;    // a question to all devices has one answer from each
        std::uint8_t asker = 0;
        std::uint8_t to = 0;
        ano::Checks checks{};    // of the frame as the asker sent it
    };
    struct Session {
        ano::TimePoint at = ano::TimePoint::min();
        std::uint8_t asker = 0;
    };

    void remember(ano::FrameView sent, ano::FrameView original, ano::TimePoint now) noexcept;
    const Question* asked(ano::Answer answer, std::uint8_t device, ano::TimePoint now) noexcept;
    std::optional<std::uint8_t> updater(std::uint8_t device, ano::TimePoint now) const noexcept;
    bool reaches(std::uint8_t destination, std::uint8_t device) const noexcept {
        return destination == device || everybody_[destination];
    }
    static constexpr std::size_t capacity = 256;    // a power of two

    std::uint8_t address_;
    std::size_t max_size_;
    Addresses everybody_;                         // destinations that reach any device: 0xFF, and the port ids of the links
    Addresses devices_;                           // devices of the link, known by frames to `address`
    std::unique_ptr<std::uint8_t[]> in_, out_;    // two buffers: an answer may be sent on to another host of the link
    std::uint64_t last_number_ = 0;
    std::size_t last_size_ = 0;    // of the frame in out_

    // The questions from first_ to end_, each at its number modulo the capacity. Their answers are stored separately, because a
    // search reads only the answers of the questions that do not match.
    std::unique_ptr<ano::Answer[]> answers_;
    std::unique_ptr<Question[]> questions_;
    std::size_t first_ = 0, end_ = 0;
    std::unique_ptr<Session[]> sessions_;    // by the address to which the firmware was sent
};

}    // namespace anogate
