#include "plot_json.hpp"

#include <ano/hex.hpp>
#include <ano_json/escapes.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anoctl {
namespace {

using ano::Json;

bool is_plotted(const Json& value) { return value.is_number() || value.is_boolean(); }

// Removes all values but numbers and booleans. Lists keep their elements, so that the positions stay the same.
Json numbers_of(const Json& value) {
    if (is_plotted(value)) return value;
    if (!value.is_structured()) return {};
    Json kept = value.is_array() ? Json::array() : Json::object();
    bool has_any = false;
    for (const auto& [name, inner] : value.items()) {
        Json numbers = numbers_of(inner);
        has_any = has_any || !numbers.is_null();
        if (value.is_array()) kept.push_back(std::move(numbers));
        else if (!numbers.is_null()) kept[name] = std::move(numbers);
    }
    return has_any ? kept : Json{};
}

}    // namespace

std::vector<std::string> plot_json(ano::FrameView frame, const std::string& link, double time, const ano::JsonOptions& options,
                                   std::size_t max_bytes) {
    const Json decoded = ano::frame_to_json(frame, options);
    const auto fields = decoded.find("fields");
    if (fields == decoded.end()) return {};
    Json numbers = numbers_of(*fields);
    if (numbers.is_null()) return {};
    const std::string name = decoded.value("name", ano::hex_byte(frame.id()));
    Json plot{{"timestamp", time}};
    Json& place = plot[link == "timestamp" ? "link timestamp" : link][ano::hex_byte(frame.source())][name];
    place = Json::object();
    const std::size_t around = ano::json_text(plot).size();
    std::vector<std::string> objects;
    std::size_t size = around;
    for (auto field = numbers.begin(); field != numbers.end(); ++field) {
        const std::size_t more = ano::json_text(Json{{field.key(), field.value()}}).size() -
                                 1;    // a brace is replaced by a comma
        if (size + more > max_bytes && !place.empty()) {
            objects.push_back(ano::json_text(plot));
            place = Json::object();
            size = around;
        }
        place[field.key()] = std::move(field.value());
        size += more;
    }
    objects.push_back(ano::json_text(plot));
    return objects;
}

}    // namespace anoctl
