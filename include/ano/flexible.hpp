// Layouts of the flexible messages (0xF1 to 0xFA), which the user defines (protocol text, section 4).
#pragma once
#include <ano/messages.hpp>

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace ano {

/// The definition of one value in the configuration.
struct FlexibleField {
    std::string name;
    Type type = Type::u8;    // u8 to i32, or f32
    double scale = 1;        // value = number on the wire × scale; not 0
    std::string unit;
    std::uint16_t count = 1;    // above 1: an array
    bool operator==(const FlexibleField&) const = default;
};

/// The definition of a message in the configuration.
struct FlexibleSpec {
    std::uint8_t id = 0;
    std::optional<std::uint8_t> source{};    // as FlexibleLayout::source()
    std::vector<FlexibleField> fields{};
    ByteOrder endian = ByteOrder::little;    // of all its numbers
    std::optional<std::uint32_t> when{};     // as FlexibleLayout::when()
    bool operator==(const FlexibleSpec&) const = default;
};

class FlexibleLayout {
public:
    std::uint8_t id() const noexcept { return id_; }
    /// Only frames of this source have this layout; std::nullopt: frames of every source.
    std::optional<std::uint8_t> source() const noexcept { return source_; }
    /// Only frames whose first field has this value have this layout; std::nullopt: frames with any value.
    std::optional<std::uint32_t> when() const noexcept { return when_; }
    std::span<const Field> fields() const noexcept { return fields_; }
    /// Its index in FlexibleLayouts::all().
    std::size_t place() const noexcept { return place_; }
    /// The minimum number of bytes of DATA.
    std::uint16_t size() const noexcept { return size_; }

private:
    friend class FlexibleLayouts;

    std::size_t place_ = 0;    // among all layouts
    std::uint8_t id_ = 0;
    std::optional<std::uint8_t> source_;
    std::optional<std::uint32_t> when_;
    std::vector<Field> fields_;    // their names and units refer to texts_
    std::deque<std::string> texts_;
    std::uint16_t size_ = 0;
};

/// Looking up neither allocates nor throws.
class FlexibleLayouts {
public:
    FlexibleLayouts() = default;
    explicit FlexibleLayouts(std::span<const FlexibleSpec> specs) {
        for (const FlexibleSpec& spec : specs) add(spec);
    }
    FlexibleLayouts(FlexibleLayouts&&) = default;    // a moved layout keeps its address
    FlexibleLayouts& operator=(FlexibleLayouts&&) = default;
    FlexibleLayouts(const FlexibleLayouts&) = delete;
    FlexibleLayouts& operator=(const FlexibleLayouts&) = delete;

    /// Why a layout was refused.
    enum class Fault : std::uint8_t {
        none,
        id,           // not 0xF1 to 0xFA
        duplicate,    // there is already a layout for this id, source and value of the first field
        no_fields,
        name,        // empty, not unique, or with '=' or a control character
        type,        // not one of u8 i8 u16 i16 u32 i32 f32
        scale,       // 0, or not finite
        count,       // 0
        when,        // the first field is not one u8, u16 or u32 without a scale, or can't have this value
        too_long,    // more bytes than LEN can express
    };
    /// `field` is the index of the faulty field; it has no meaning for faults of the layout itself.
    struct Refusal {
        Fault fault = Fault::none;
        std::size_t field = 0;
        explicit operator bool() const noexcept { return fault != Fault::none; }
    };

    Refusal add(const FlexibleSpec& spec);
    Refusal add(std::uint8_t id, std::optional<std::uint8_t> source, std::span<const FlexibleField> fields) {
        return add({.id = id, .source = source, .fields = {fields.begin(), fields.end()}});
    }

    /// The layout of `data` in a frame `id` of `source`. A layout for this source precedes one for every source. Among these, one
    /// for the value of the first field precedes one for every value. nullptr: there is none. Valid as long as this object.
    const FlexibleLayout* find(std::uint8_t id, std::uint8_t source, std::span<const std::uint8_t> data) const noexcept;
    /// The layouts of `id` for frames of `source`, in the order of find().
    std::vector<const FlexibleLayout*> layouts_for(std::uint8_t id, std::uint8_t source) const;
    bool has_layout_for(std::uint8_t id, std::uint8_t source) const noexcept;
    /// The name of a field and its integer value.
    struct Named {
        std::string_view name;
        std::uint32_t value = 0;
    };
    /// The layouts_for(id, source) that are selected by the first field, if that is one of `fields`, and those without a
    /// selecting field. The time does not depend on the number of layouts.
    std::vector<const FlexibleLayout*> layouts_for(std::uint8_t id, std::uint8_t source, std::span<const Named> fields) const;
    const std::deque<FlexibleLayout>& all() const noexcept { return layouts_; }

private:
    // The layouts of an id and source with the same type of first field, by its value; or the only one for every value.
    struct Group {
        std::uint8_t id = 0;
        std::optional<std::uint8_t> source;
        std::optional<Field> selector;
        std::unordered_map<std::uint32_t, const FlexibleLayout*> by_value;    // of the first field; 0: the only one

        bool is_for(std::uint8_t of_id, std::uint8_t of_source) const noexcept {
            return id == of_id && (!source || *source == of_source);
        }
        const FlexibleLayout* with(std::uint32_t value) const noexcept;
        const FlexibleLayout* find(std::span<const std::uint8_t> data) const noexcept;
    };
    Group& group_of(const FlexibleLayout& layout);

    std::deque<FlexibleLayout> layouts_;
    std::vector<Group> groups_;    // few: there are only a few types of first fields
};

std::string_view to_string(FlexibleLayouts::Fault fault) noexcept;

}    // namespace ano
