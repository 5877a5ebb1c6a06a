// Access to the fields of a frame for code that finds out at run time which message it is: tools, taps, filters.
//
// Flow:    const ano::Reading reading = ano::read(frame);
//          if (reading) for (const ano::Field& field : reading.fields()) use(field.name, reading.value(field));
//
// For messages that are known at compile time: see typed.hpp.
#pragma once
#include <ano/flexible.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/wire.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <variant>

namespace ano {

struct Nothing {
    friend constexpr bool operator==(Nothing, Nothing) = default;
};
using Bytes = std::span<const std::uint8_t>;

/// `Nothing` for the wire value for "no data". Unscaled integers as integers, other numbers as double, in the unit of the field;
/// text up to its first NUL, in the encoding of the sender; all other types as bytes.
using Value = std::variant<Nothing, std::int64_t, std::uint64_t, double, std::string_view, Bytes>;

enum class Readable : std::uint8_t {
    yes,
    unknown_id,
    unknown_layout,    // a mode or a length without a layout, or a flexible message without a configured layout
    too_short,         // malformed: fewer bytes than the layout has
};

/// Whether `bytes` are text, in UTF-8 or GBK, without control characters, and only NULs follow its first NUL.
constexpr bool is_padded_text(Bytes bytes) noexcept {
    bool is_over = false;
    for (const std::uint8_t byte : bytes) {
        if (is_over ? byte != 0 : byte != 0 && (byte < 0x20 || byte == 0x7F)) return false;
        is_over = is_over || byte == 0;
    }
    return true;
}

/// Whether `data` is plausible in this layout: it is long enough, integers are in their documented range, and each text of fixed
/// size begins with a printable character. In a layout that is selected by plausibility (Variant::by_look), such a text is valid
/// to its end, and `min` is not above `max`.
constexpr bool is_plausible(const Message& row, Bytes data) noexcept {
    if (data.size() < row.fixed_size) return false;
    if (row.variant.by_look) {
        const Field* const min = row.field("min");
        const Field* const max = row.field("max");
        if (min != nullptr && max != nullptr &&
            load<std::int32_t>(data.data() + min->offset) > load<std::int32_t>(data.data() + max->offset))
            return false;
    }
    for (const Field& f : row.fields()) {
        const std::uint8_t* at = data.data() + f.offset;
        if (f.type == Type::text && !f.is_open()) {
            if (*at < 0x20 || *at == 0x7F || *at == 0x80 || *at == 0xFF) return false;
            if (row.variant.by_look && !is_padded_text(data.subspan(f.offset, f.size()))) return false;
        }
        if (!f.range || !is_integer(f.type)) continue;
        const double wire = with_type(f.type, [&]<class T>(T) { return static_cast<double>(load<T>(at, f.order)); });
        const double value = wire * f.scale.value / f.scale.wire;
        if (value < f.range.first || value > f.range.last) return false;
    }
    return true;
}

/// The row of `layouts` (all of one message, the base first) that matches `data`; nullptr: none of them does.
constexpr const Message* select_layout(std::span<const Message> layouts, Bytes data) noexcept {
    const auto matches = [&](const Message& row) {
        // DATA shorter than the base layout is malformed, even if its length differs.
        const std::size_t length = row.variant.length;
        if (length != 0 && (row.is_base() ? data.size() > length : data.size() != length)) return false;
        if (row.is_exact() && data.size() > row.fixed_size) return false;
        if (row.variant.by_look && (is_plausible(layouts.front(), data) || !is_plausible(row, data))) return false;
        if (!row.selective) return true;
        for (const Field& f : row.fields()) {
            if (!f.selects) continue;
            if (data.size() < f.offset + f.size()) return false;
            const std::uint32_t v = f.type == Type::u8 ? data[f.offset] : load<std::uint16_t>(data.data() + f.offset, f.order);
            if (v < f.selects->first || v > f.selects->last) return false;
        }
        return true;
    };
    for (const Message& row : layouts.subspan(layouts.empty() ? 0 : 1))
        if (matches(row)) return &row;
    return !layouts.empty() && matches(layouts.front()) ? &layouts.front() : nullptr;
}

/// The number that begins at `at`, in the unit of `field`.
inline double number_at(const Field& field, const std::uint8_t* at) noexcept {
    return with_type(field.type, [&]<class T>(T) {
        return static_cast<double>(load<T>(at, field.order)) * field.scale.value / field.scale.wire;
    });
}

/// The value of one number that begins at `at`.
inline Value value_at(const Field& field, const std::uint8_t* at) noexcept {
    return with_type(field.type, [&]<class T>(T) -> Value {
        const T wire = load<T>(at, field.order);
        if constexpr (std::is_integral_v<T>) {
            if (field.no_data && static_cast<std::int64_t>(wire) == *field.no_data) return Nothing{};
            if (field.scale.is_one()) {
                if constexpr (std::is_same_v<T, std::uint64_t>) return wire;
                else return static_cast<std::int64_t>(wire);
            }
        }
        return static_cast<double>(wire) * field.scale.value / field.scale.wire;
    });
}

/// The result of read(). Refers to the memory of the frame, and to its layout.
class Reading {
public:
    constexpr Reading(Readable readable, const Message* message, std::span<const Field> fields, std::size_t fixed_size,
                      Bytes data) noexcept
        : fields_{fields}, data_{data}, message_{message}, fixed_size_{fixed_size}, readable_{readable} {}

    /// False: only message(), readable(), fixed_size() and data() are meaningful.
    explicit operator bool() const noexcept { return readable_ == Readable::yes; }
    Readable readable() const noexcept { return readable_; }
    /// The row; the base layout if no layout matches; nullptr for an id that is not listed.
    const Message* message() const noexcept { return message_; }
    Bytes data() const noexcept { return data_; }
    /// The minimum bytes of DATA of the layout.
    std::size_t fixed_size() const noexcept { return fixed_size_; }

    std::span<const Field> fields() const noexcept { return fields_; }
    const Field* field(std::string_view name) const noexcept {
        for (const Field& f : fields_)
            if (f.name == name) return &f;
        return nullptr;
    }

    /// `field` is one of fields(). The value of an array or a list is its bytes.
    Value value(const Field& field) const noexcept {
        if (is_number(field.type) && field.count == 1) return value_at(field, data_.data() + field.offset);
        const Bytes bytes = bytes_of(field);
        if (field.type != Type::text) return bytes;
        const auto* first = reinterpret_cast<const char*>(bytes.data());
        const std::string_view text{first, bytes.size()};
        return text.substr(0, text.find('\0'));
    }
    /// `field`, which must be a number, as a double; "no data" is NaN.
    double number(const Field& field) const noexcept {
        if (field.no_data && std::holds_alternative<Nothing>(value(field))) return std::nan("");
        return number_at(field, data_.data() + field.offset);
    }
    /// All bytes of a field as on the wire.
    Bytes bytes_of(const Field& field) const noexcept {
        return field.is_open() ? data_.subspan(field.offset, open_size()) : data_.subspan(field.offset, field.size());
    }

    /// The fields of each element of the list at the end.
    std::span<const Field> element_fields() const noexcept {
        return message_ == nullptr ? std::span<const Field>{} : message_->element();
    }
    std::size_t element_count() const noexcept { return element_fields().empty() ? 0 : open_size() / message_->element_size; }
    /// `field` is one of element_fields(), `i` less than element_count().
    Value element(std::size_t i, const Field& field) const noexcept {
        return value_at(field, data_.data() + fixed_size_ + i * message_->element_size + field.offset);
    }

    /// The bytes after the layout: they are legal, and their meaning is not known.
    Bytes extra() const noexcept {
        const bool open = !fields_.empty() && fields_.back().is_open();
        return data_.subspan(fixed_size_ + (open ? open_size() : 0));
    }

private:
    std::size_t open_size() const noexcept {
        const std::size_t rest = data_.size() - fixed_size_;
        return fields_.back().type == Type::list ? rest - rest % message_->element_size : rest;
    }

    std::span<const Field> fields_;
    Bytes data_;
    const Message* message_;
    std::size_t fixed_size_;
    Readable readable_;
};

/// Reads DATA of `id` in one of `layouts` (all of one message, the base first; empty: the id is not listed).
inline Reading read_in(std::span<const Message> layouts, std::uint8_t id, Bytes data, const FlexibleLayouts* flexible = nullptr,
                       std::uint8_t source = 0) noexcept {
    const auto fitting = [&](const Message* row, std::span<const Field> fields, std::size_t size) {
        return Reading{data.size() < size ? Readable::too_short : Readable::yes, row, fields, size, data};
    };
    if (layouts.empty()) return {Readable::unknown_id, nullptr, {}, 0, data};
    if (is_flexible(id)) {
        const FlexibleLayout* layout = flexible == nullptr ? nullptr : flexible->find(id, source, data);
        if (layout != nullptr) return fitting(&layouts.front(), layout->fields(), layout->size());
        return {Readable::unknown_layout, &layouts.front(), {}, 0, data};
    }
    const Message* row = select_layout(layouts, data);
    if (row != nullptr) return fitting(row, row->fields(), row->fixed_size);
    const Message& base = layouts.front();
    // Without its selecting field it is malformed in any mode.
    const bool has_mode = data.size() > base.fields().front().offset;
    return {has_mode ? Readable::unknown_layout : Readable::too_short, &base, {}, base.fixed_size, data};
}

/// Reads DATA of `id`. `flexible` contains the layouts of flexible messages, which depend on `source`.
inline Reading read(std::uint8_t id, Bytes data, const FlexibleLayouts* flexible = nullptr, std::uint8_t source = 0) noexcept {
    return read_in(layouts_of(id), id, data, flexible, source);
}

inline Reading read(FrameView frame, const FlexibleLayouts* flexible = nullptr) noexcept {
    return read(frame.id(), frame.data(), flexible, frame.source());
}

}    // namespace ano
