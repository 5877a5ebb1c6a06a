// The values of a ROS message as CDR: little-endian, as ROS 2 sends it (XCDR1, encapsulation header 00 01 00 00). Numbers stand at
// multiples of their size, counted from behind the header.
#pragma once
#include <ano/reading.hpp>
#include <ros/ros_message.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

/// Allocates only for a message that is longer than every one before.
class CdrEncoder {
public:
    /// `values` are those of the fields in their order, of a message in a message in its place:
    ///   a number      as such; Nothing is NaN, and 0 where the type has none
    ///   text          UTF-8 without NUL
    ///   several uint8 their bytes, as one value
    ///   an array      so many values, or of numbers their bytes, little-endian, as one
    ///   a sequence    their number as std::uint64_t, then the values
    /// What is missing is Nothing; what does not fit its field is 0 or empty. Valid until the next call.
    std::string_view encode(const RosMessage& message, std::span<const ano::Value> values);

private:
    const ano::Value& next() noexcept;
    void write_message(const RosMessage& message);
    void write_field(const RosField& field);
    void write_one(const RosField& field);
    void write_number(RosType type, const ano::Value& value);
    void write_bytes(const RosField& field);
    void write_raw(ano::Bytes bytes, std::size_t alignment, std::size_t size);
    void write_text(std::string_view text);
    template <class T>
    void write(T value);
    char* room(std::size_t alignment, std::size_t size);
    void grow(std::size_t size);

    std::span<const ano::Value> values_;
    std::string data_;    // longer than the longest message so far
    std::size_t size_ = 0;
};

}    // namespace anogate
