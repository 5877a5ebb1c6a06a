// The parser of the vendor's device libraries, which other devices use as well.
#pragma once
#include <ano/frame.hpp>
#include <ano/limits.hpp>
#include <ano/v7.hpp>
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
    explicit VendorParser(bool is_v7 = false, std::size_t max_data = vendor_max_data) : is_v7_{is_v7}, max_data_{max_data} {}

    /// Calls `take` with the bytes of each valid frame, which are valid during the call.
    template <class Take>
    void feed(Bytes bytes, const Take& take) {
        for (const std::uint8_t byte : bytes) {
            if (!ends_frame(byte)) continue;
            if (is_v7_ ? v7::frame_at(frame_).has_value() : frame_at(frame_).has_value()) take(Bytes{frame_});
            frame_.clear();
        }
    }
    /// It waits for the rest of a supposed frame.
    bool is_inside() const noexcept { return !frame_.empty(); }

private:
    bool ends_frame(std::uint8_t byte) {
        if (frame_.empty() && byte != (is_v7_ ? v7::head : head)) return false;
        frame_.push_back(byte);
        if (frame_.size() < (is_v7_ ? v7::header_size : header_size)) return false;
        const std::size_t length = is_v7_ ? frame_[v7::header_size - 1] : load<std::uint16_t>(frame_.data() + header_size - 2);
        if (length > max_data_) frame_.clear();
        return !frame_.empty() && frame_.size() == (is_v7_ ? v7::overhead : overhead) + length;
    }

    bool is_v7_;
    std::size_t max_data_;
    std::vector<std::uint8_t> frame_;
};

}    // namespace ano::world
