// Layouts of the flexible messages (0xF1 to 0xFA), which the user defines (protocol text, sections 1.3 and 4).
#pragma once
#include <ano/messages.hpp>

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ano {

/// The definition of one value in the configuration.
struct FlexibleField {
    std::string name;
    Type type = Type::u8;    // u8 to i32, or f32
    double scale = 1;        // value = what is on the wire × scale; not 0
    std::string unit;
    bool operator==(const FlexibleField&) const = default;
};

/// What a user wrote for a message.
struct FlexibleSpec {
    std::uint8_t id = 0;
    std::optional<std::uint8_t> source;    // as FlexibleLayout::source()
    std::vector<FlexibleField> fields;
    bool operator==(const FlexibleSpec&) const = default;
};

class FlexibleLayout {
public:
    std::uint8_t id() const noexcept { return id_; }
    /// The only source whose frames have this layout; std::nullopt: the frames of every source have it.
    std::optional<std::uint8_t> source() const noexcept { return source_; }
    std::span<const Field> fields() const noexcept { return fields_; }
    /// The minimum number of bytes of DATA.
    std::uint16_t size() const noexcept { return size_; }

private:
    friend class FlexibleLayouts;
    std::uint8_t id_ = 0;
    std::optional<std::uint8_t> source_;
    std::vector<Field> fields_;    // their names and units refer to texts_
    std::deque<std::string> texts_;
    std::uint16_t size_ = 0;
};

/// Built once, when the configuration is read; looking up neither allocates nor throws.
class FlexibleLayouts {
public:
    /// Why a layout was refused.
    enum class Fault : std::uint8_t {
        none,
        id,           // not 0xF1 to 0xFA
        duplicate,    // the same id and source have a layout already
        no_fields,
        name,        // empty, with '=' or a control character in it, or given twice
        type,        // not one of u8 i8 u16 i16 u32 i32 f32
        scale,       // 0, or not finite
        too_long,    // more bytes than LEN can express
    };
    /// `field` is the index of the faulty field; it has no meaning for faults of the layout itself.
    struct Refusal {
        Fault fault = Fault::none;
        std::size_t field = 0;
        explicit operator bool() const noexcept { return fault != Fault::none; }
    };

    Refusal add(std::uint8_t id, std::optional<std::uint8_t> source, std::span<const FlexibleField> fields);

    /// The layout of `id` for frames of `source`: the one for this source, else the one for every source, else null. Valid as long
    /// as this object.
    const FlexibleLayout* find(std::uint8_t id, std::uint8_t source) const noexcept;
    const std::deque<FlexibleLayout>& all() const noexcept { return layouts_; }

private:
    std::deque<FlexibleLayout> layouts_;
};

std::string_view text_of(FlexibleLayouts::Fault fault) noexcept;

}    // namespace ano
