// The parser of the vendor's device libraries, which other devices use as well.
#pragma once
#include <ano/frame.hpp>
#include <ano/limits.hpp>
#include <ano/wire.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ano::world {

/// Waits for as many bytes as a header announces, without a time limit, and does not search for a header among them. So after one
/// flipped bit of LEN it receives no frames until enough other bytes have arrived. Bytes before a header are skipped.
class VendorParser {
public:
    /// A header whose LEN is above `max_data` is skipped.
    explicit VendorParser(std::size_t max_data = vendor_max_data) : max_data_{max_data} {}

    /// Calls `take` with each valid frame, which is valid during the call.
    template <class Take>
    void feed(Bytes bytes, const Take& take) {
        for (const std::uint8_t byte : bytes) {
            if (!ends_frame(byte)) continue;
            if (const auto frame = frame_at(frame_)) take(*frame);
            frame_.clear();
        }
    }
    /// It waits for the rest of a supposed frame.
    bool is_inside() const noexcept { return !frame_.empty(); }

private:
    bool ends_frame(std::uint8_t byte) {
        if (frame_.empty() && byte != head) return false;
        frame_.push_back(byte);
        if (frame_.size() < header_size) return false;
        const std::size_t length = load<std::uint16_t>(frame_.data() + header_size - 2);
        if (length > max_data_) frame_.clear();
        return !frame_.empty() && frame_.size() == overhead + length;
    }

    std::size_t max_data_;
    std::vector<std::uint8_t> frame_;
};

}    // namespace ano::world
