#include <ano_json/strict_json.hpp>
#include <config/json_text.hpp>

#include <nlohmann/json.hpp>

#include <utility>
#include <vector>

namespace anogate {

std::optional<nlohmann::json> parse_json(std::string_view text, const std::string& file, ConfigErrors& errors) {
    std::vector<ano::JsonFault> faults;
    auto document = ano::strict_json<nlohmann::json>(text, true, faults);
    for (ano::JsonFault& fault : faults) errors.push_back({at(file, fault.pointer), std::move(fault.what)});
    return document;
}

std::string at(const std::string& file, const std::string& pointer) {
    return file.empty() || pointer.empty() ? file + pointer : file + ": " + pointer;
}

}    // namespace anogate
