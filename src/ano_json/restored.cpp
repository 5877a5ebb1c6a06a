#include <ano/values.hpp>
#include <ano_json/json_writer.hpp>
#include <ano_json/restored.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/split_frames.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace ano {
namespace {

enum class Kept : std::uint8_t {
    exactly,
    otherwise,     // the field is encoded to other bytes
    not_at_all,    // JSON can't represent the number
};

Kept kept_number(const Field& f, const std::uint8_t* at) noexcept {
    if (is_integer(f.type) && f.scale.is_one()) return Kept::exactly;
    const Value value = value_at(f, at);
    const auto* const number = std::get_if<double>(&value);
    if (number == nullptr) return Kept::exactly;    // no data
    if (!std::isfinite(*number)) return Kept::not_at_all;
    if (f.scale.is_one()) return Kept::exactly;
    std::array<std::uint8_t, 8> again{};
    const bool is_same = store_number(f, *number, again.data()) == Stored::ok &&
                         std::equal(at, at + width(f.type), again.begin());
    return is_same ? Kept::exactly : Kept::otherwise;
}

bool is_kept_text(const Field& f, Bytes bytes, std::string_view text, Encoding encoding) {
    const Bytes behind = bytes.subspan(text.size());
    if (f.is_open() ? !behind.empty() : std::any_of(behind.begin(), behind.end(), [](std::uint8_t b) { return b != 0; }))
        return false;
    return is_ascii(text) || display_text(text, encoding) == text;
}

// In JSON, bytes that belong to no frame follow all frames.
bool are_kept_frames(Bytes bytes) {
    bool has_gap = false, is_kept = true;
    split_frames(
        bytes, [&](FrameView) { is_kept = is_kept && !has_gap; }, [&](std::size_t, Bytes) { has_gap = true; });
    return is_kept;
}

Kept kept(const Field& f, const Reading& reading, const JsonOptions& options) {
    const auto kept_if = [](bool exactly) { return exactly ? Kept::exactly : Kept::otherwise; };
    const Bytes bytes = reading.bytes_of(f);
    Kept all = Kept::exactly;
    if (is_number(f.type)) {
        for (std::size_t at = 0; at < bytes.size(); at += width(f.type)) all = std::max(all, kept_number(f, bytes.data() + at));
    } else if (f.type == Type::list) {
        for (std::size_t at = 0; at < bytes.size(); at += reading.message()->element_size)
            for (const Field& e : reading.element_fields()) all = std::max(all, kept_number(e, bytes.data() + at + e.offset));
    } else if (f.type == Type::text) {
        all = kept_if(is_kept_text(f, bytes, std::get<std::string_view>(reading.value(f)), options.encoding));
    } else if (f.type == Type::frames) {
        all = kept_if(are_kept_frames(bytes));
    } else if (f.role == Role::value) {
        all = kept_if(is_whole_value(bytes.size(), std::nullopt));
    }
    return all;
}

bool has_all(std::span<const Field> fields, std::span<const Field> given) noexcept {
    return std::all_of(given.begin(), given.end(), [&](const Field& g) {
        return std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.name == g.name; });
    });
}

// frame_from_json() uses the first layout that has all of the fields and is selected by the encoded bytes.
bool is_first_with_its_fields(const Message& row) noexcept {
    const auto layouts = layouts_of(row.id);
    return std::none_of(layouts.begin(), layouts.end(),
                        [&](const Message& other) { return &other < &row && has_all(other.fields(), row.fields()); });
}

bool is_first_with_its_fields(const FlexibleLayout& layout, FrameView frame, const Reading& reading,
                              const FlexibleLayouts& layouts) {
    std::vector<FlexibleLayouts::Named> numbers;
    for (const Field& f : layout.fields()) {
        const double number = f.count == 1 ? reading.number(f) : -1;
        if (number >= 0 && number <= UINT32_MAX) numbers.push_back({f.name, static_cast<std::uint32_t>(number)});
    }
    for (const FlexibleLayout* first : layouts.layouts_for(frame.id(), frame.source(), numbers))
        if (has_all(first->fields(), layout.fields())) return first == &layout;
    return false;
}

bool comes_back(FrameView frame, Bytes in_fields, const Reading& reading, const JsonOptions& options) {
    std::string text;
    JsonWriter out{text};
    out.begin_object();
    write_fields(reading, options, out);
    out.end_object();
    const auto again = data_from_json(frame.id(), frame.source(), Json::parse(text), {options.flexible, Encoding::utf8});
    const auto* data = std::get_if<std::vector<std::uint8_t>>(&again);
    return data != nullptr && std::equal(data->begin(), data->end(), in_fields.begin(), in_fields.end());
}

}    // namespace

bool is_restored(FrameView frame, const Reading& reading, const JsonOptions& options) {
    Kept all = Kept::exactly;
    for (const Field& f : reading.fields()) all = std::max(all, kept(f, reading, options));
    if (all == Kept::not_at_all) return false;
    const Bytes in_fields = frame.data().first(frame.data().size() - reading.extra().size());
    const FlexibleLayouts* const flexible = is_flexible(frame.id()) ? options.flexible : nullptr;
    const bool is_taken = flexible != nullptr
                              ? is_first_with_its_fields(*flexible->find(frame.id(), frame.source(), frame.data()), frame,
                                                         reading, *flexible)
                              : is_first_with_its_fields(*reading.message()) &&
                                    select_layout(layouts_of(frame.id()), in_fields) == reading.message();
    return is_taken ? all == Kept::exactly : comes_back(frame, in_fields, reading, options);
}

}    // namespace ano
