#include <ros/cdr_encoder.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace anogate {
namespace {

constexpr std::string_view cdr_head{"\0\1\0\0", 4};

template <class T>
T number_of(const ano::Value& value) noexcept {
    if (const auto* real = std::get_if<double>(&value)) {
        if constexpr (std::is_floating_point_v<T>) return static_cast<T>(*real);
        else return T{};    // real numbers occur only in floating-point fields
    }
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<T>(*whole);
    if (const auto* whole = std::get_if<std::uint64_t>(&value)) return static_cast<T>(*whole);
    return std::is_floating_point_v<T> && std::holds_alternative<ano::Nothing>(value) ? std::numeric_limits<T>::quiet_NaN() : T{};
}

constexpr std::size_t size_of(RosType type) noexcept {
    switch (type) {
    case RosType::int16:
    case RosType::uint16: return 2;
    case RosType::int32:
    case RosType::uint32:
    case RosType::float32: return 4;
    case RosType::int64:
    case RosType::uint64:
    case RosType::float64: return 8;
    default: return 1;
    }
}

constexpr std::size_t max_gap = 8;

}    // namespace

std::string_view CdrEncoder::encode(const RosMessage& message, std::span<const ano::Value> values) {
    values_ = values;
    size_ = 0;
    std::copy(cdr_head.begin(), cdr_head.end(), room(1, cdr_head.size()));
    write_message(message);
    return {data_.data(), size_};
}

const ano::Value& CdrEncoder::next() noexcept {
    static const ano::Value nothing{};
    if (values_.empty()) return nothing;
    const ano::Value& value = values_.front();
    values_ = values_.subspan(1);
    return value;
}

void CdrEncoder::write_message(const RosMessage& message) {
    for (const RosField& field : message.fields) write_field(field);
    if (message.fields.empty()) write(std::uint8_t{});
}

void CdrEncoder::write_field(const RosField& field) {
    if (field.shape == RosField::Shape::one) return write_one(field);
    if (field.type == RosType::uint8) return write_bytes(field);
    std::size_t count = field.count;
    if (field.shape == RosField::Shape::array && !values_.empty() && std::holds_alternative<ano::Bytes>(values_.front()))
        return write_raw(std::get<ano::Bytes>(next()), size_of(field.type), count * size_of(field.type));
    if (field.shape == RosField::Shape::sequence) {
        // The number is one of the values and may be wrong: the number of values limits it.
        count = number_of<std::uint32_t>(next());
        count = std::min(count, values_.size());
        write(static_cast<std::uint32_t>(count));
    }
    for (std::size_t i = 0; i < count; ++i) write_one(field);
}

void CdrEncoder::write_one(const RosField& field) {
    if (field.type == RosType::message) return write_message(*field.message);
    const ano::Value& value = next();
    if (field.type != RosType::text) return write_number(field.type, value);
    const auto* text = std::get_if<std::string_view>(&value);
    write_text(text != nullptr ? *text : std::string_view{});
}

void CdrEncoder::write_number(RosType type, const ano::Value& value) {
    switch (type) {
    case RosType::boolean: return write<std::uint8_t>(number_of<std::int64_t>(value) != 0 ? 1 : 0);
    case RosType::int8: return write(number_of<std::int8_t>(value));
    case RosType::byte:
    case RosType::uint8: return write(number_of<std::uint8_t>(value));
    case RosType::int16: return write(number_of<std::int16_t>(value));
    case RosType::uint16: return write(number_of<std::uint16_t>(value));
    case RosType::int32: return write(number_of<std::int32_t>(value));
    case RosType::uint32: return write(number_of<std::uint32_t>(value));
    case RosType::int64: return write(number_of<std::int64_t>(value));
    case RosType::uint64: return write(number_of<std::uint64_t>(value));
    case RosType::float32: return write(number_of<float>(value));
    case RosType::float64: return write(number_of<double>(value));
    case RosType::text:
    case RosType::message: return;
    }
}

void CdrEncoder::write_bytes(const RosField& field) {
    const auto* given = std::get_if<ano::Bytes>(&next());
    const ano::Bytes bytes = given != nullptr ? *given : ano::Bytes{};
    if (field.shape == RosField::Shape::array) return write_raw(bytes, 1, field.count);
    write(static_cast<std::uint32_t>(bytes.size()));
    write_raw(bytes, 1, bytes.size());
}

// Writes exactly `size` bytes: truncates, or appends zeros.
void CdrEncoder::write_raw(ano::Bytes bytes, std::size_t alignment, std::size_t size) {
    bytes = bytes.first(std::min(bytes.size(), size));
    char* const at = room(alignment, size);
    std::fill(std::copy(bytes.begin(), bytes.end(), at), at + size, '\0');
}

void CdrEncoder::write_text(std::string_view text) {
    write(static_cast<std::uint32_t>(text.size() + 1));
    char* const at = room(1, text.size() + 1);
    *std::copy(text.begin(), text.end(), at) = '\0';
}

template <class T>
void CdrEncoder::write(T value) {
    ano::store(reinterpret_cast<std::uint8_t*>(room(sizeof value, sizeof value)), value);
}

char* CdrEncoder::room(std::size_t alignment, std::size_t size) {
    const std::size_t gap = (cdr_head.size() - size_) & (alignment - 1);
    if (data_.size() < size_ + max_gap + size) [[unlikely]]
        grow(size_ + max_gap + size);
    char* const at = data_.data() + size_;
    std::memset(at, 0, max_gap);
    size_ += gap + size;
    return at + gap;
}

void CdrEncoder::grow(std::size_t size) { data_.resize(std::max(2 * data_.size(), size)); }

}    // namespace anogate
