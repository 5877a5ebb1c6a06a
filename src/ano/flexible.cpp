#include <ano/flexible.hpp>

#include <algorithm>
#include <cmath>

namespace ano {
namespace {

using Fault = FlexibleLayouts::Fault;

bool is_allowed(Type type) noexcept { return type <= Type::i32 || type == Type::f32; }

bool is_name(std::string_view name) noexcept {
    const auto wrong = [](char c) { return c == '=' || static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    return !name.empty() && std::none_of(name.begin(), name.end(), wrong);
}

// A scale of 0.01 means a hundredth: dividing by 100 gives the nearest double, multiplying by 0.01 does not.
Scale scale_of(double factor) noexcept {
    const double inverse = std::round(1 / factor);
    if (std::abs(factor) < 1 && std::abs(inverse * factor - 1) < 1e-12) return {inverse, 1};
    return {1, factor};
}

}    // namespace

FlexibleLayouts::Refusal FlexibleLayouts::add(std::uint8_t id, std::optional<std::uint8_t> source,
                                              std::span<const FlexibleField> fields) {
    if (!is_flexible(id)) return {Fault::id};
    for (const FlexibleLayout& other : layouts_)
        if (other.id_ == id && other.source_ == source) return {Fault::duplicate};
    if (fields.empty()) return {Fault::no_fields};

    FlexibleLayout layout;
    layout.id_ = id;
    layout.source_ = source;
    std::size_t size = 0;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const FlexibleField& given = fields[i];
        const auto same_name = [&](const Field& f) { return f.name == given.name; };
        if (!is_name(given.name) || std::any_of(layout.fields_.begin(), layout.fields_.end(), same_name)) return {Fault::name, i};
        if (!is_allowed(given.type)) return {Fault::type, i};
        if (given.scale == 0 || !std::isfinite(given.scale) || !std::isfinite(1 / given.scale)) return {Fault::scale, i};

        Field field;
        field.type = given.type;
        field.offset = static_cast<std::uint16_t>(size);
        field.scale = scale_of(given.scale);
        field.name = layout.texts_.emplace_back(given.name);
        field.unit = layout.texts_.emplace_back(given.unit);
        size += field.size();
        if (size > 65535) return {Fault::too_long, i};
        layout.fields_.push_back(field);
    }
    layout.size_ = static_cast<std::uint16_t>(size);
    layouts_.push_back(std::move(layout));    // a moved deque keeps its strings where they are
    return {};
}

const FlexibleLayout* FlexibleLayouts::find(std::uint8_t id, std::uint8_t source) const noexcept {
    const FlexibleLayout* for_all = nullptr;
    for (const FlexibleLayout& layout : layouts_) {
        if (layout.id_ != id) continue;
        if (layout.source_ == source) return &layout;
        if (!layout.source_) for_all = &layout;
    }
    return for_all;
}

std::string_view text_of(Fault fault) noexcept {
    switch (fault) {
    case Fault::none: return "fine";
    case Fault::id: return "a flexible message has an id from 0xF1 to 0xFA";
    case Fault::duplicate: return "this id has a layout for this source already";
    case Fault::no_fields: return "a layout has at least one field";
    case Fault::name: return "a field has a name of its own, without '=' and control characters";
    case Fault::type: return "a field is one of u8 i8 u16 i16 u32 i32 f32";
    case Fault::scale: return "a scale is a finite number that is not 0";
    case Fault::too_long: return "the fields are longer than the 65535 bytes of DATA";
    }
    return "";
}

}    // namespace ano
