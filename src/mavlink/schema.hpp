// The types for a row of the table of MAVLink messages. The order on the wire and CRC_EXTRA are computed from the row.
#pragma once
#include <ano/schema.hpp>
#include <mavlink/crc.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>

namespace anogate::mavlink {

/// Faults of a table, as functions that a constant expression can't call.
namespace table_error {
void a_row_has_too_many_fields();
void a_payload_has_at_most_255_bytes();
void no_message_has_this_name();
void the_message_has_no_such_field();
}    // namespace table_error

inline constexpr std::size_t max_payload = 255;

struct Field {
    std::string_view name{};
    ano::Type type = ano::Type::u8;
    std::uint8_t count = 1;     // of values, or of bytes for text
    std::uint8_t offset = 0;    // in the payload
    bool is_extension = false;

    constexpr Field() = default;
    consteval Field(std::string_view field_name, ano::Shape shape)
        : name{field_name}, type{shape.type}, count{static_cast<std::uint8_t>(shape.count)} {}
    constexpr std::size_t size() const noexcept { return ano::width(type) * count; }
};

/// One row of the table. Its fields are in the order of their definition.
struct Message {
    static constexpr std::size_t max_fields = 21;

    std::uint32_t id = 0;
    std::uint8_t crc_extra = 0;    // as published
    std::uint8_t base_size = 0;    // bytes of the payload without extensions
    std::uint8_t size = 0;         // with extensions
    std::uint8_t count = 0;        // of fields
    std::string_view name{};
    std::array<Field, max_fields> storage{};

    consteval Message(std::uint32_t id_, std::string_view name_, std::uint8_t crc_extra_, std::initializer_list<Field> base,
                      std::initializer_list<Field> extensions = {})
        : id{id_}, crc_extra{crc_extra_}, name{name_} {
        if (base.size() + extensions.size() > max_fields) table_error::a_row_has_too_many_fields();
        for (const Field& field : base) storage[count++] = field;
        std::size_t end = 0;
        for (std::size_t width = max_width; width > 0; width /= 2)
            for (Field& field : std::span{storage}.first(count))
                if (ano::width(field.type) == width) end = place(field, end);
        base_size = static_cast<std::uint8_t>(end);
        for (const Field& field : extensions) {
            storage[count] = field;
            storage[count].is_extension = true;
            end = place(storage[count++], end);
        }
        size = static_cast<std::uint8_t>(end);
    }

    constexpr std::span<const Field> fields() const noexcept { return {storage.data(), count}; }
    constexpr const Field* field(std::string_view field_name) const noexcept {
        for (const Field& field : fields())
            if (field.name == field_name) return &field;
        return nullptr;
    }
    /// CRC_EXTRA of this row, by which both sides of a link notice that their definitions differ.
    constexpr std::uint8_t computed_crc_extra() const noexcept {
        Crc crc;
        crc.add(name);
        crc.add(" ");
        for (std::size_t width = max_width; width > 0; width /= 2)
            for (const Field& field : fields())
                if (ano::width(field.type) == width && !field.is_extension) add(crc, field);
        return static_cast<std::uint8_t>(crc.value() ^ crc.value() >> 8);
    }

private:
    static constexpr std::size_t max_width = 8;

    static consteval std::size_t place(Field& field, std::size_t at) {
        if (at + field.size() > max_payload) table_error::a_payload_has_at_most_255_bytes();
        field.offset = static_cast<std::uint8_t>(at);
        return at + field.size();
    }
    static constexpr void add(Crc& crc, const Field& field) noexcept {
        crc.add(type_name(field.type));
        crc.add(" ");
        crc.add(field.name);
        crc.add(" ");
        if (field.count > 1) crc.add(field.count);
    }
    static constexpr std::string_view type_name(ano::Type type) noexcept {
        switch (type) {
        case ano::Type::u8: return "uint8_t";
        case ano::Type::i8: return "int8_t";
        case ano::Type::u16: return "uint16_t";
        case ano::Type::i16: return "int16_t";
        case ano::Type::u32: return "uint32_t";
        case ano::Type::i32: return "int32_t";
        case ano::Type::u64: return "uint64_t";
        case ano::Type::i64: return "int64_t";
        case ano::Type::f32: return "float";
        case ano::Type::f64: return "double";
        default: return "char";
        }
    }
};

}    // namespace anogate::mavlink
