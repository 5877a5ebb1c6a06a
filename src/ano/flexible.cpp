#include <ano/flexible.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <cmath>

namespace ano {
namespace {

using LayoutFault = FlexibleLayouts::Fault;

bool is_allowed(Type type) noexcept { return type <= Type::i32 || type == Type::f32; }

bool is_name(std::string_view name) noexcept {
    const auto wrong = [](char c) { return c == '=' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    return !name.empty() && std::none_of(name.begin(), name.end(), wrong);
}

// A scale of 0.01 means a hundredth: dividing by 100 results in the nearest double, multiplying by 0.01 does not.
Scale scale_of(double factor) noexcept {
    const double inverse = std::round(1 / factor);
    if (std::abs(factor) < 1 && std::abs(inverse * factor - 1) < 1e-12) return {inverse, 1};
    return {1, factor};
}

// Whether the first field `field` can select a layout by this value.
bool may_select(const Field& field, std::uint32_t value) noexcept {
    if (field.count != 1 || !field.scale.is_one()) return false;
    if (field.type == Type::u8) return value <= 0xFF;
    if (field.type == Type::u16) return value <= 0xFFFF;
    return field.type == Type::u32;
}

// More specific layouts have a higher rank.
int rank_of(const FlexibleLayout& layout) noexcept { return (layout.source() ? 2 : 0) + (layout.when() ? 1 : 0); }

bool comes_before(const FlexibleLayout* a, const FlexibleLayout* b) noexcept {
    return rank_of(*a) != rank_of(*b) ? rank_of(*a) > rank_of(*b) : a->place() < b->place();
}

bool are_read_alike(const std::optional<Field>& a, const std::optional<Field>& b) noexcept {
    return a && b ? a->type == b->type && a->order == b->order : !a && !b;
}

}    // namespace

FlexibleLayouts::Refusal FlexibleLayouts::add(const FlexibleSpec& spec) {
    if (!is_flexible(spec.id)) return {LayoutFault::id};
    for (const Group& group : groups_)
        if (group.id == spec.id && group.source == spec.source && group.selector.has_value() == spec.when.has_value() &&
            group.with(spec.when.value_or(0)) != nullptr)
            return {LayoutFault::duplicate};
    if (spec.fields.empty()) return {LayoutFault::no_fields};

    FlexibleLayout layout;
    layout.id_ = spec.id;
    layout.source_ = spec.source;
    layout.when_ = spec.when;
    std::size_t size = 0;
    for (std::size_t i = 0; i < spec.fields.size(); ++i) {
        const FlexibleField& given = spec.fields[i];
        const auto same_name = [&](const Field& f) { return f.name == given.name; };
        if (!is_name(given.name) || std::any_of(layout.fields_.begin(), layout.fields_.end(), same_name))
            return {LayoutFault::name, i};
        if (!is_allowed(given.type)) return {LayoutFault::type, i};
        if (given.scale == 0 || !std::isfinite(given.scale) || !std::isfinite(1 / given.scale)) return {LayoutFault::scale, i};
        if (given.count == 0) return {LayoutFault::count, i};

        Field field;
        field.type = given.type;
        field.count = given.count;
        field.offset = static_cast<std::uint16_t>(size);
        field.scale = scale_of(given.scale);
        field.order = spec.endian;
        field.name = layout.texts_.emplace_back(given.name);
        field.unit = layout.texts_.emplace_back(given.unit);
        size += field.size();
        if (size > 65535) return {LayoutFault::too_long, i};
        layout.fields_.push_back(field);
    }
    layout.size_ = static_cast<std::uint16_t>(size);
    if (spec.when) {
        if (!may_select(layout.fields_.front(), *spec.when)) return {LayoutFault::when};
        layout.fields_.front().selects = Only{*spec.when, *spec.when};
    }
    layout.place_ = layouts_.size();
    const FlexibleLayout& added = layouts_.emplace_back(std::move(layout));    // the strings of a moved deque keep their
                                                                               // addresses
    group_of(added).by_value.emplace(spec.when.value_or(0), &added);
    return {};
}

FlexibleLayouts::Group& FlexibleLayouts::group_of(const FlexibleLayout& layout) {
    const auto selector = layout.when_ ? std::optional{layout.fields_.front()} : std::nullopt;
    for (Group& group : groups_)
        if (group.id == layout.id_ && group.source == layout.source_ && are_read_alike(group.selector, selector)) return group;
    return groups_.emplace_back(Group{layout.id_, layout.source_, selector, {}});
}

const FlexibleLayout* FlexibleLayouts::Group::with(std::uint32_t value) const noexcept {
    const auto found = by_value.find(value);
    return found == by_value.end() ? nullptr : found->second;
}

const FlexibleLayout* FlexibleLayouts::Group::find(std::span<const std::uint8_t> data) const noexcept {
    if (!selector) return with(0);
    if (data.size() < selector->size()) return nullptr;
    return with(
        with_type(selector->type, [&]<class T>(T) { return static_cast<std::uint32_t>(load<T>(data.data(), selector->order)); }));
}

const FlexibleLayout* FlexibleLayouts::find(std::uint8_t id, std::uint8_t source,
                                            std::span<const std::uint8_t> data) const noexcept {
    const FlexibleLayout* found = nullptr;
    for (const Group& group : groups_) {
        const FlexibleLayout* const layout = group.is_for(id, source) ? group.find(data) : nullptr;
        if (layout && (!found || comes_before(layout, found))) found = layout;
    }
    return found;
}

bool FlexibleLayouts::has_layout_for(std::uint8_t id, std::uint8_t source) const noexcept {
    return std::any_of(groups_.begin(), groups_.end(), [&](const Group& group) { return group.is_for(id, source); });
}

std::vector<const FlexibleLayout*> FlexibleLayouts::layouts_for(std::uint8_t id, std::uint8_t source) const {
    std::vector<const FlexibleLayout*> found;
    for (const FlexibleLayout& layout : layouts_)
        if (layout.id_ == id && (!layout.source_ || layout.source_ == source)) found.push_back(&layout);
    std::sort(found.begin(), found.end(), comes_before);
    return found;
}

std::vector<const FlexibleLayout*> FlexibleLayouts::layouts_for(std::uint8_t id, std::uint8_t source,
                                                                std::span<const Named> fields) const {
    std::vector<const FlexibleLayout*> found;
    for (const Group& group : groups_) {
        if (!group.is_for(id, source)) continue;
        if (!group.selector) found.push_back(group.with(0));
        for (const Named& field : fields) {
            const FlexibleLayout* const layout = group.selector ? group.with(field.value) : nullptr;
            if (layout && layout->fields_.front().name == field.name) found.push_back(layout);
        }
    }
    std::sort(found.begin(), found.end(), comes_before);
    return found;
}

std::string_view to_string(LayoutFault fault) noexcept {
    switch (fault) {
    case LayoutFault::none: return "fine";
    case LayoutFault::id: return "a flexible message has an id from 0xF1 to 0xFA";
    case LayoutFault::duplicate: return "this id already has a layout for this source and value of 'when'";
    case LayoutFault::no_fields: return "a layout needs at least one field";
    case LayoutFault::name: return "a field needs a unique name without '=' and control characters";
    case LayoutFault::type: return "a field is one of u8 i8 u16 i16 u32 i32 f32";
    case LayoutFault::scale: return "a scale is a finite number that is not 0";
    case LayoutFault::count: return "a count is a number from 1 to 65535";
    case LayoutFault::when: return "'when' is a value of the first field, which is one u8, u16 or u32 without a scale";
    case LayoutFault::too_long: return "the fields are longer than the 65535 bytes of DATA";
    }
    return "";
}

}    // namespace ano
