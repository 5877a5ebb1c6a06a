#include <foxglove/parameter_book.hpp>

#include <ano_json/compact_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

/// The present value on the device, from a row about one parameter; null: the row does not contain it.
Json reported_value(const Json& row) {
    for (const char* name : {"value", "stored"})
        if (const auto found = row.find(name); found != row.end() && found->is_primitive()) return *found;
    return nullptr;
}

}    // namespace

bool has_parameters(const Job& job) noexcept {
    const JobKind kind = job.order.kind;
    const bool is_about_them = kind == JobKind::parameters || kind == JobKind::write || kind == JobKind::apply;
    return is_about_them && job.is_over() && job.order.address && job.result && job.result->size() <= ParameterBook::max_result;
}

std::vector<foxglove::Parameter> ParameterBook::learn(const Job& job, const std::string& prefix) {
    std::vector<foxglove::Parameter> learned;
    if (!has_parameters(job)) return learned;
    const Json json = Json::parse(*job.result, nullptr, false);
    if (!json.is_object()) return learned;
    const auto list = json.find("parameters");
    const bool is_list = list != json.end() && list->is_array();
    const auto add = [&](const Json& row) {
        if (!row.is_object() || !row.contains("name") || !row["name"].is_string()) return;
        const Json value = reported_value(row);
        std::string name = prefix + row["name"].get<std::string>();
        if (value.is_null() || (values_.size() >= max_values && !values_.contains(name))) return;
        std::string text = ano::compact_json(value);
        values_.insert_or_assign(name, text);
        learned.push_back({std::move(name), std::move(text)});
    };
    if (is_list) std::for_each(list->begin(), list->end(), add);
    else add(json);
    return learned;
}

std::vector<foxglove::Parameter> ParameterBook::all() const {
    std::vector<foxglove::Parameter> all;
    for (const auto& [name, value] : values_) all.push_back({name, value});
    return all;
}

std::vector<foxglove::Parameter> ParameterBook::of(const std::vector<std::string>& names) const {
    std::vector<foxglove::Parameter> known;
    for (const std::string& name : names)
        if (const auto found = values_.find(name); found != values_.end()) known.push_back({name, found->second});
    return known;
}

std::string parameter_prefix(std::string_view link, std::uint8_t address) {
    return std::string{link.empty() ? "gateway" : link} + '/' + std::to_string(address) + '/';
}

}    // namespace anogate
