#include <ano/wire.hpp>
#include <device/value.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ano::device {

std::pair<Value, Value> range_of(Type type) {
    return with_type(type, []<class T>(T) {
        return std::pair{to_value(std::numeric_limits<T>::lowest()), to_value(std::numeric_limits<T>::max())};
    });
}

Value zero_of(Type type) {
    if (type == Type::text) return std::string{};
    return with_type(type, []<class T>(T zero) { return to_value(zero); });
}

bool is_nan(const Value& value) noexcept {
    const auto* number = std::get_if<double>(&value);
    return number != nullptr && std::isnan(*number);
}

bool fits(const Value& value, Type type) noexcept {
    if (type == Type::text) return std::holds_alternative<std::string>(value);
    const auto [first, last] = range_of(type);
    return value.index() == first.index() && !is_nan(value) && first <= value && value <= last;
}

Value read_value(Type type, Bytes bytes) {
    if (type == Type::text) {
        const auto end = std::find(bytes.begin(), bytes.end(), std::uint8_t{0});
        return std::string{bytes.begin(), end};
    }
    return with_type(type, [&]<class T>(T) { return to_value(load<T>(bytes.data())); });
}

void append_value(std::vector<std::uint8_t>& out, Type type, const Value& value) {
    if (type == Type::text) {
        const auto text = from_value<std::string>(value);
        out.insert(out.end(), text.begin(), text.end());
        if (text.empty()) out.push_back(0);
        return;
    }
    with_type(type, [&]<class T>(T) {
        std::array<std::uint8_t, sizeof(T)> bytes;
        store(bytes.data(), from_value<T>(value));
        out.insert(out.end(), bytes.begin(), bytes.end());
    });
}

std::int32_t as_i32(const Value& value, std::int32_t factor) noexcept {
    constexpr auto first = std::numeric_limits<std::int32_t>::min();
    constexpr auto last = std::numeric_limits<std::int32_t>::max();
    if (factor != 1) return as_i32(Value{from_value<double>(value) * factor});
    if (const auto* number = std::get_if<std::int64_t>(&value))
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(*number, first, last));
    if (const auto* number = std::get_if<std::uint64_t>(&value))
        return static_cast<std::int32_t>(std::min<std::uint64_t>(*number, last));
    const auto* number = std::get_if<double>(&value);
    if (number == nullptr || std::isnan(*number)) return 0;
    return static_cast<std::int32_t>(std::clamp<double>(std::round(*number), first, last));
}

Value from_i32(Type type, std::int32_t number, std::int32_t factor) {
    if (type == Type::text) return std::string{};
    return with_type(type, [&]<class T>(T) {
        if constexpr (std::is_floating_point_v<T>) return to_value(static_cast<T>(static_cast<double>(number) / factor));
        else if (std::in_range<T>(number)) return to_value(static_cast<T>(number));
        else return to_value(number < 0 ? std::numeric_limits<T>::lowest() : std::numeric_limits<T>::max());
    });
}

}    // namespace ano::device
