#include <ano/hex.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/nearest.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <iterator>
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
        constexpr std::array<std::string_view, 3> keys{"id", "source", "fields"};
        const std::size_t faults_before = faults_.size();
        if (!check_keys(given, pointer, keys)) return;
        const auto id = id_at(given, pointer);
        std::optional<std::uint8_t> source;
        if (given.contains("source")) {
            source = byte(given["source"]);
            if (!source || *source == 0 || *source == 255) fault(pointer + "/source", "an address is 1 to 254");
        }
        auto fields = fields_at(given, pointer);
        if (faults_.size() != faults_before || !id) return;
        if (const auto refusal = layouts_.add(*id, source, fields)) {
            using enum FlexibleLayouts::Fault;
            const bool at_field = refusal.fault == name || refusal.fault == type || refusal.fault == scale;
            const std::string where = at_field ? "/fields/" + std::to_string(refusal.field) : "";
            fault(pointer + where, std::string{text_of(refusal.fault)});
        } else {
            specs_.push_back({*id, source, std::move(fields)});
        }
    }

private:
    void fault(std::string pointer, std::string what) { faults_.push_back({std::move(pointer), std::move(what)}); }

    bool check_keys(const nlohmann::json& given, const std::string& pointer, std::span<const std::string_view> keys) {
        if (!given.is_object()) {
            fault(pointer, "this is to be an object");
            return false;
        }
        for (const auto& [key, value] : given.items())
            if (std::find(keys.begin(), keys.end(), key) == keys.end())
                fault(pointer + "/" + key, "unknown key " + in_quotes(key) + did_you_mean(key, keys));
        return true;
    }

    static std::optional<std::uint8_t> byte(const nlohmann::json& value) {
        std::optional<Number> number;
        if (value.is_number_integer()) number = value.get<std::int64_t>();
        if (value.is_string()) number = parse_number(value.get_ref<const std::string&>());
        if (!number) return std::nullopt;
        const double n = std::visit([](auto v) { return static_cast<double>(v); }, *number);
        for (int i = 0; i < 256; ++i)
            if (n == i) return static_cast<std::uint8_t>(i);
        return std::nullopt;
    }

    std::optional<std::uint8_t> id_at(const nlohmann::json& given, const std::string& pointer) {
        if (!given.contains("id")) {
            fault(pointer, "key 'id' is missing");
            return std::nullopt;
        }
        const nlohmann::json& value = given["id"];
        auto id = byte(value);
        if (!id && value.is_string())
            if (const Message* message = find_message(value.get_ref<const std::string&>())) id = message->id;
        if (!id || !is_flexible(*id)) fault(pointer + "/id", std::string{text_of(FlexibleLayouts::Fault::id)});
        return id;
    }

    std::vector<FlexibleField> fields_at(const nlohmann::json& given, const std::string& pointer) {
        std::vector<FlexibleField> fields;
        if (!given.contains("fields")) {
            fault(pointer, "key 'fields' is missing");
        } else if (!given["fields"].is_array()) {
            fault(pointer + "/fields", "this is to be an array of fields");
        } else {
            for (std::size_t i = 0; i < given["fields"].size(); ++i)
                fields.push_back(field(given["fields"][i], pointer + "/fields/" + std::to_string(i)));
        }
        return fields;
    }

    FlexibleField field(const nlohmann::json& given, const std::string& pointer) {
        constexpr std::array<std::string_view, 4> keys{"name", "type", "scale", "unit"};
        FlexibleField field;
        if (!check_keys(given, pointer, keys)) return field;
        for (const char* key : {"name", "type"}) {
            if (!given.contains(key)) fault(pointer, std::string{"key '"} + key + "' is missing");
            else if (!given[key].is_string()) fault(pointer + "/" + key, "this is to be text");
        }
        if (given.contains("unit")) {
            if (given["unit"].is_string()) field.unit = given["unit"].get<std::string>();
            else fault(pointer + "/unit", "this is to be text");
        }
        if (given.contains("scale")) {
            if (given["scale"].is_number()) field.scale = given["scale"].get<double>();
            else fault(pointer + "/scale", "this is to be a number");
        }
        if (given.contains("name") && given["name"].is_string()) field.name = given["name"].get<std::string>();
        if (given.contains("type") && given["type"].is_string()) {
            const auto& word = given["type"].get_ref<const std::string&>();
            const auto it = std::find(type_names.begin(), type_names.end(), word);
            // A word that is not a type of the protocol is refused here, with the nearest type; a type that flexible
            // frames can't have is refused by FlexibleLayouts.
            if (it == type_names.end())
                fault(pointer + "/type", "unknown type " + in_quotes(word) + did_you_mean(word, type_names) + "; " +
                                             std::string{text_of(FlexibleLayouts::Fault::type)});
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
    if (!array.is_array()) return {{pointer, "this is to be an array of layouts"}};
    LayoutReader reader{layouts, specs, faults};
    for (std::size_t i = 0; i < array.size(); ++i) reader.read(array[i], pointer + "/" + std::to_string(i));
    return faults;
}

Json field_to_json(const FlexibleField& field) {
    Json object{{"name", field.name}};
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
    for (const FlexibleSpec& spec : specs) layouts.add(spec.id, spec.source, spec.fields);
    return read_all(array, pointer, layouts, specs);
}

Json flexible_to_json(const std::vector<FlexibleSpec>& specs) {
    Json array = Json::array();
    for (const FlexibleSpec& spec : specs) {
        Json fields = Json::array();
        for (const FlexibleField& field : spec.fields) fields.push_back(field_to_json(field));
        Json object{{"fields", std::move(fields)}, {"id", hex_byte(spec.id)}};
        if (spec.source) object["source"] = *spec.source;
        array.push_back(std::move(object));
    }
    return array;
}

}    // namespace ano
