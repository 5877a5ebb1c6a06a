// The differences between devices in the field and the protocol text. Programs that talk to devices must handle all of them.
#pragma once
#include <ano/frame.hpp>
#include <ano/limits.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>

#include <cstddef>
#include <cstdint>

namespace ano::device {

inline constexpr std::size_t max_sent = vendor_max_data;    // bytes of DATA: every parser in the field accepts this size

/// How a device differs from the protocol text. The defaults follow the protocol text with its rulings.
struct Profile {
    std::size_t max_data = max_len;    // a frame with more bytes of DATA is ignored; sent frames never have more than max_sent
    std::size_t max_string = max_sent - 2;        // bytes of a text parameter: a longer one is truncated, and acknowledged
    ValueType7 value_type_7 = ValueType7::f32;    // of command_info (0xC2)

    bool any_address = false;              // acts on frames for every address, and answers them
    bool acknowledges_unknown = false;     // also 0xE1 of a parameter that it does not have
    bool refuses_beyond_limits = false;    // such a value is not answered; otherwise it is clamped, and acknowledged
    bool reads_behind_the_end = false;     // a value shorter than its type is completed with the check bytes, and stored
    bool crashes_at_the_count = false;     // after access to the id after the last parameter it never answers again
    bool old_layouts = false;              // 0xE2 with min and max, every 0xE1 as i32, the count of 0xC1 in four bytes
    bool scaled_values = false;            // 0xE2 with min, max and mul, every 0xE1 as i32: a real number is multiplied by mul
    bool frames_in_order = false;          // an image frame that is not the next one in order fails
    ByteOrder firmware_order = ByteOrder::little;    // of the codes that it sends (0xF0); it accepts both

    std::size_t queue = 0;    // maximum of waiting frames; further ones are dropped silently. 0: handled immediately
    Duration handling{};      // time for each frame, if there is a queue

    /// The vendor's newest library on a small controller.
    static constexpr Profile vendor() noexcept {
        using std::chrono::milliseconds;
        Profile profile;
        profile.max_data = vendor_max_data;
        profile.max_string = vendor_max_text;
        profile.value_type_7 = ValueType7::u64;
        profile.acknowledges_unknown = true;
        profile.reads_behind_the_end = true;
        profile.crashes_at_the_count = true;
        profile.frames_in_order = true;
        profile.firmware_order = ByteOrder::big;
        profile.queue = 20;
        profile.handling = milliseconds{1};
        return profile;
    }
    constexpr bool sends_i32() const noexcept { return old_layouts || scaled_values; }

    /// The generation between the two: parameters with ranges, and scaled real numbers.
    static constexpr Profile scaled() noexcept {
        Profile profile = vendor();
        profile.max_data = 298;
        profile.value_type_7 = ValueType7::f32;
        profile.scaled_values = true;
        return profile;
    }
    /// The oldest devices: parameters with ranges and without types.
    static constexpr Profile old() noexcept {
        Profile profile = vendor();
        profile.max_data = 298;
        profile.value_type_7 = ValueType7::f32;
        profile.old_layouts = true;
        return profile;
    }
};
}    // namespace ano::device
