// The frames that a device has to send, stored until its program sends them.
#pragma once
#include <ano/frame.hpp>
#include <device/profile.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

namespace ano::device {

/// A number that the program assigns to each of its links. A device answers on the link on which the question was received.
using Link = std::uint32_t;
inline constexpr Link every_link = UINT32_MAX;    // for frames that are not answers

/// At most `max_frames` frames wait. Neither throws nor allocates after construction.
class Outgoing {
public:
    static constexpr std::size_t max_frames = 64;

    struct Departure {
        FrameView frame;    // valid until the next call of a non-const function of the device
        Link link;
    };

    /// Memory of `room` bytes for one more frame; nullptr while `max_frames` wait. The argument of commit() is the number of
    /// bytes used; 0: no frame.
    std::uint8_t* prepare() noexcept {
        return waiting_ == max_frames ? nullptr : slots_[(first_ + waiting_) % max_frames].bytes.data();
    }
    void commit(std::size_t size, Link link) noexcept;
    static constexpr std::size_t room = overhead + max_sent;

    /// Removes the oldest waiting frame and returns it; std::nullopt: none waits.
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
