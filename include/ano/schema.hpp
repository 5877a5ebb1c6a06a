// The types for a row of the message table: fields, their types, scales, units and meanings. A mistake in a row is a compile
// error whose text names it.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

namespace ano {

/// Faults of a table, as functions that a constant expression can't call: the error of the compiler contains the name of the
/// function.
namespace table_error {
void two_messages_share_an_id();
void one_name_stands_for_two_messages();
void a_field_is_named_twice();
void a_field_of_open_length_must_be_last();
void a_list_needs_elements_of_fixed_size();
void a_name_is_lower_case_letters_digits_and_underscores();
void a_scale_is_not_zero();
void a_row_has_too_many_fields();
void one_value_has_two_meanings();
void the_wire_type_cannot_hold_this_value();
void the_first_row_of_a_message_is_its_base_layout();
void a_layout_needs_a_length_or_a_mode_of_its_own();
void two_layouts_share_a_label();
void a_layout_before_takes_this_length_already();
void a_layout_is_no_longer_than_its_length();
void another_length_moves_the_fields_so_the_base_layout_is_exact();
void the_layouts_of_a_message_share_its_traffic_class();
void no_message_has_this_name();
void the_message_has_no_such_layout();
void the_layout_has_no_such_field();
}    // namespace table_error

enum class Type : std::uint8_t { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64, text, bytes, ip, frames, list };

inline constexpr std::array<std::string_view, 15> type_names{"u8",  "i8",  "u16",  "i16",   "u32", "i32",    "u64", "i64",
                                                             "f32", "f64", "text", "bytes", "ip",  "frames", "list"};
constexpr std::string_view name_of(Type type) noexcept { return type_names[static_cast<std::size_t>(type)]; }

/// Bytes of one value on the wire; 1 for types whose count is in bytes.
constexpr std::size_t width(Type type) noexcept {
    switch (type) {
    case Type::u16:
    case Type::i16: return 2;
    case Type::u32:
    case Type::i32:
    case Type::f32:
    case Type::ip: return 4;
    case Type::u64:
    case Type::i64:
    case Type::f64: return 8;
    default: return 1;
    }
}
constexpr bool is_integer(Type type) noexcept { return type <= Type::i64; }
constexpr bool is_number(Type type) noexcept { return type <= Type::f64; }

/// A type and the number of its values. In a row: `u16`, `u8[8]`, `text[20]`; without a number, `text`, `bytes`, `frames` and
/// `list` extend to the end of DATA.
struct Shape {
    Type type;
    std::uint16_t count = 1;    // 0: to the end of DATA
    consteval Shape operator[](std::uint16_t n) const { return {type, n}; }
};

/// The number `wire` on the wire means `value` in the unit: {100, 1} is ×100.
struct Scale {
    double wire = 1;
    double value = 1;
    constexpr bool is_one() const noexcept { return wire == value; }
    /// The factor for a wire number, for display; the library divides instead, which rounds only once.
    constexpr double factor() const noexcept { return value / wire; }
    friend constexpr bool operator==(const Scale&, const Scale&) = default;
};

/// The order of the bytes of a number on the wire.
enum class ByteOrder : std::uint8_t { little, big };

/// The meaning of one value of an enumeration.
struct Meaning {
    std::uint32_t value;
    std::string_view text;
};
using Meanings = std::span<const Meaning>;

/// The documented range, in the unit; it is displayed, not enforced.
struct Range {
    double first = 0;
    double last = 0;
    constexpr explicit operator bool() const noexcept { return first != last; }
};
/// The wire value for "no data".
struct NoData {
    std::int64_t wire;
};
/// The layout applies only if the value of the field is from `first` to `last`.
struct Only {
    std::uint32_t first;
    std::uint32_t last;
};
struct Note {
    std::string_view text;
};
/// The object that the value belongs to, if the name is not enough; displayed beside the name.
struct Label {
    std::string_view text;
};

/// The role of a field, in addition to its type.
enum class Role : std::uint8_t {
    plain,
    code,           // a hardware id, a function code or a check byte: displayed in hex
    value,          // bytes: one value, whose type is in parameter_info
    values,         // bytes: packed values, whose types are in command_info
    value_types,    // the types of the values of a command; the meaning of 7 depends on the device (values.hpp)
};

consteval Scale times(double wire, double value = 1) { return {wire, value}; }
consteval Range range(double first, double last) { return {first, last}; }
consteval Only only(std::uint32_t value) { return {value, value}; }
consteval Only only(std::uint32_t first, std::uint32_t last) { return {first, last}; }
consteval Note note(const char* text) { return {text}; }
consteval Label label(const char* text) { return {text}; }

struct Field {
    Type type = Type::u8;
    std::uint16_t count = 1;     // of values, or of bytes for text and bytes; 0: to the end of DATA
    std::uint16_t offset = 0;    // in DATA, or in the element of a list
    Scale scale{};
    std::optional<std::int64_t> no_data{};
    std::optional<Only> selects{};    // the values that select this layout
    std::string_view name{};
    std::string_view unit{};
    std::string_view note{};
    std::string_view label{};
    Meanings meanings{};
    Range range{};
    Role role = Role::plain;
    ByteOrder order = ByteOrder::little;

    constexpr Field() = default;
    template <class... Options>
    consteval Field(std::string_view field_name, Shape shape, const Options&... options)
        : type{shape.type}, count{shape.count}, name{field_name} {
        (set(options), ...);
        check();
    }

    constexpr bool is_open() const noexcept { return count == 0; }
    /// Bytes on the wire; 0 for a field of open length.
    constexpr std::size_t size() const noexcept { return width(type) * count; }
    /// The meaning of `value`; empty: it has none.
    constexpr std::string_view meaning(std::uint64_t value) const noexcept {
        for (const Meaning& m : meanings)
            if (m.value == value) return m.text;
        return {};
    }

private:
    consteval void set(const char* text) { unit = text; }
    consteval void set(Scale s) { scale = s; }
    consteval void set(Meanings m) { meanings = m; }
    consteval void set(Range r) { range = r; }
    consteval void set(NoData n) { no_data = n.wire; }
    consteval void set(Only o) { selects = o; }
    consteval void set(Note n) { note = n.text; }
    consteval void set(Label l) { label = l.text; }
    consteval void set(Role r) { role = r; }
    consteval void set(ByteOrder o) { order = o; }

    consteval bool holds(std::int64_t wire) const {
        if (!is_integer(type)) return false;
        const bool has_sign = type == Type::i8 || type == Type::i16 || type == Type::i32 || type == Type::i64;
        const unsigned bits = static_cast<unsigned>(8 * width(type)) - (has_sign ? 1 : 0);
        if (wire < 0) return has_sign && (bits > 62 || wire >= -(std::int64_t{1} << bits));
        return bits > 62 || wire < std::int64_t{1} << bits;
    }
    consteval void check() const {
        if (name.empty()) table_error::a_name_is_lower_case_letters_digits_and_underscores();
        for (const char c : name)
            if (!(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9') && c != '_')
                table_error::a_name_is_lower_case_letters_digits_and_underscores();
        if (scale.wire == 0 || scale.value == 0) table_error::a_scale_is_not_zero();
        if (no_data && !holds(*no_data)) table_error::the_wire_type_cannot_hold_this_value();
        if (selects && ((type != Type::u8 && type != Type::u16) || !holds(selects->last)))
            table_error::the_wire_type_cannot_hold_this_value();
        for (std::size_t i = 0; i < meanings.size(); ++i) {
            if (!holds(meanings[i].value)) table_error::the_wire_type_cannot_hold_this_value();
            for (std::size_t j = 0; j < i; ++j)
                if (meanings[i].value == meanings[j].value) table_error::one_value_has_two_meanings();
        }
    }
};

enum class TrafficClass : std::uint8_t { urgent, telemetry, bulk };
inline constexpr std::array<std::string_view, 3> traffic_class_names{"urgent", "telemetry", "bulk"};
constexpr std::string_view name_of(TrafficClass c) noexcept { return traffic_class_names[static_cast<std::size_t>(c)]; }

/// Which older frame in a queue a newer one may replace.
enum class Replaces : std::uint8_t {
    nothing,
    same_id,            // of the same source, destination and id
    same_first_byte,    // and with the same first byte of DATA
};

/// How a queue treats the frames of a message (protocol text, section 5).
struct Traffic {
    TrafficClass traffic_class = TrafficClass::bulk;
    Replaces replaces = Replaces::nothing;
    friend constexpr bool operator==(Traffic, Traffic) = default;
};

/// A second layout of a message. It is used for exactly `length` bytes of DATA (0: any length), if its selecting fields match. A
/// base layout with a length, exactly(), has no bytes after it: a longer DATA has an unknown layout.
struct Variant {
    std::string_view label{};
    std::uint16_t length = 0;
    bool by_look = false;    // used if is_plausible() refuses the base layout and accepts this one
};

/// For a base layout if another length has the fields at other offsets: a third length could be either of them.
consteval Variant exactly(std::uint16_t length) { return {"", length, false}; }

inline constexpr std::size_t max_fields = 12;

/// One row of the table: a message in one of its layouts.
struct Message {
    std::uint8_t id = 0;
    std::uint8_t size = 0;             // fields
    std::uint8_t elements = 0;         // fields of each element of the list at the end
    bool selective = false;            // some field must have a certain value
    std::uint16_t fixed_size = 0;      // bytes of DATA without the field of open length
    std::uint16_t element_size = 0;    // bytes of each element
    Traffic traffic{};
    Variant variant{};    // no label: the base layout
    std::string_view name{};
    std::string_view title{};
    std::array<Field, max_fields> storage{};

    consteval Message(std::uint8_t id_, std::string_view name_, std::string_view title_, Traffic traffic_,
                      std::initializer_list<Field> list, Variant variant_ = {})
        : id{id_}, traffic{traffic_}, variant{variant_}, name{name_}, title{title_} {
        for (const Field& field : list) add(field);
        if (ends_in_list() && elements == 0) table_error::a_list_needs_elements_of_fixed_size();
    }

    constexpr std::span<const Field> fields() const noexcept { return {storage.data(), size}; }
    /// The fields of each element of the list at the end; empty: there is none.
    constexpr std::span<const Field> element() const noexcept { return {storage.data() + size, elements}; }
    constexpr bool is_base() const noexcept { return variant.label.empty(); }
    constexpr bool is_open() const noexcept { return size > 0 && storage[size - 1u].is_open(); }
    /// Whether longer DATA has an unknown layout. In periodic messages, some devices insert other fields before these, so that
    /// all are shifted. A message of variable length ends in a field of open length.
    constexpr bool is_exact() const noexcept { return size > 0 && traffic.replaces != Replaces::nothing && !is_open(); }
    constexpr bool ends_in_list() const noexcept { return size > 0 && storage[size - 1u].type == Type::list; }
    constexpr const Field* field(std::string_view field_name) const noexcept {
        for (const Field& f : fields())
            if (f.name == field_name) return &f;
        return nullptr;
    }

private:
    // A field after a list is a field of the list's elements.
    consteval void add(const Field& field) {
        const std::size_t n = std::size_t{size} + elements;
        if (n == max_fields) table_error::a_row_has_too_many_fields();
        for (std::size_t i = 0; i < n; ++i)
            if (storage[i].name == field.name) table_error::a_field_is_named_twice();
        storage[n] = field;
        if (ends_in_list()) {
            if (!is_number(field.type) || field.count != 1) table_error::a_list_needs_elements_of_fixed_size();
            storage[n].offset = element_size;
            element_size = static_cast<std::uint16_t>(element_size + field.size());
            ++elements;
        } else {
            if (is_open()) table_error::a_field_of_open_length_must_be_last();
            storage[n].offset = fixed_size;
            fixed_size = static_cast<std::uint16_t>(fixed_size + field.size());
            selective = selective || field.selects.has_value();
            ++size;
        }
    }
};

/// Whether one layout continues the other, so that the common fields have the same offsets.
consteval bool keep_their_places(const Message& one, const Message& other) {
    for (std::size_t i = 0; i < one.fields().size() && i < other.fields().size(); ++i) {
        const Field &a = one.fields()[i], &b = other.fields()[i];
        if (a.name != b.name || a.type != b.type || a.count != b.count) return false;
    }
    return true;
}

/// The position of the rows of each id.
struct MessageIndex {
    std::array<std::uint8_t, 256> first{};
    std::array<std::uint8_t, 256> count{};    // 0: the id is not listed
};

/// Checks a whole table and indexes it.
consteval MessageIndex index_messages(std::span<const Message> rows) {
    MessageIndex index;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Message& row = rows[i];
        auto& count = index.count[row.id];
        auto& first = index.first[row.id];
        for (std::size_t j = 0; j < i; ++j)
            if (rows[j].name == row.name && rows[j].id != row.id) table_error::one_name_stands_for_two_messages();
        if (count == 0) {
            if (!row.is_base()) table_error::the_first_row_of_a_message_is_its_base_layout();
            if (row.variant.length != 0 && row.variant.length != row.fixed_size)
                table_error::a_layout_is_no_longer_than_its_length();
            first = static_cast<std::uint8_t>(i);
        } else {
            const Message& base = rows[first];
            if (row.is_base() || row.name != base.name || first + count != i) table_error::two_messages_share_an_id();
            if (row.traffic != base.traffic) table_error::the_layouts_of_a_message_share_its_traffic_class();
            if (row.variant.length == 0 && !row.selective && !row.variant.by_look)
                table_error::a_layout_needs_a_length_or_a_mode_of_its_own();
            const std::size_t length = row.variant.length;
            if (length != 0 && length < row.fixed_size) table_error::a_layout_is_no_longer_than_its_length();
            if (length != 0 && base.variant.length == 0 && !keep_their_places(base, row))
                table_error::another_length_moves_the_fields_so_the_base_layout_is_exact();
            for (std::size_t j = first; j < i; ++j) {
                if (rows[j].variant.label == row.variant.label) table_error::two_layouts_share_a_label();
                if (length != 0 && length == rows[j].variant.length && !rows[j].selective)
                    table_error::a_layout_before_takes_this_length_already();
            }
        }
        ++count;
    }
    return index;
}

/// A name as a template argument: as<"euler">(frame).
template <std::size_t N>
struct Name {
    char text[N]{};
    consteval Name(const char (&s)[N]) {
        for (std::size_t i = 0; i < N; ++i) text[i] = s[i];
    }
    constexpr std::string_view view() const noexcept { return {text, N - 1}; }
};

}    // namespace ano
