#include <ano_json/fault_json.hpp>

#include <nlohmann/json.hpp>

namespace ano {
namespace {

void add_id(nlohmann::ordered_json& json, const Fault& fault) {
    using Json = nlohmann::ordered_json;
    json["error_id"] = fault.id();
    Json& named = json["error_args"] = Json::object();
    const ArgumentNames names = fault.names();
    for (std::size_t i = 0; i < names.number; ++i) {
        const Fault::Argument& argument = fault.arguments()[i];
        Json& value = named[std::string{names.all[i]}];
        if (argument.fault.empty()) value = argument.text;
        else add_id(value, argument.fault.front());
    }
    for (const Fault& remark : fault.remarks()) add_id(json["error_remarks"].emplace_back(), remark);
}

}    // namespace

void add_fault(nlohmann::ordered_json& json, const Fault& fault) {
    json["error"] = fault.text();
    add_id(json, fault);
}

}    // namespace ano
