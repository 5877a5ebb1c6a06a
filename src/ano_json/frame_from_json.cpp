#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/json_pointer.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/typed_values.hpp>
#include <ano_json/v7_json.hpp>
#include <ano_json/words.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>
#include <type_traits>

namespace ano {
namespace {

using Data = std::vector<std::uint8_t>;

constexpr unsigned first_predefined = 200;    // addresses from here on have a predefined meaning

// Thrown only inside this file.
[[noreturn]] void fail(std::string pointer, std::string what) { throw JsonFault{std::move(pointer), std::move(what)}; }

std::string format_json(const Json& json) {
    std::string text = json.is_string() ? in_quotes(json.get_ref<const std::string&>())
                                        : json.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}

std::optional<Number> number_of(const Json& json) {
    if (json.is_number_unsigned()) return Number{json.get<std::uint64_t>()};
    if (json.is_number_integer()) return Number{json.get<std::int64_t>()};
    if (json.is_number_float()) return Number{json.get<double>()};
    if (json.is_string()) return parse_number(json.get_ref<const std::string&>());
    return std::nullopt;
}

std::optional<std::uint64_t> whole_number(const Json& json) {
    const auto number = number_of(json);
    if (!number) return std::nullopt;
    return std::visit(
        [](auto n) -> std::optional<std::uint64_t> {
            if constexpr (std::is_floating_point_v<decltype(n)>) {
                if (!(n >= 0 && n < 1e18 && n == std::trunc(n))) return std::nullopt;
            } else if (std::cmp_less(n, 0)) {
                return std::nullopt;
            }
            return static_cast<std::uint64_t>(n);
        },
        *number);
}

std::string hex_or_word(std::string_view word, std::span<const std::string_view> names) {
    const std::string in_hex = did_you_mean_hex(word);
    return in_hex.empty() ? did_you_mean(word, names) : in_hex;
}

std::uint8_t byte_at(const Json& object, const char* key, std::uint8_t otherwise) {
    const auto it = object.find(key);
    if (it == object.end()) return otherwise;
    const auto value = whole_number(*it);
    if (!value || *value > 255)
        fail(pointer_step(key), std::string{key} + ": " + format_json(*it) + " is not a number from 0 to 255" +
                                    (it->is_string() ? did_you_mean_hex(it->get_ref<const std::string&>()) : ""));
    return static_cast<std::uint8_t>(*value);
}

using FindAddress = std::variant<std::uint8_t, JsonFault> (&)(std::string_view word);

std::uint8_t address_at(const Json& object, const char* key, std::uint8_t otherwise, FindAddress find = address_called) {
    const auto it = object.find(key);
    if (it == object.end() || !it->is_string() || number_of(*it)) return byte_at(object, key, otherwise);
    const auto address = find(it->get_ref<const std::string&>());
    if (const auto* fault = std::get_if<JsonFault>(&address)) fail(pointer_step(key), std::string{key} + ": " + fault->what);
    return std::get<std::uint8_t>(address);
}

/// The value of a number, or of a word for one.
std::optional<Number> number_for(const Field& f, const Json& json, ValueType7 seven) {
    if (const auto number = number_of(json)) return number;
    if (!json.is_string()) return std::nullopt;
    const auto value = value_called(f, json.get_ref<const std::string&>(), seven);
    if (!value) return std::nullopt;
    return Number{std::uint64_t{*value}};
}

/// "'rde' is not a number, nor default, red, green, blue (did you mean 'red'?)"
std::string no_number(const Json& json, const std::vector<std::string_view>& words, bool is_code) {
    std::string text = format_json(json) + " is not a number";
    if (!json.is_string()) return text;
    const std::string& given = json.get_ref<const std::string&>();
    for (const std::string_view word : words) text.append(word == words.front() ? ", nor " : ", ").append(word);
    return text + (is_code ? hex_or_word(given, words) : did_you_mean(given, words));
}

Data hex_at(const Json& json, const std::string& pointer, std::string_view name) {
    if (json.is_string())
        if (auto bytes = from_hex(json.get_ref<const std::string&>())) return std::move(*bytes);
    fail(pointer, std::string{name} + ": " + format_json(json) + " is not hex digits in pairs");
}

Data encode_frame(const Json& json, const JsonOptions& options, bool inside_a_tunnel, const std::string& pointer);

class FieldReader {
public:
    FieldReader(std::string_view message, const JsonOptions& options, bool inside_a_tunnel)
        : message_{message}, options_{options}, inside_a_tunnel_{inside_a_tunnel} {}

    /// Returns DATA in the layout of `fields`; `given` contains no other fields.
    Data encode(std::span<const Field> fields, std::span<const Field> element, std::size_t size, const Json& given) {
        data_.assign(size, 0);
        for (const Field& f : fields) {
            if (f.selects) store_number_at(f, Json(f.selects->first), data_.data() + f.offset, pointer_step(f.name));
            const auto it = given.find(std::string{f.name});
            if (f.role == Role::value) store_value(f, it == given.end() ? Json("") : *it, given);
            else if (it != given.end()) put(f, element, *it);
            if (f.type != Type::frames) continue;
            if (const auto rest = given.find("data"); rest != given.end()) append(hex_at(*rest, pointer_step("data"), "data"));
        }
        return std::move(data_);
    }

private:
    void put(const Field& f, std::span<const Field> element, const Json& json) {
        const std::string pointer = pointer_step(f.name);
        switch (f.type) {
        case Type::text: return store_bytes(f, text(f, json), json);
        case Type::bytes: return store_bytes(f, bytes(f, json).bytes, json);
        case Type::ip: return store_address(f, json);
        case Type::list: return store_elements(f, element, json);
        case Type::frames: return store_frames(f, json);
        default: break;
        }
        if (f.count == 1) return store_number_at(f, json, data_.data() + f.offset, pointer);
        if (!json.is_array() || json.size() > f.count)
            fail(pointer, label(f) + format_json(json) + " is not an array of " + std::to_string(f.count) + " numbers at most");
        for (std::size_t i = 0; i < json.size(); ++i)
            store_number_at(f, json[i], data_.data() + f.offset + i * width(f.type), pointer + pointer_step(std::to_string(i)));
    }

    void store_number_at(const Field& f, const Json& json, std::uint8_t* at, const std::string& pointer) const {
        if (json.is_null()) {
            if (!store_no_data(f, at)) fail(pointer, label(f) + "it has no value that says \"no data\"");
            return;
        }
        const auto number = number_for(f, json, options_.value_type_7);
        if (!number) fail(pointer, label(f) + no_number(json, words_for(f, options_.value_type_7), f.role == Role::code));
        switch (store_number(f, *number, at)) {
        case Stored::ok: return;
        case Stored::not_whole: fail(pointer, label(f) + format_json(json) + " is not a whole number (" + carried(f) + ")");
        case Stored::out_of_range: fail(pointer, label(f) + format_json(json) + " is out of range (" + carried(f) + ")");
        }
    }

    Data text(const Field& f, const Json& json) const {
        if (!json.is_string()) fail(pointer_step(f.name), label(f) + format_json(json) + " is not text");
        const auto encoded = from_utf8(json.get_ref<const std::string&>(), options_.encoding);
        if (!encoded) {
            const char* name = options_.encoding == Encoding::gbk ? "GBK" : "UTF-8";
            fail(pointer_step(f.name), label(f) + format_json(json) + " can't be written in " + name);
        }
        if (encoded->find('\0') != std::string::npos) fail(pointer_step(f.name), label(f) + "text can't hold a NUL");
        return {encoded->begin(), encoded->end()};
    }

    // Hex digits, or values with their types.
    TypedValues bytes(const Field& f, const Json& json) const {
        const bool may_be_typed = f.role == Role::value || f.role == Role::values;
        if (!may_be_typed) return {hex_at(json, pointer_step(f.name), f.name), {}};
        if (!json.is_string() || !is_typed(json.get_ref<const std::string&>())) {
            if (json.is_string())
                if (auto bytes = from_hex(json.get_ref<const std::string&>())) return {std::move(*bytes), {}};
            fail(pointer_step(f.name), label(f) + format_json(json) + " is neither hex digits in pairs nor typed, as f32:1.5 is");
        }
        auto values = typed_values(json.get_ref<const std::string&>(), f.role, options_.encoding);
        if (const auto* wrong = std::get_if<std::string>(&values)) fail(pointer_step(f.name), label(f) + *wrong);
        return std::move(std::get<TypedValues>(values));
    }

    // The value of a parameter: not shorter than its type, if the type is known.
    void store_value(const Field& f, const Json& json, const Json& given) {
        const TypedValues value = bytes(f, json);
        std::optional<Type> type;
        if (!value.types.empty()) type = value.types.front();
        if (const auto it = given.find("par_type"); it != given.end()) {
            const auto given_type_name = given_type(*it);
            if (type && given_type_name && *type != *given_type_name)
                fail(pointer_step(f.name), label(f) + format_json(json) + " is not what par_type says: " + format_json(*it));
            if (!type) type = given_type_name;
        }
        if (!is_whole_value(value.bytes.size(), type)) fail_as_short(f, json, value.bytes.size(), type);
        store_bytes(f, value.bytes, json);
    }
    std::optional<Type> given_type(const Json& json) const {
        const Field& f = *find_message("parameter_info")->field("par_type");
        std::uint8_t par_type = 0;
        store_number_at(f, json, &par_type, pointer_step(f.name));
        return parameter_type(par_type);
    }
    [[noreturn]] void fail_as_short(const Field& f, const Json& json, std::size_t size, std::optional<Type> type) const {
        std::string what = "it is empty";
        if (size > 0) {
            what = format_json(json) + " is " + std::to_string(size) + (size == 1 ? " byte, " : " bytes, ");
            what += type ? std::string{name_of(*type)} + " has " + std::to_string(width(*type)) : "as no number is";
        }
        fail(pointer_step(f.name), label(f) + what +
                                       "; a device would store check bytes of the frame with it: write it with its type, "
                                       "such as f32:1.5 or string:abc");
    }

    void store_bytes(const Field& f, const Data& bytes, const Json& json) {
        if (f.is_open()) return append(bytes);
        if (bytes.size() > f.size())
            fail(pointer_step(f.name), label(f) + format_json(json) + " is " + std::to_string(bytes.size()) +
                                           " bytes, it holds " + std::to_string(f.size()));
        std::copy(bytes.begin(), bytes.end(), data_.begin() + f.offset);
    }

    void store_address(const Field& f, const Json& json) {
        const auto wrong = [&] {
            fail(pointer_step(f.name), label(f) + format_json(json) + " is not an address like 192.168.0.1");
        };
        if (!json.is_string()) wrong();
        std::string_view rest = json.get_ref<const std::string&>();
        for (std::size_t i = 0; i < 4; ++i) {
            const std::string_view part = rest.substr(0, i < 3 ? rest.find('.') : rest.npos);
            const bool is_decimal = !part.empty() && part.size() <= 3 &&
                                    std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
            const int value = is_decimal ? std::stoi(std::string{part}) : 256;
            if (value > 255 || (i < 3 && part.size() == rest.size())) wrong();
            data_[f.offset + i] = static_cast<std::uint8_t>(value);
            rest.remove_prefix(std::min(rest.size(), part.size() + 1));
        }
    }

    void store_elements(const Field& list, std::span<const Field> element, const Json& json) {
        const std::string pointer = pointer_step(list.name);
        if (!json.is_array()) fail(pointer, label(list) + format_json(json) + " is not an array");
        for (std::size_t i = 0; i < json.size(); ++i) {
            const std::string here = pointer + pointer_step(std::to_string(i));
            if (!json[i].is_object()) fail(here, label(list) + format_json(json[i]) + " is not an object");
            std::vector<std::string_view> names;
            for (const Field& f : element) names.push_back(f.name);
            for (const auto& [key, value] : json[i].items())
                if (std::find(names.begin(), names.end(), key) == names.end())
                    fail(here + pointer_step(key), label(list) + "no field " + in_quotes(key) + did_you_mean(key, names));
            const std::size_t at = data_.size();
            data_.resize(at + element.back().offset + element.back().size());
            for (const Field& f : element)
                if (const auto it = json[i].find(std::string{f.name}); it != json[i].end())
                    store_number_at(f, *it, data_.data() + at + f.offset, here + pointer_step(f.name));
        }
    }

    void store_frames(const Field& f, const Json& json) {
        if (json.is_string()) return append(hex_at(json, pointer_step(f.name), f.name));
        if (!json.is_array()) fail(pointer_step(f.name), label(f) + format_json(json) + " is not an array of frames");
        if (inside_a_tunnel_) fail(pointer_step(f.name), label(f) + "a tunnel frame inside a tunnel frame is given as its data");
        for (std::size_t i = 0; i < json.size(); ++i)
            append(encode_frame(json[i], options_, true, pointer_step(f.name) + pointer_step(std::to_string(i))));
    }

    void append(const Data& bytes) { data_.insert(data_.end(), bytes.begin(), bytes.end()); }

    /// "euler rol: "
    std::string label(const Field& f) const { return std::string{message_} + " " + std::string{f.name} + ": "; }

    std::string_view message_;
    const JsonOptions& options_;
    bool inside_a_tunnel_;
    Data data_;
};

std::vector<std::string_view> names_in(std::span<const Field> fields) {
    std::vector<std::string_view> names;
    for (const Field& f : fields) {
        names.push_back(f.name);
        if (f.type == Type::frames) names.push_back("data");       // bytes that are not a complete frame
        if (f.role == Role::value) names.push_back("par_type");    // the type of the value
    }
    return names;
}

bool has_all(const std::vector<std::string_view>& names, const Json& given) {
    const auto is_given = [&](const auto& item) { return std::find(names.begin(), names.end(), item.key()) != names.end(); };
    const auto items = given.items();
    return std::all_of(items.begin(), items.end(), is_given);
}

/// Whether `row` has a number for each word in `given`.
bool knows_words(const Message& row, const Json& given, ValueType7 seven) {
    for (const Field& f : row.fields()) {
        const auto it = given.find(std::string{f.name});
        if (it != given.end() && it->is_string() && is_number(f.type) && !number_for(f, *it, seven)) return false;
    }
    return true;
}

// The fault for a word that is unknown in all layouts with the given fields.
void fail_for_word(std::span<const Message> layouts, const Json& given, ValueType7 seven) {
    for (const auto& [key, value] : given.items()) {
        std::vector<std::string_view> words;
        bool is_known = false, is_code = false;
        bool is_number_field = false;
        for (const Message& row : layouts) {
            const Field* f = row.field(key);
            if (f == nullptr || !is_number(f->type) || !has_all(names_in(row.fields()), given)) continue;
            is_number_field = true;
            is_code = is_code || f->role == Role::code;
            is_known = is_known || !value.is_string() || number_for(*f, value, seven);
            for (const std::string_view word : words_for(*f, seven))
                if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
        }
        if (is_number_field && !is_known)
            fail(pointer_step(key), std::string{layouts.front().name} + " " + key + ": " + no_number(value, words, is_code));
    }
}

[[noreturn]] void fail_without_layout(std::span<const Message> layouts, const Json& given, ValueType7 seven) {
    const std::string name{layouts.front().name};
    std::vector<std::string_view> known;
    for (const Message& row : layouts)
        for (const std::string_view field : names_in(row.fields())) known.push_back(field);
    for (const auto& [key, value] : given.items())
        if (std::find(known.begin(), known.end(), key) == known.end())
            fail(pointer_step(key), name + " has no field " + in_quotes(key) + did_you_mean(key, known));
    std::string modes;
    for (const Message& row : layouts)
        for (const Field& f : row.fields()) {
            const auto it = given.find(std::string{f.name});
            if (!f.selects || it == given.end() || !has_all(names_in(row.fields()), given)) continue;
            if (!knows_words(row, given, seven)) continue;
            modes += modes.empty() ? std::string{f.name} + ": " + format_json(*it) + " is none of " : ", ";
            modes += std::to_string(f.selects->first);
            if (f.selects->last != f.selects->first) modes += " to " + std::to_string(f.selects->last);
        }
    if (!modes.empty()) fail("", name + " " + modes);
    for (const Message& row : layouts)
        if (has_all(names_in(row.fields()), given) && !knows_words(row, given, seven))
            fail("", name + " has no layout with all of these values");
    fail("", name + " has no layout with all of these fields");
}

/// The layouts selected by the given numbers.
std::vector<const FlexibleLayout*> selected_by(std::uint8_t id, std::uint8_t source, const Json& given,
                                               const FlexibleLayouts& layouts) {
    std::vector<FlexibleLayouts::Named> numbers;
    for (const auto& [key, value] : given.items()) {
        const double number = value.is_number() ? value.get<double>() : -1;
        if (number >= 0 && number <= UINT32_MAX) numbers.push_back({key, static_cast<std::uint32_t>(number)});
    }
    return layouts.layouts_for(id, source, numbers);
}

[[noreturn]] void fail_without_flexible(std::uint8_t id, std::uint8_t source, const Json& given, const FlexibleLayouts& layouts) {
    const std::string name{layouts_of(id).front().name};
    std::vector<std::string_view> known;
    for (const FlexibleLayout* layout : layouts.layouts_for(id, source))
        for (const std::string_view field : names_in(layout->fields())) known.push_back(field);
    for (const auto& [key, value] : given.items())
        if (std::find(known.begin(), known.end(), key) == known.end())
            fail(pointer_step(key), name + " has no field " + in_quotes(key) + did_you_mean(key, known));
    fail("", name + " has no layout in the configuration with all of these fields and values");
}

// `layouts`: those of `id`, in its version of the protocol.
Data encode_fields(std::span<const Message> layouts, std::uint8_t id, std::uint8_t source, const Json& given,
                   const JsonOptions& options, bool inside_a_tunnel) {
    if (layouts.empty()) fail("", "id " + hex_byte(id) + " is not listed: only its data can be given");
    if (!given.is_object()) fail("", format_json(given) + " is not an object of fields");
    FieldReader reader{layouts.front().name, options, inside_a_tunnel};
    const std::string name{layouts.front().name};
    if (is_flexible(id)) {
        if (options.flexible == nullptr || !options.flexible->has_layout_for(id, source))
            fail("", name + " has no layout in the configuration: only its data can be given");
        const auto encoded = [&](const std::vector<const FlexibleLayout*>& candidates) -> std::optional<Data> {
            for (const FlexibleLayout* layout : candidates) {
                if (!has_all(names_in(layout->fields()), given)) continue;
                Data data = reader.encode(layout->fields(), {}, layout->size(), given);
                if (options.flexible->find(id, source, data) == layout) return data;
            }
            return std::nullopt;
        };
        if (auto data = encoded(selected_by(id, source, given, *options.flexible))) return *std::move(data);
        // The selecting field may be missing, or may be given as text.
        if (auto data = encoded(options.flexible->layouts_for(id, source))) return *std::move(data);
        fail_without_flexible(id, source, given, *options.flexible);
    }
    bool looks_otherwise = false;
    for (const Message& row : layouts) {
        if (!has_all(names_in(row.fields()), given)) continue;
        if (layouts.size() > 1 && !knows_words(row, given, options.value_type_7)) continue;
        Data data = reader.encode(row.fields(), row.element(), row.fixed_size, given);
        const Message* const taken = select_layout(layouts, data);
        if (taken == &row) return data;    // otherwise the given mode belongs to another layout
        looks_otherwise = looks_otherwise || row.variant.by_look || (taken != nullptr && taken->variant.by_look);
    }
    if (looks_otherwise) fail("", name + " would be read in another layout with these values: give its data");
    fail_for_word(layouts, given, options.value_type_7);
    fail_without_layout(layouts, given, options.value_type_7);
}

using FindId = std::variant<std::uint8_t, JsonFault> (&)(std::string_view word);

std::uint8_t id_of(const Json& json, FindId find_id) {
    const auto name = json.find("name");
    const auto id = json.find("id");
    if (name == json.end()) {
        if (id == json.end()) fail("", "a frame needs a name or an id");
        return byte_at(json, "id", 0);
    }
    if (!name->is_string()) fail("/name", "name: " + format_json(*name) + " is not text");
    const auto found = find_id(name->get_ref<const std::string&>());
    if (const auto* fault = std::get_if<JsonFault>(&found)) fail("/name", fault->what);
    const std::uint8_t named = std::get<std::uint8_t>(found);
    if (id != json.end() && byte_at(json, "id", 0) != named)
        fail("/id",
             "id: " + format_json(*id) + " is not the id of " + name->get<std::string>() + ", which is " + hex_byte(named));
    return named;
}

Data data_of(const Json& json, std::span<const Message> layouts, std::uint8_t id, std::uint8_t source, const JsonOptions& options,
             bool inside_a_tunnel) {
    if (const auto data = json.find("data"); data != json.end()) return hex_at(*data, "/data", "data");
    Data bytes;
    const auto fields = json.find("fields");
    try {
        bytes = encode_fields(layouts, id, source, fields == json.end() ? Json::object() : *fields, options, inside_a_tunnel);
    } catch (JsonFault& fault) {
        fault.pointer.insert(0, "/fields");
        throw;
    }
    if (const auto extra = json.find("extra"); extra != json.end()) {
        const Data behind = hex_at(*extra, "/extra", "extra");
        bytes.insert(bytes.end(), behind.begin(), behind.end());
    }
    return bytes;
}

void check_keys(const Json& json, std::span<const std::string_view> keys) {
    if (!json.is_object()) fail("", format_json(json) + " is not an object");
    for (const auto& [key, value] : json.items())
        if (std::find(keys.begin(), keys.end(), key) == keys.end())
            fail(pointer_step(key), "unknown key " + in_quotes(key) + did_you_mean(key, keys));
}

Data encode_object(const Json& json, const JsonOptions& options, bool inside_a_tunnel) {
    constexpr std::string_view keys[]{"from", "to",   "id",   "name", "fields",    "extra",
                                      "data", "time", "link", "peer", "direction", "cause"};
    check_keys(json, keys);
    const std::uint8_t id = id_of(json, message_id);
    const std::uint8_t from = address_at(json, "from", address::host);
    const std::uint8_t to = address_at(json, "to", address::broadcast);
    const Data data = data_of(json, layouts_of(id), id, from, options, inside_a_tunnel);
    if (data.size() > max_len) fail("", std::to_string(data.size()) + " bytes of DATA are more than the 65535 a frame can carry");
    Data frame(overhead + data.size());
    encode(frame, from, to, id, data);
    return frame;
}

Data encode_frame(const Json& json, const JsonOptions& options, bool inside_a_tunnel, const std::string& pointer) {
    try {
        return encode_object(json, options, inside_a_tunnel);
    } catch (JsonFault& fault) {
        fault.pointer.insert(0, pointer);
        throw;
    }
}

}    // namespace

std::variant<std::vector<std::uint8_t>, JsonFault> frame_from_json(const Json& json, const JsonOptions& options) {
    try {
        return encode_frame(json, options, false, "");
    } catch (JsonFault& fault) {
        return std::move(fault);
    }
}

std::variant<std::vector<std::uint8_t>, JsonFault> data_from_json(std::uint8_t id, std::uint8_t source, const Json& fields,
                                                                  const JsonOptions& options) {
    try {
        return encode_fields(layouts_of(id), id, source, fields, options, false);
    } catch (JsonFault& fault) {
        return std::move(fault);
    }
}

std::variant<std::uint8_t, JsonFault> address_called(std::string_view word) {
    if (const auto number = whole_number(Json(std::string{word})); number && *number <= 255)
        return static_cast<std::uint8_t>(*number);
    std::vector<std::string_view> names;    // of one address each; excludes "port"
    for (unsigned a = first_predefined; a <= 255; ++a) {
        const std::string_view who = address::who(static_cast<std::uint8_t>(a));
        if (who == "reserved") continue;
        if (is_same_word(who, word)) return static_cast<std::uint8_t>(a);
        names.push_back(who);
    }
    return JsonFault{"", in_quotes(word) + " is not an address from 0 to 255" + hex_or_word(word, names)};
}

std::variant<std::uint8_t, JsonFault> message_id(std::string_view word) {
    if (const Message* message = find_message(word)) return message->id;
    if (const auto number = whole_number(Json(std::string{word})); number && *number <= 255)
        return static_cast<std::uint8_t>(*number);
    std::vector<std::string_view> names;
    for (const Message& row : messages) names.push_back(row.name);
    return JsonFault{"", "there is no message " + in_quotes(word) + hex_or_word(word, names)};
}

namespace {

std::variant<std::uint8_t, JsonFault> v7_address_called(std::string_view word) {
    std::vector<std::string_view> names;
    for (unsigned a = 0; a <= 255; ++a) {
        const std::string_view who = v7::address::who(static_cast<std::uint8_t>(a));
        if (who.empty()) continue;
        if (is_same_word(who, word)) return static_cast<std::uint8_t>(a);
        names.push_back(who);
    }
    return JsonFault{"", in_quotes(word) + " is not an address from 0 to 255" + hex_or_word(word, names)};
}

// Devices accept a command only with all of its bytes.
void complete_v7_command(std::uint8_t id, Data& data) {
    constexpr std::size_t command_size = 11;
    if (id == 0xE0 && data.size() < command_size) data.resize(command_size);
}

Data encode_v7(const Json& json, const JsonOptions& options) {
    constexpr std::string_view keys[]{"to", "id", "name", "fields", "extra", "data"};
    check_keys(json, keys);
    const std::uint8_t id = id_of(json, v7_message_id);
    const std::uint8_t to = address_at(json, "to", v7::address::broadcast, v7_address_called);
    Data data = data_of(json, v7::layouts_of(id), id, 0, options, false);
    if (!json.contains("data")) complete_v7_command(id, data);
    if (data.size() > v7::max_len)
        fail("", std::to_string(data.size()) + " bytes of DATA are more than the 255 a frame of version 7 can carry");
    Data frame(v7::overhead + data.size());
    v7::encode(frame, to, id, data);
    return frame;
}

}    // namespace

std::variant<std::vector<std::uint8_t>, JsonFault> v7_frame_from_json(const Json& json, const JsonOptions& options) {
    try {
        return encode_v7(json, options);
    } catch (JsonFault& fault) {
        return std::move(fault);
    }
}

std::variant<std::vector<std::uint8_t>, JsonFault> v7_data_from_json(std::uint8_t id, const Json& fields,
                                                                     const JsonOptions& options) {
    try {
        Data data = encode_fields(v7::layouts_of(id), id, 0, fields, options, false);
        complete_v7_command(id, data);
        return data;
    } catch (JsonFault& fault) {
        return std::move(fault);
    }
}

std::variant<std::uint8_t, JsonFault> v7_message_id(std::string_view word) {
    if (const Message* message = v7::find_message(word)) return message->id;
    if (const auto number = whole_number(Json(std::string{word})); number && *number <= 255)
        return static_cast<std::uint8_t>(*number);
    std::vector<std::string_view> names;
    for (const Message& row : v7::table::differences) names.push_back(row.name);
    for (const Message& row : messages)
        if (row.is_base() && v7::is_same_in_v8(row.id)) names.push_back(row.name);
    return JsonFault{"", "version 7 has no message " + in_quotes(word) + hex_or_word(word, names)};
}

}    // namespace ano
