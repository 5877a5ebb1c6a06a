// The table of keys; everything made from it must have every row.
#include <gtest/gtest.h>
#include <config/config.hpp>
#include <config/help.hpp>
#include <config/keys.hpp>
#include <link/kinds.hpp>
#include <support/files.hpp>
#include <unit/config/faults.hpp>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace anogate::keys_tests {
namespace {

using nlohmann::json;

void for_every_key(auto visit) {
    const auto section = [&](const std::string& name, auto keys) {
        for (const auto& key : keys) visit(name, key);
    };
    section("gateway", gateway_keys());
    for (const LinkKind* kind : link_kinds())
        for (const Key<LinkSettings>* key : keys_of(*kind, link_kinds()).keys) visit(std::string{kind->name}, *key);
    section("routes", route_keys());
    section("alias", alias_keys());
    section("classes", class_keys());
    section("tunnel", tunnel_keys());
    section("wrap", wrap_keys());
    section("gpio", gpio_keys());
    section("control", control_keys());
    section("record", record_keys());
    section("log", log_keys());
}

std::string sample() { return support::file_text(support::source_file("config/anogate.full.json")); }

/// `text` with the commented-out examples activated: lines with // and no space after it. Other comments are kept.
std::string with_examples(const std::string& text) {
    std::string result;
    for (const std::string_view line : split(text, '\n')) {
        const std::size_t slashes = line.find_first_not_of(' ');
        const bool example = slashes != line.npos && line.substr(slashes, 2) == "//" && line.size() > slashes + 2 &&
                             line[slashes + 2] != ' ';
        result += std::string{example ? line.substr(slashes + 2) : line} + "\n";
    }
    return result;
}

// The names of the keys in `object`; the keys of a nested object are preceded by its name and a dot.
void add_names(std::set<std::string>& names, const json& object, const std::string& inside = {}) {
    for (const auto& [name, value] : object.items()) {
        names.insert(inside + name);
        if (value.is_object()) add_names(names, value, inside + name + ".");
    }
}

TEST(Keys, have_unique_names_within_a_kind) {
    for (const LinkKind* kind : link_kinds()) {
        std::set<std::string_view> names;
        for (const Key<LinkSettings>* key : keys_of(*kind, link_kinds()).keys)
            EXPECT_TRUE(names.insert(key->name).second) << kind->name << " " << key->name;
    }
}

TEST(Keys, the_address_of_a_kind_is_required_and_its_example_is_valid) {
    for (const LinkKind* kind : link_kinds()) {
        const auto* key = find_key(kind->keys, kind->address);
        ASSERT_NE(key, nullptr) << kind->name;
        EXPECT_TRUE(key->required) << kind->name;
        LinkSettings link = new_link(*kind);
        EXPECT_EQ(key->set(kind->example, link), "");
    }
}

TEST(Keys, are_written_as_they_are_read) {
    Draft all = parse_config(with_examples(sample()));
    for (const LinkSettings& link : all.settings.links)
        for (const Key<LinkSettings>* key : keys_of(*link.kind, link_kinds()).keys) {
            LinkSettings read = new_link(*link.kind);
            if (!printed(*key, key->get(*key, link))) continue;
            if (const auto text = key->text_in(link)) {
                EXPECT_EQ(key->set(*text, read), "") << key->name;
                EXPECT_EQ(key->text_in(read), text) << key->name;
            } else {
                EXPECT_EQ(key->put(*key, key->get(*key, link), read), "") << key->name;
            }
            EXPECT_EQ(printed(*key, key->get(*key, read)), printed(*key, key->get(*key, link))) << key->name;
        }
}

TEST(Keys, are_all_in_the_help) {
    const std::string help = links_and_keys_help(link_kinds());
    for_every_key([&](const std::string&, const KeyFacts& key) {
        EXPECT_NE(help.find(std::string{key.help}), std::string::npos) << key.name;
        EXPECT_NE(help.find(std::string{key.name}), std::string::npos) << key.name;
    });
    for (const LinkKind* kind : link_kinds()) EXPECT_NE(help.find(std::string{kind->help}), std::string::npos) << kind->name;
}

TEST(Keys, are_all_in_the_schema) {
    const json schema = json::parse(config_schema(link_kinds()))["properties"];
    const auto properties = [&](const std::string& section) -> std::vector<json> {
        if (section == "routes" || section == "alias" || section == "classes" || section == "gpio")
            return {schema[section]["items"]["properties"]};
        if (section == "wrap") return {schema["tunnel"]["properties"]["wrap"]["items"]["properties"]};
        if (schema.contains(section)) return {schema[section]["properties"]};
        std::vector<json> all;
        for (const json& kind : schema["links"]["items"]["anyOf"])
            if (kind["type"] == "object" && kind["properties"]["kind"]["const"] == section) all.push_back(kind["properties"]);
        return all;
    };
    for_every_key([&](const std::string& section, const KeyFacts& key) {
        const auto all = properties(section);
        EXPECT_FALSE(all.empty()) << key.name;
        const auto names = split(key.name, '.');
        for (const json& whole : all) {
            const json& where = names.size() == 2 ? whole.at(std::string{names[0]}).at("properties") : whole;
            EXPECT_TRUE(where.contains(names.back())) << section << " " << key.name;
        }
    });
}

TEST(Sample, is_a_valid_configuration_with_the_defaults) {
    const Draft draft = parse_config(sample());
    EXPECT_EQ(lines(draft.errors), "");
    Settings defaults;
    for (const char* link : {"serial:/dev/ttyUSB0,name=fc", "udp-listen:0.0.0.0:12333,name=ground"}) {
        Draft one{link_kinds()};
        read_link(link, "", one);
        validate(one);
        defaults.links.push_back(one.settings.links[0]);
    }
    EXPECT_EQ(print_config(draft.settings), print_config(defaults));
    EXPECT_EQ(draft.settings, defaults);
}

TEST(Sample, of_a_first_configuration_is_valid_and_has_at_most_25_lines) {
    const std::string text = support::file_text(support::source_file("config/anogate.json"));
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 25);
    const Draft draft = parse_config(text);
    EXPECT_EQ(lines(draft.errors), "");
    const json links = json::parse(text, nullptr, true, true).at("links");
    ASSERT_EQ(links.size(), 2u);
    EXPECT_EQ(links[0].at("profile"), "vendor");
    EXPECT_TRUE(links[0].at("device").get<std::string>().starts_with("/dev/serial/by-id/")) << links[0];
    EXPECT_EQ(links[1].at("kind"), "udp-listen");
    EXPECT_TRUE(draft.settings.control.http) << "the page";
}

TEST(Sample, shows_every_key_in_a_configuration_that_works) {
    const std::string text = with_examples(sample());
    const Draft draft = parse_config(text);
    EXPECT_EQ(lines(draft.errors), "");
    const json document = json::parse(text, nullptr, true, true);
    std::map<std::string, std::set<std::string>> seen;
    add_names(seen["wrap"], document["tunnel"]["wrap"][0]);
    for (const char* section : {"gateway", "tunnel", "control", "record", "log"}) add_names(seen[section], document[section]);
    for (const char* section : {"routes", "alias", "classes"}) add_names(seen[section], document[section][0]);
    for (const json& line : document["gpio"]) add_names(seen["gpio"], line);
    for (const json& link : document["links"])
        if (link.is_object()) add_names(seen[link["kind"].get<std::string>()], link);
    for_every_key([&](const std::string& section, const KeyFacts& key) {
        const bool common = find_key(common_link_keys(), key.name) == &key;
        const auto shows = [&](const std::string& place) { return seen[place].contains(std::string{key.name}); };
        const auto shown_by_any = [&] {
            return std::ranges::any_of(link_kinds(), shows, [](const LinkKind* k) { return std::string{k->name}; });
        };
        EXPECT_TRUE(common ? (key.kinds.empty() ? shows("serial") : shown_by_any()) : shows(section))
            << section << " " << key.name;
    });
}

TEST(Sample, shows_the_default_of_every_key_that_has_one) {
    const Draft draft = parse_config(with_examples(sample()));
    for (const LinkSettings& link : draft.settings.links) {
        if (link.name == "gps" || link.name == "servo" || link.name.starts_with("v7-"))
            continue;    // they have their own examples
        LinkSettings defaults = new_link(*link.kind);
        defaults.queue = LinkSettings{}.queue;
        for (const Key<LinkSettings>* key : keys_of(*link.kind, link_kinds()).keys) {
            const auto usual = key->text_in(defaults);
            if (key->required || !usual) continue;
            EXPECT_EQ(key->text_in(link), usual) << link.name << " " << key->name;
        }
    }
}

}    // namespace
}    // namespace anogate::keys_tests
