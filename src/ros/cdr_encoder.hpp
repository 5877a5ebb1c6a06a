// Encodes the values of a ROS message as CDR: little-endian, as ROS 2 sends it (XCDR1, encapsulation header 00 01 00 00). Numbers
// are aligned to their size, counted from the end of the header.
#pragma once
#include <ano/reading.hpp>
#include <ros/ros_message.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

/// Allocates only for a message that is longer than all before it.
class CdrEncoder {
public:
    /// `values` has the values of all fields in order, including those of nested messages:
    ///   a number      the number; Nothing becomes NaN, or 0 for an integer type
    ///   text          UTF-8 without NUL
    ///   several uint8 the bytes, as one value
    ///   an array      one value for each element, or for numbers all their bytes, little-endian, as one value
    ///   a sequence    the number of elements as std::uint64_t, then the values
    /// Missing values count as Nothing; a value that does not fit its field becomes 0 or empty. Valid until the next call.
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
    std::string data_;    // a buffer larger than the longest message so far
    std::size_t size_ = 0;
};

}    // namespace anogate
