// How many requests may be on their way to a device.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>

namespace ano::host {

/// Opens by one for each answer, to 8: field devices queue 20 frames and drop the rest silently. Halves only when more than half of the
/// last 16 sends were lost: on a radio that loses one in ten, a loss says nothing about how much the device can take.
class Window {
public:
    static constexpr std::size_t max_size = 8;
    static constexpr int remembered = 16;    // sends

    std::size_t size() const noexcept { return size_; }
    void answered() noexcept {
        note(0);
        if (size_ < max_size) ++size_;
    }
    void lost() noexcept {
        note(1);
        if (2 * std::popcount(losses_) <= remembered) return;
        size_ = size_ > 1 ? size_ / 2 : 1;
        losses_ = 0;    // earlier losses say nothing about the smaller window
    }

private:
    void note(std::uint16_t loss) noexcept { losses_ = static_cast<std::uint16_t>(losses_ << 1 | loss); }

    std::size_t size_ = 1;
    std::uint16_t losses_ = 0;    // a bit for each of the last sends
};

}    // namespace ano::host
