// Reads the values of a ROS message from CDR (XCDR1 of either byte order). The bytes are from other programs: each length is checked.
#pragma once
#include <ano/reading.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Each function returns the next value; after the first value that is not there, zero or empty, and is_good() is false.
class CdrReader {
public:
    /// `data` begins with the encapsulation header and must outlive this object.
    explicit CdrReader(ano::Bytes data) noexcept;

    std::uint32_t u32() noexcept;
    float f32() noexcept;
    double f64() noexcept;
    /// Without the NUL at its end.
    std::string_view text() noexcept;
    /// The number of elements of a sequence whose elements have at least `element` bytes.
    std::size_t count(std::size_t element) noexcept;

    bool is_good() const noexcept { return is_good_; }

private:
    template <class T>
    T number() noexcept;
    ano::Bytes take(std::size_t alignment, std::size_t size) noexcept;

    ano::Bytes data_;    // after the header
    std::size_t at_ = 0;
    bool is_big_endian_ = false, is_good_ = true;
};

/// geometry_msgs/Twist
struct Twist {
    std::array<double, 3> linear{}, angular{};
};
/// sensor_msgs/Joy
struct Joy {
    std::vector<float> axes;
};

/// std::nullopt: the bytes are not such a message.
std::optional<Twist> read_twist(ano::Bytes cdr);
std::optional<Joy> read_joy(ano::Bytes cdr);
/// std_msgs/String
std::optional<std::string> read_string(ano::Bytes cdr);

}    // namespace anogate
