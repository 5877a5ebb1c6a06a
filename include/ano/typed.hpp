// Access to messages known at compile time: as fast as a packed struct, and a wrong name does not compile.
//
//          if (const auto euler = ano::as<"euler">(frame)) use(euler->get<"rol">());     // degrees
//
//          ano::Draft<"euler"> draft;
//          if (draft.set<"rol">(1.23)) size = draft.encode(out, source, destination);
//
// If a message has several layouts, the name alone means the base layout; the others need their label: as<"power", "field">.
#pragma once
#include <ano/frame.hpp>
#include <ano/reading.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

namespace ano {
namespace detail {

template <Name M, Name Label>
consteval std::size_t row_index() {
    // By index, not by pointer: under UBSan, GCC 12 does not compare an address with null in a constant expression.
    bool named = false;
    for (std::size_t i = 0; i < messages.size(); ++i) {
        if (messages[i].name != M.view()) continue;
        named = true;
        if (messages[i].variant.label == Label.view()) return i;
    }
    if (!named) table_error::no_message_has_this_name();
    table_error::the_message_has_no_such_layout();
    return 0;
}

template <Name M, Name Label>
inline constexpr const Message& row = table::messages[row_index<M, Label>()];

template <Name M, Name Label, Name F>
consteval const Field& field() {
    for (const Field& f : row<M, Label>.fields())
        if (f.name == F.view()) return f;
    table_error::the_layout_has_no_such_field();
    return row<M, Label>.fields().front();
}

// clang-format off
template <Type> struct WireType { using type = std::uint8_t; };
template <> struct WireType<Type::i8> { using type = std::int8_t; };
template <> struct WireType<Type::u16> { using type = std::uint16_t; };
template <> struct WireType<Type::i16> { using type = std::int16_t; };
template <> struct WireType<Type::u32> { using type = std::uint32_t; };
template <> struct WireType<Type::i32> { using type = std::int32_t; };
template <> struct WireType<Type::u64> { using type = std::uint64_t; };
template <> struct WireType<Type::i64> { using type = std::int64_t; };
template <> struct WireType<Type::f32> { using type = float; };
template <> struct WireType<Type::f64> { using type = double; };
// clang-format on

}    // namespace detail

/// DATA of one message in one layout; refers to the memory of the frame.
template <Name M, Name Label = "">
class View {
public:
    /// `data` has at least the fixed part of the layout.
    constexpr explicit View(Bytes data) noexcept : data_{data} {}

    static constexpr const Message& message() noexcept { return detail::row<M, Label>; }

    /// A field in its unit: unscaled integers as they are, scaled ones as double, text up to its first NUL as string_view, all
    /// other types as bytes. If the field has a "no data" value: an optional of that.
    template <Name F>
    constexpr auto get() const noexcept {
        constexpr const Field& f = detail::field<M, Label, F>();
        if constexpr (is_number(f.type) && f.count == 1) {
            const auto wire = load<typename detail::WireType<f.type>::type>(data_.data() + f.offset, f.order);
            const auto value = in_unit<f.scale.is_one()>(wire, f.scale);
            if constexpr (f.no_data.has_value()) return wire == *f.no_data ? std::nullopt : std::optional{value};
            else return value;
        } else if constexpr (f.type == Type::text) {
            return text(bytes<F>());
        } else {
            return bytes<F>();
        }
    }
    /// The bytes of a field as on the wire.
    template <Name F>
    constexpr Bytes bytes() const noexcept {
        constexpr const Field& f = detail::field<M, Label, F>();
        return f.is_open() ? data_.subspan(f.offset) : data_.subspan(f.offset, f.size());
    }
    constexpr Bytes data() const noexcept { return data_; }

private:
    template <bool Unscaled, class T>
    static constexpr auto in_unit(T wire, Scale scale) noexcept {
        if constexpr (Unscaled) return wire;
        else return static_cast<double>(wire) * scale.value / scale.wire;
    }
    static constexpr std::string_view text(Bytes bytes) noexcept {
        const std::string_view whole{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        return whole.substr(0, whole.find('\0'));
    }

    Bytes data_;
};

/// `frame` as that message; std::nullopt: it is another message, has another layout, or is too short.
template <Name M, Name Label = "">
constexpr std::optional<View<M, Label>> as(FrameView frame) noexcept {
    constexpr const Message& row = detail::row<M, Label>;
    const Bytes data = frame.data();
    if (frame.id() != row.id || data.size() < row.fixed_size) return std::nullopt;
    if constexpr (layouts_of(row.id).size() > 1 || row.is_exact())
        if (select_layout(layouts_of(row.id), data) != &row) return std::nullopt;
    return View<M, Label>{data};
}

/// A message to be filled in. All fields are 0 or empty at first, except those that select the layout.
template <Name M, Name Label = "">
class Draft {
public:
    constexpr Draft() noexcept {
        for (const Field& f : message().fields())
            if (f.selects) {
                if (f.type == Type::u8) data_[f.offset] = static_cast<std::uint8_t>(f.selects->first);
                else store(&data_[f.offset], static_cast<std::uint16_t>(f.selects->first), f.order);
            }
    }

    static constexpr const Message& message() noexcept { return detail::row<M, Label>; }

    /// Sets a number in the unit of the field, rounded to the nearest step of the wire. Returns false and changes nothing if the
    /// wire type can't represent it, or if the frame would then have another layout.
    template <Name F, class T>
    requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) [[nodiscard]] bool set(T value) noexcept {
        constexpr const Field& f = detail::field<M, Label, F>();
        static_assert(is_number(f.type) && f.count == 1, "this field is not a number");
        using Wire = typename detail::WireType<f.type>::type;
        if constexpr (f.selects.has_value())
            if (value < static_cast<T>(f.selects->first) || value > static_cast<T>(f.selects->last)) return false;
        if constexpr (std::is_integral_v<T> && std::is_integral_v<Wire> && f.scale.is_one()) {
            if (!std::in_range<Wire>(value)) return false;
            store(data_.data() + f.offset, static_cast<Wire>(value), f.order);
            return true;
        } else {
            return detail::store_double<Wire>(data_.data() + f.offset, static_cast<double>(value), f.scale, f.order) ==
                   Stored::ok;
        }
    }
    /// Sets text, bytes or an address. A field of fixed size stores a copy, padded with 0. For a field of open length, `value`
    /// must stay valid until encode(). Returns false and changes nothing if it is longer than the field.
    template <Name F>
    [[nodiscard]] bool set(Bytes value) noexcept {
        constexpr const Field& f = detail::field<M, Label, F>();
        static_assert(!is_number(f.type) || f.count > 1, "this field is a number");
        if constexpr (f.is_open()) {
            if (value.size() > max_len - message().fixed_size) return false;
            rest_ = value;
        } else {
            if (value.size() > f.size()) return false;
            for (std::size_t i = 0; i < f.size(); ++i) data_[f.offset + i] = i < value.size() ? value[i] : std::uint8_t{0};
        }
        return true;
    }
    template <Name F>
    [[nodiscard]] bool set(std::string_view text) noexcept {
        static_assert(detail::field<M, Label, F>().type == Type::text, "this field is not text");
        return set<F>(Bytes{reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    }
    /// Sets the "no data" value.
    template <Name F>
    void clear() noexcept {
        constexpr const Field& f = detail::field<M, Label, F>();
        static_assert(f.no_data.has_value() || f.type == Type::f32 || f.type == Type::f64,
                      "this field has no value that says \"no data\"");
        store_no_data(f, data_.data() + f.offset);
    }

    std::size_t data_size() const noexcept { return data_.size() + rest_.size(); }
    /// Writes the complete frame to the beginning of `out` and returns its size. Returns 0 and writes nothing if `out` is too
    /// small.
    std::size_t encode(std::span<std::uint8_t> out, std::uint8_t source, std::uint8_t destination) const noexcept {
        const std::size_t size = data_size();
        if (out.size() < overhead + size) return 0;
        const auto frame = out.first(overhead + size);
        write_header(frame, source, destination, message().id, size);
        std::uint8_t* at = frame.data() + header_size;
        for (const std::uint8_t byte : data_) *at++ = byte;
        for (const std::uint8_t byte : rest_) *at++ = byte;
        seal(frame);
        return frame.size();
    }

private:
    std::array<std::uint8_t, detail::row<M, Label>.fixed_size> data_{};
    Bytes rest_;
};

}    // namespace ano
