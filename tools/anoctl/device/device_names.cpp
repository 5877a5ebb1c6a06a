#include "device_names.hpp"

#include <ano_json/lower_case.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/text/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string_view>
#include <utility>

namespace anoctl {

using ano::Json;

Json with_name(const Json& devices, const std::string& name) {
    Json named = Json::array(), alike = Json::array();
    for (const Json& device : devices) {
        const std::string its = text_at(device, "name");
        if (its == name) named.push_back(device);
        if (ano::lower_case(its) == ano::lower_case(name)) alike.push_back(device);
    }
    return named.empty() ? alike : named;
}

std::string list_of(const Json& devices) {
    std::string all;
    for (const Json& device : devices) {
        all += (all.empty() ? "" : ", ") + text_at(device, "address");
        if (const std::string name = text_at(device, "name"); !name.empty()) all += " " + name;
    }
    return all;
}

bool all_have_names(const Json& devices) {
    return std::all_of(devices.begin(), devices.end(), [](const Json& one) { return !text_at(one, "name").empty(); });
}

std::string no_such_device(const std::string& name, const Json& devices) {
    std::vector<std::string> known;
    for (const Json& device : devices)
        for (const char* key : {"name", "address"})
            if (std::string word = text_at(device, key); !word.empty()) known.push_back(std::move(word));
    return "no device " + ano::in_quotes(name) + " responded" +
           ano::did_you_mean(name, std::vector<std::string_view>{known.begin(), known.end()}) +
           (devices.empty() ? "; no devices known" : "; devices: " + list_of(devices));
}

std::string format_device(const Json& device) {
    const std::string name = text_at(device, "name"), address = text_at(device, "address");
    return name.empty() ? address : name + " (" + address + ")";
}

std::string with_device_named(std::string words, const Json& device) {
    const std::string address = text_at(device, "address");
    if (!address.empty() && words.starts_with(address + " ")) words.replace(0, address.size(), format_device(device));
    return words;
}

std::vector<std::string> left_behind(const Json& device) {
    std::vector<std::string> all;
    if (text_at(device, "in_loader") == "true")
        all.emplace_back(
            "a firmware update was interrupted; the device is still in its loader. Flash it again: anoctl flash FILE");
    if (const std::string kept = names_at(device, "kept"); !kept.empty())
        all.push_back("a calibration was interrupted; its old values are kept (" + kept + ") and will be restored when possible");
    if (const std::string dropped = names_at(device, "dropped"); !dropped.empty())
        all.push_back("a calibration was interrupted and its old values were not restored: " + dropped);
    if (const std::string hint = text_at(device, "hint"); !hint.empty()) all.push_back(hint);
    return all;
}

}    // namespace anoctl
