// The frames that a device has to send, until its program takes them.
#pragma once
#include <ano/frame.hpp>
#include <device/profile.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace ano::device {

/// The number that the program gives to a way by which frames come and go. A device answers on the link that the question came by.
using Link = std::uint32_t;
inline constexpr Link every_link = UINT32_MAX;    // of what nobody asked for

/// At most `max_frames` frames wait. Neither throws nor allocates after construction.
class Outgoing {
public:
    static constexpr std::size_t max_frames = 64;

    struct Departure {
        FrameView frame;    // valid until the device is next told or asked anything
        Link link;
    };

    /// Memory for one more frame, and then how many of its bytes were used; 0: none. Null while `max_frames` wait.
    std::uint8_t* prepare() noexcept {
        return waiting_ == max_frames ? nullptr : slots_[(first_ + waiting_) % max_frames].bytes.data();
    }
    void commit(std::size_t size, Link link) noexcept;
    static constexpr std::size_t room = overhead + max_sent;

    /// The oldest one, which waits no more.
    std::optional<Departure> next() noexcept;
    std::size_t waiting() const noexcept { return waiting_; }

private:
    struct Slot {
        std::array<std::uint8_t, room> bytes;
        std::size_t size;
        Link link;
    };
    std::unique_ptr<Slot[]> slots_ = std::make_unique<Slot[]>(max_frames);
    std::size_t first_ = 0;
    std::size_t waiting_ = 0;
};

}    // namespace ano::device
