#include <config/config.hpp>
#include <config/difference.hpp>
#include <config/values.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<std::pair<std::string, std::string>>;    // key, value as text

std::string in_words(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    const bool is_list = value.is_array() &&
                         std::none_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); });
    if (!is_list) return value.dump();
    std::string text;
    for (const Json& entry : value) text += (text.empty() ? "" : ", ") + in_words(entry);
    return text.empty() ? "none" : text;
}

/// Adds every key of `object` with its full name: "send.deny".
void add_values(const Json& object, const std::string& before, Values& values) {
    for (const auto& [name, value] : object.items()) {
        if (value.is_object()) add_values(value, before + name + ".", values);
        else values.emplace_back(before + name, in_words(value));
    }
}

const std::string* find(const Values& values, const std::string& key) {
    const auto found = std::find_if(values.begin(), values.end(), [&](const auto& value) { return value.first == key; });
    return found == values.end() ? nullptr : &found->second;
}

std::vector<std::string> differences_of(const Values& before, const Values& after) {
    constexpr char not_set[] = "not set";
    std::vector<std::string> lines;
    for (const auto& [key, value] : before) {
        const std::string* now = find(after, key);
        if (!now || *now != value) lines.push_back(key + ": " + value + " -> " + (now ? *now : not_set));
    }
    for (const auto& [key, value] : after)
        if (!find(before, key)) lines.push_back(key + ": " + not_set + " -> " + value);
    return lines;
}

/// For a list whose order has no meaning.
std::vector<std::string> differences_of_list(const std::string& name, const Json& before, const Json& after) {
    std::vector<std::string> lines;
    Json rest = after;
    for (const Json& entry : before) {
        const auto same = std::find(rest.begin(), rest.end(), entry);
        if (same == rest.end()) lines.push_back(name + ": removed " + in_words(entry));
        else rest.erase(same);
    }
    for (const Json& entry : rest) lines.push_back(name + ": added " + in_words(entry));
    return lines;
}

/// One configuration, divided into the parts that are compared.
class Document {
public:
    explicit Document(const Settings& settings) : settings_{settings}, json_(Json::parse(print_config(settings))) {}

    /// Names in the order of the links, the tunnel last.
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        for (const LinkSettings& link : settings_.links) names.push_back(link.name);
        if (settings_.tunnel) names.emplace_back("tunnel");
        return names;
    }
    /// All settings of a link; empty: there is no link with this name.
    Values link(const std::string& name) const {
        if (name == "tunnel") return tunnel();
        Values values;
        for (const Json& link : json_["links"])
            if (link["name"] == name) add_values(link, "", values);
        for (const AliasSettings& alias : settings_.aliases)
            if (alias.link == name) values.emplace_back("alias of " + address_text(alias.device), address_text(alias.as));
        for (const Json& line : json_["gpio"])
            if (line["use"] == "rs485" && line["link"] == name) add_values(line, "rs485.", values);
        return values;
    }
    Values section(const std::string& name) const {
        Values values;
        if (json_.contains(name)) add_values(json_[name], name + ".", values);
        return values;
    }
    const Json& list(const std::string& name) const { return json_[name]; }

private:
    Values tunnel() const {
        Values values;
        if (!settings_.tunnel) return values;
        add_values(json_["tunnel"], "", values);
        if (settings_.gateway.id != 0) values.emplace_back("gateway.id", std::to_string(settings_.gateway.id));
        std::uint16_t largest = LinkSettings{}.max_data;    // the tunnel must have room for frames of this size
        for (const LinkSettings& link : settings_.links) largest = std::max(largest, link.max_data);
        values.emplace_back("largest max_data of the links", std::to_string(largest));
        return values;
    }

    const Settings& settings_;
    Json json_;
};

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<LinkDifference> differences_of_links(const Document& before, const Document& after) {
    std::vector<LinkDifference> links;
    const std::vector<std::string> were = before.names(), are = after.names();
    for (const std::string& name : are) {
        LinkDifference& link = links.emplace_back(LinkDifference{name, Change::added, {}});
        if (!contains(were, name)) continue;
        link.differences = differences_of(before.link(name), after.link(name));
        link.change = link.differences.empty() ? Change::same : Change::changed;
    }
    for (const std::string& name : were)
        if (!contains(are, name)) links.push_back({name, Change::removed, {}});
    return links;
}

/// Whether the links that are in both have a different order.
bool are_reordered(const Document& before, const Document& after) {
    std::vector<std::string> were = before.names(), are = after.names();
    const auto only_in_one = [](const std::vector<std::string>& all) {
        return [&all](const std::string& name) { return !contains(all, name); };
    };
    const std::vector<std::string> all_were = were, all_are = are;
    std::erase_if(were, only_in_one(all_are));
    std::erase_if(are, only_in_one(all_were));
    return were != are;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) { to.insert(to.end(), more.begin(), more.end()); }

}    // namespace

std::string_view text(Change change) noexcept {
    switch (change) {
    case Change::same: return "same";
    case Change::changed: return "changed";
    case Change::added: return "added";
    case Change::removed: return "removed";
    }
    return "";
}

bool Difference::is_none() const noexcept {
    return gateway.empty() &&
           std::all_of(links.begin(), links.end(), [](const LinkDifference& link) { return link.change == Change::same; });
}

Change Difference::of(std::string_view name) const noexcept {
    const auto found = std::find_if(links.begin(), links.end(), [name](const LinkDifference& link) { return link.name == name; });
    return found == links.end() ? Change::same : found->change;
}

Difference difference(const Settings& before, const Settings& after) {
    const Document old{before}, wanted{after};
    Difference result;
    result.links = differences_of_links(old, wanted);
    append(result.gateway, differences_of(old.section("gateway"), wanted.section("gateway")));
    append(result.gateway, differences_of(old.section("record"), wanted.section("record")));
    for (const char* list : {"routes", "classes", "gpio", "flexible"})
        append(result.gateway, differences_of_list(list, old.list(list), wanted.list(list)));
    if (are_reordered(old, wanted)) result.gateway.emplace_back("links: another order");
    append(result.needs_restart, differences_of(old.section("control"), wanted.section("control")));
    for (std::string& line : differences_of(old.section("log"), wanted.section("log")))
        (line.starts_with("log.level: ") ? result.gateway : result.needs_restart).push_back(std::move(line));
    return result;
}

Settings without_restart(const Settings& running, Settings after) {
    after.control = running.control;
    after.log.file = running.log.file;
    after.log.rotate = running.log.rotate;
    return after;
}

}    // namespace anogate
