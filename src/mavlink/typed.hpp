// Payloads with the fields of the table; a wrong name does not compile.
//   Draft<"MISSION_ACK"> ack;  ack.set<"type">(1);
//   if (const auto ack = as<"MISSION_ACK">(packet)) use(ack->get<"type">());
#pragma once
#include <ano/typed.hpp>
#include <ano/wire.hpp>
#include <mavlink/packet.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

namespace anogate::mavlink {

/// Rounded, and limited to what T can hold; NaN becomes 0.
template <class T>
T limited(double value) noexcept {
    if (std::isnan(value)) return 0;
    if (value <= static_cast<double>(std::numeric_limits<T>::lowest())) return std::numeric_limits<T>::lowest();
    if (value >= static_cast<double>(std::numeric_limits<T>::max())) return std::numeric_limits<T>::max();
    return static_cast<T>(std::round(value));
}

/// A payload to be sent. All fields are 0 at first.
template <ano::Name M>
class Draft {
public:
    static constexpr const Message& row = table::row_called(M.view());

    /// Floating-point values of an integer field are rounded, and limited to what it can hold.
    template <ano::Name F, class V>
    Draft& set(V value, std::size_t index = 0) noexcept {
        constexpr Field field = table::field_called(row, F.view());
        static_assert(field.type != ano::Type::text, "set_text");
        using Wire = typename ano::detail::WireType<field.type>::type;
        std::uint8_t* const at = payload_.data() + field.offset + index * sizeof(Wire);
        if constexpr (std::is_floating_point_v<V> && !std::is_floating_point_v<Wire>) ano::store(at, limited<Wire>(value));
        else ano::store(at, static_cast<Wire>(value));
        return *this;
    }
    /// What does not fit is cut off.
    template <ano::Name F>
    Draft& set_text(std::string_view text) noexcept {
        constexpr Field field = table::field_called(row, F.view());
        static_assert(field.type == ano::Type::text);
        std::copy_n(text.begin(), std::min<std::size_t>(text.size(), field.count), payload_.begin() + field.offset);
        return *this;
    }
    std::span<const std::uint8_t> payload() const noexcept { return payload_; }

private:
    std::array<std::uint8_t, row.size> payload_{};
};

/// A payload that was received. Fields that were left out are 0.
template <ano::Name M>
class View {
public:
    static constexpr const Message& row = table::row_called(M.view());

    explicit View(std::span<const std::uint8_t> payload) noexcept {
        std::copy_n(payload.begin(), std::min<std::size_t>(payload.size(), row.size), payload_.begin());
    }

    /// A number, or text up to its first NUL.
    template <ano::Name F>
    auto get(std::size_t index = 0) const noexcept {
        constexpr Field field = table::field_called(row, F.view());
        const std::uint8_t* const at = payload_.data() + field.offset;
        if constexpr (field.type == ano::Type::text) {
            const std::string_view whole{reinterpret_cast<const char*>(at), field.count};
            return whole.substr(0, whole.find('\0'));
        } else {
            using Wire = typename ano::detail::WireType<field.type>::type;
            return ano::load<Wire>(at + index * sizeof(Wire));
        }
    }

private:
    std::array<std::uint8_t, row.size> payload_{};
};

/// std::nullopt: it is another message.
template <ano::Name M>
std::optional<View<M>> as(PacketView packet) noexcept {
    if (packet.id() != View<M>::row.id) return std::nullopt;
    return View<M>{packet.payload()};
}

}    // namespace anogate::mavlink
