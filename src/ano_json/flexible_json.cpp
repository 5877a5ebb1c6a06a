#include <ano/hex.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/nearest.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace ano {
namespace {

class LayoutReader {
public:
    LayoutReader(FlexibleLayouts& layouts, std::vector<FlexibleSpec>& specs, std::vector<JsonFault>& faults)
        : layouts_{layouts}, specs_{specs}, faults_{faults} {}

    void read(const nlohmann::json& given, const std::string& pointer) {
        constexpr std::array<std::string_view, 5> keys{"id", "source", "endian", "when", "fields"};
        const std::size_t faults_before = faults_.size();
        if (!check_keys(given, pointer, keys)) return;
        const auto id = id_at(given, pointer);
        std::optional<std::uint8_t> source;
        if (given.contains("source")) {
            source = whole<std::uint8_t>(given["source"]);
            if (!source) fault(pointer + "/source", "an address is 0 to 255");
        }
        FlexibleSpec spec{.id = id.value_or(0), .source = source};
        spec.endian = endian_at(given, pointer);
        if (given.contains("when")) {
            spec.when = whole<std::uint32_t>(given["when"]);
            if (!spec.when) fault(pointer + "/when", std::string{to_string(FlexibleLayouts::Fault::when)});
        }
        spec.fields = fields_at(given, pointer);
        if (faults_.size() != faults_before || !id) return;
        if (const auto refusal = layouts_.add(spec)) {
            using enum FlexibleLayouts::Fault;
            const bool at_field = refusal.fault == name || refusal.fault == type || refusal.fault == scale ||
                                  refusal.fault == count;
            const std::string where = at_field                ? "/fields/" + std::to_string(refusal.field)
                                      : refusal.fault == when ? "/when"
                                                              : "";
            fault(pointer + where, std::string{to_string(refusal.fault)});
        } else {
            specs_.push_back(std::move(spec));
        }
    }

private:
    void fault(std::string pointer, std::string what) { faults_.push_back({std::move(pointer), std::move(what)}); }

    bool check_keys(const nlohmann::json& given, const std::string& pointer, std::span<const std::string_view> keys) {
        if (!given.is_object()) {
            fault(pointer, "must be an object");
            return false;
        }
        for (const auto& [key, value] : given.items())
            if (std::find(keys.begin(), keys.end(), key) == keys.end())
                fault(pointer + "/" + key, "unknown key " + in_quotes(key) + did_you_mean(key, keys));
        return true;
    }

    // A number, or a text with a number as in C; std::nullopt: it is not one that T can represent.
    template <class T>
    static std::optional<T> whole(const nlohmann::json& value) {
        std::optional<Number> number;
        if (value.is_number_unsigned()) number = value.get<std::uint64_t>();
        if (value.is_string()) number = parse_number(value.get_ref<const std::string&>());
        if (!number) return std::nullopt;
        const double n = std::visit([](auto v) { return static_cast<double>(v); }, *number);
        if (!(n >= 0 && n <= static_cast<double>(std::numeric_limits<T>::max())) || n != std::trunc(n)) return std::nullopt;
        return static_cast<T>(n);
    }

    ByteOrder endian_at(const nlohmann::json& given, const std::string& pointer) {
        if (!given.contains("endian") || given["endian"] == "little") return ByteOrder::little;
        if (given["endian"] != "big") fault(pointer + "/endian", "must be \"little\" or \"big\"");
        return ByteOrder::big;
    }

    std::optional<std::uint8_t> id_at(const nlohmann::json& given, const std::string& pointer) {
        if (!given.contains("id")) {
            fault(pointer, "key 'id' is missing");
            return std::nullopt;
        }
        const nlohmann::json& value = given["id"];
        auto id = whole<std::uint8_t>(value);
        if (!id && value.is_string())
            if (const Message* message = find_message(value.get_ref<const std::string&>())) id = message->id;
        if (!id || !is_flexible(*id)) fault(pointer + "/id", std::string{to_string(FlexibleLayouts::Fault::id)});
        return id;
    }

    std::vector<FlexibleField> fields_at(const nlohmann::json& given, const std::string& pointer) {
        std::vector<FlexibleField> fields;
        if (!given.contains("fields")) {
            fault(pointer, "key 'fields' is missing");
        } else if (!given["fields"].is_array()) {
            fault(pointer + "/fields", "must be an array of fields");
        } else {
            for (std::size_t i = 0; i < given["fields"].size(); ++i)
                fields.push_back(field(given["fields"][i], pointer + "/fields/" + std::to_string(i)));
        }
        return fields;
    }

    /// Names and units are displayed in terminals and tables.
    std::string printable(const nlohmann::json& given, const std::string& pointer) {
        std::string text = given.get<std::string>();
        for (std::size_t at = 0; at < text.size(); ++at)
            if (control_size(text, at) > 0) {
                fault(pointer, "control characters are not accepted");
                break;
            }
        return text;
    }

    FlexibleField field(const nlohmann::json& given, const std::string& pointer) {
        constexpr std::array<std::string_view, 5> keys{"name", "type", "count", "scale", "unit"};
        FlexibleField field;
        if (!check_keys(given, pointer, keys)) return field;
        for (const char* key : {"name", "type"}) {
            if (!given.contains(key)) fault(pointer, std::string{"key '"} + key + "' is missing");
            else if (!given[key].is_string()) fault(pointer + "/" + key, "must be text");
        }
        if (given.contains("unit")) {
            if (given["unit"].is_string()) field.unit = printable(given["unit"], pointer + "/unit");
            else fault(pointer + "/unit", "must be text");
        }
        if (given.contains("count")) {
            const auto count = whole<std::uint16_t>(given["count"]);
            if (count) field.count = *count;
            else fault(pointer + "/count", std::string{to_string(FlexibleLayouts::Fault::count)});
        }
        if (given.contains("scale")) {
            if (given["scale"].is_number()) field.scale = given["scale"].get<double>();
            else fault(pointer + "/scale", "must be a number");
        }
        if (given.contains("name") && given["name"].is_string()) field.name = printable(given["name"], pointer + "/name");
        if (given.contains("type") && given["type"].is_string()) {
            const auto& word = given["type"].get_ref<const std::string&>();
            const auto it = std::find(type_names.begin(), type_names.end(), word);
            // A word that is not a type of the protocol is refused here, with the nearest type. A type that is not allowed in
            // flexible frames is refused by FlexibleLayouts.
            if (it == type_names.end())
                fault(pointer + "/type", "unknown type " + in_quotes(word) + did_you_mean(word, type_names) + "; " +
                                             std::string{to_string(FlexibleLayouts::Fault::type)});
            else field.type = static_cast<Type>(std::distance(type_names.begin(), it));
        }
        return field;
    }

    FlexibleLayouts& layouts_;
    std::vector<FlexibleSpec>& specs_;
    std::vector<JsonFault>& faults_;
};

std::vector<JsonFault> read_all(const nlohmann::json& array, const std::string& pointer, FlexibleLayouts& layouts,
                                std::vector<FlexibleSpec>& specs) {
    std::vector<JsonFault> faults;
    if (!array.is_array()) return {{pointer, "must be an array of layouts"}};
    LayoutReader reader{layouts, specs, faults};
    for (std::size_t i = 0; i < array.size(); ++i) reader.read(array[i], pointer + "/" + std::to_string(i));
    return faults;
}

Json field_to_json(const FlexibleField& field) {
    Json object{{"name", field.name}};
    if (field.count != 1) object["count"] = field.count;
    if (field.scale != 1) object["scale"] = field.scale;
    object["type"] = name_of(field.type);
    if (!field.unit.empty()) object["unit"] = field.unit;
    return object;
}

}    // namespace

std::vector<JsonFault> add_flexible(const nlohmann::json& array, const std::string& pointer, FlexibleLayouts& layouts) {
    std::vector<FlexibleSpec> specs;
    return read_all(array, pointer, layouts, specs);
}

std::vector<JsonFault> read_flexible(const nlohmann::json& array, const std::string& pointer, std::vector<FlexibleSpec>& specs) {
    FlexibleLayouts layouts;
    for (const FlexibleSpec& spec : specs) layouts.add(spec);
    return read_all(array, pointer, layouts, specs);
}

Json flexible_to_json(const std::vector<FlexibleSpec>& specs) {
    Json array = Json::array();
    for (const FlexibleSpec& spec : specs) {
        Json fields = Json::array();
        for (const FlexibleField& field : spec.fields) fields.push_back(field_to_json(field));
        Json object = Json::object();
        if (spec.endian == ByteOrder::big) object["endian"] = "big";
        object["fields"] = std::move(fields);
        object["id"] = hex_byte(spec.id);
        if (spec.source) object["source"] = *spec.source;
        if (spec.when) object["when"] = *spec.when;
        array.push_back(std::move(object));
    }
    return array;
}

}    // namespace ano
