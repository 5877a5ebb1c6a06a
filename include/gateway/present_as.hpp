// Lets every host speak to the devices of a link under one address: some answer 0xFE only.
#pragma once
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

/// The hosts of one link, or of a group of links, all under one address. What they send gets that address, both checks
/// included; what a device sends to that address goes to who asked for it: a value by the number asked for, an
/// acknowledgement (0x00) by its checks, which become those of the frame as the asker sent it. Of several who asked the
/// same, those that had no answer yet come first, then the oldest; who bears the address itself is one of them. What
/// nobody asked for stays as it is.
///
/// Questions are remembered for `memory`, 256 of them, the oldest forgotten; who updates a firmware, for `session`. No
/// allocation after construction.
class PresentAs {
public:
    static constexpr ano::Duration memory = std::chrono::seconds{5};
    /// A device may erase for a while before it says so (0xF0).
    static constexpr ano::Duration session = std::chrono::seconds{60};

    /// `max_data` of the link: what is larger passes unchanged, for the outbox to refuse.
    PresentAs(std::uint8_t address, std::size_t max_data);

    std::uint8_t address() const noexcept { return address_; }
    /// The port id of the link: what is sent to it reaches devices of any address.
    void add_port(std::uint8_t id) noexcept { everybody_.set(id); }
    /// No link has it any more.
    void remove_port(std::uint8_t id) noexcept { everybody_.reset(id); }
    /// One more link, of this `max_data`. Allocates when that is more than any had.
    void make_room(std::size_t max_data);

    /// A frame to the link as its devices are to see it: from `address`, when the host addresses (0xFE, 0xD2) sent it, or
    /// anybody what only a host says: questions, commands, parameters, waypoints, sticks, firmware. The measurements of
    /// other devices stay theirs, and so do what is for a host and what came from a device of the link. `number` tells which frame of the gateway it is, above
    /// 0: one that goes to several channels is one question. Valid until the next call.
    ano::FrameView outbound(ano::FrameView frame, std::uint64_t number, ano::TimePoint now) noexcept;
    /// A frame from the link as the others are to see it: to who asked for it. Valid until the next call.
    ano::FrameView inbound(ano::FrameView frame, ano::TimePoint now) noexcept;

private:
    using Addresses = std::bitset<256>;

    /// One that waits for its answers.
    struct Question {
        ano::TimePoint at{};
        Addresses answered_by;    // a question to everybody has many answers, one a device
        std::uint8_t asker = 0;
        std::uint8_t to = 0;
        ano::Checks checks{};    // as the asker sent it
    };
    struct Session {
        ano::TimePoint at = ano::TimePoint::min();
        std::uint8_t asker = 0;
    };

    void remember(ano::FrameView sent, ano::FrameView original, ano::TimePoint now) noexcept;
    const Question* asked(std::uint32_t key, std::uint8_t device, ano::TimePoint now) noexcept;
    std::optional<std::uint8_t> updater(std::uint8_t device, ano::TimePoint now) const noexcept;
    bool reaches(std::uint8_t destination, std::uint8_t device) const noexcept {
        return destination == device || everybody_[destination];
    }
    static constexpr std::size_t capacity = 256;    // a power of two

    std::uint8_t address_;
    std::size_t max_size_;
    Addresses everybody_;                         // destinations that are nobody's own: 0xFF, and the port ids of the links
    Addresses devices_;                           // of the link: they have written to `address`
    std::unique_ptr<std::uint8_t[]> in_, out_;    // apart: an answer may go on to another host of the link
    std::uint64_t last_number_ = 0;
    std::size_t last_size_ = 0;    // of what is in out_

    // The questions from first_ to end_, each at its number modulo the capacity. What answers them stands apart: it is
    // all that a search reads of those that do not fit.
    std::unique_ptr<std::uint32_t[]> keys_;
    std::unique_ptr<Question[]> questions_;
    std::size_t first_ = 0, end_ = 0;
    std::unique_ptr<Session[]> sessions_;    // by the address that the firmware was sent to
};

}    // namespace anogate
