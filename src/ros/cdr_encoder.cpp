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
    return std::visit(
        []<class V>(const V& v) -> T {
            if constexpr (std::is_same_v<V, ano::Nothing>) {
                return std::is_floating_point_v<T> ? std::numeric_limits<T>::quiet_NaN() : T{};
            } else if constexpr (std::is_integral_v<V>) {
                return static_cast<T>(v);
            } else if constexpr (std::is_same_v<V, double>) {
                if constexpr (std::is_floating_point_v<T>) return static_cast<T>(v);
                else return T{};    // no integer field is given one
            } else {
                return T{};
            }
        },
        value);
}

}    // namespace

std::string_view CdrEncoder::encode(const RosMessage& message, std::span<const ano::Value> values) {
    values_ = values;
    size_ = 0;
    std::copy(cdr_head.begin(), cdr_head.end(), room(1, cdr_head.size()));
    write_message(message);
    return {data_.data(), size_};
}

ano::Value CdrEncoder::next() noexcept {
    if (values_.empty()) return ano::Nothing{};
    const ano::Value value = values_.front();
    values_ = values_.subspan(1);
    return value;
}

void CdrEncoder::write_message(const RosMessage& message) {
    for (const RosField& field : message.fields) write_field(field);
    if (message.fields.empty()) write(std::uint8_t{});
}

void CdrEncoder::write_field(const RosField& field) {
    using enum RosField::Shape;
    if (field.shape == one) return write_one(field);
    if (field.type == RosType::uint8) return write_bytes(field);
    std::size_t count = field.count;
    if (field.shape == sequence) {
        // No more elements than there are values: the number came with them.
        count = std::min<std::size_t>(number_of<std::uint32_t>(next()), values_.size());
        write(static_cast<std::uint32_t>(count));
    }
    for (std::size_t i = 0; i < count; ++i) write_one(field);
}

void CdrEncoder::write_one(const RosField& field) {
    if (field.type == RosType::message) return write_message(*field.message);
    const ano::Value value = next();
    if (field.type != RosType::text) return write_number(field.type, value);
    const auto* text = std::get_if<std::string_view>(&value);
    write_text(text != nullptr ? *text : std::string_view{});
}

void CdrEncoder::write_number(RosType type, const ano::Value& value) {
    switch (type) {
    case RosType::boolean: return write<std::uint8_t>(number_of<std::int64_t>(value) != 0 ? 1 : 0);
    case RosType::int8: return write(number_of<std::int8_t>(value));
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
    const ano::Value value = next();
    const auto* given = std::get_if<ano::Bytes>(&value);
    ano::Bytes bytes = given != nullptr ? *given : ano::Bytes{};
    std::size_t size = bytes.size();
    if (field.shape == RosField::Shape::array) {
        size = field.count;
        bytes = bytes.first(std::min(bytes.size(), size));
    } else {
        write(static_cast<std::uint32_t>(size));
    }
    char* const at = room(1, size);
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
    if (data_.size() < size_ + gap + size) data_.resize(std::max(2 * data_.size(), size_ + gap + size));
    char* const at = data_.data() + size_;
    std::fill(at, at + gap, '\0');
    size_ += gap + size;
    return at + gap;
}

}    // namespace anogate
