#include <ano_json/flexible_json.hpp>
#include <ano_json/json_pointer.hpp>
#include <ano_json/nearest.hpp>
#include <config/config.hpp>
#include <config/json_text.hpp>
#include <config/key_objects.hpp>
#include <config/link_kind.hpp>
#include <config/read_link.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

namespace anogate {
namespace {

using key_objects::is_object;
using key_objects::of_keys;
using key_objects::read_keys;
using nlohmann::json;

class Reader {
public:
    Reader(std::string file, Draft& draft) : file_{std::move(file)}, draft_{draft} {}

    void document(const json& document) {
        if (!is_object(document, file_, draft_.errors)) return;
        constexpr std::string_view names[] = {"gateway", "links",    "routes",  "alias",  "classes", "tunnel",
                                              "gpio",    "flexible", "control", "record", "log"};
        for (const auto& [name, value] : document.items()) {
            const std::string pointer = at(file_, ano::pointer_step(name));
            if (name == "$schema") continue;    // for editors: the path of config/anogate.schema.json
            if (!is_first(name, value, pointer)) continue;
            if (name == "gateway") gateway(value, pointer);
            else if (name == "links" && !value.is_array()) no_links(value, pointer);
            else if (name == "links")
                each(value, pointer, [&](const json& entry, const std::string& where) { link(entry, where); });
            else if (name == "routes")
                each(value, pointer, [&](const json& entry, const std::string& where) { route(entry, where); });
            else if (name == "alias")
                each(value, pointer, [&](const json& entry, const std::string& where) { alias(entry, where); });
            else if (name == "classes")
                each(value, pointer, [&](const json& entry, const std::string& where) { frame_class(entry, where); });
            else if (name == "tunnel") tunnel(value, pointer);
            else if (name == "gpio")
                each(value, pointer, [&](const json& entry, const std::string& where) { gpio(entry, where); });
            else if (name == "flexible") flexible(value, pointer);
            else if (name == "control") {
                section(value, pointer, control_keys(), draft_.settings.control);
                note(draft_.control, value, "socket", {pointer, true});
            } else if (name == "record") {
                draft_.record = {pointer, true};
                section(value, pointer, record_keys(), draft_.settings.record.emplace());
            } else if (name == "log") {
                section(value, pointer, log_keys(), draft_.settings.log);
                note(draft_.log, value, "file", {pointer, true});
            } else draft_.errors.push_back({pointer, unknown(name, names)});
        }
    }

private:
    std::string unknown(const std::string& name, std::span<const std::string_view> names) const {
        const bool of_link = find_key_of_any(draft_.kinds, name) != nullptr || list_of(common_link_keys()).has_object(name);
        if (of_link && find_key(gateway_keys(), name) == nullptr)
            return in_quotes(name) + " is a key of a link: put it into an object in \"links\"";
        return "unknown key " + in_quotes(name) + ano::did_you_mean(name, names);
    }

    /// False: another file has already set `tunnel` or `record`.
    bool is_first(const std::string& name, const json& value, const std::string& pointer) {
        if (name == "tunnel" || name == "record") return is_first("/" + name, pointer, name);
        if (value.is_object() && (name == "gateway" || name == "control" || name == "log"))
            for (const auto& [key, ignored] : value.items())
                is_first("/" + name + ano::pointer_step(key), pointer + ano::pointer_step(key), key);
        return true;
    }

    bool is_first(const std::string& key, const std::string& pointer, const std::string& name) {
        const auto [previous, is_new] = draft_.set_in.emplace(key, file_);
        if (!is_new) draft_.errors.push_back({pointer, in_quotes(name) + " is also set in " + previous->second});
        return is_new;
    }

    /// Errors found later refer to the file with `key`, or else to the first file with this section.
    static void note(Origin& origin, const json& value, std::string_view key, Origin here) {
        if (origin.where.empty() || (value.is_object() && value.contains(key))) origin = std::move(here);
    }

    template <class Section>
    void section(const json& value, const std::string& pointer, Keys<Section> keys, Section& into) {
        const KeyList<Section> list = list_of(keys);
        if (is_object(value, pointer, draft_.errors, of_keys(list))) read_keys(value, {pointer, true}, list, into, draft_.errors);
    }

    void no_list(const json& value, const std::string& pointer) {
        draft_.errors.push_back({pointer, "must be a list [...], not " + format_json(value)});
    }

    void no_links(const json& value, const std::string& pointer) {
        no_list(value, pointer);
        draft_.broken_links = true;
    }

    void each(const json& list, const std::string& pointer, auto read) {
        if (!list.is_array()) no_list(list, pointer);
        for (std::size_t i = 0; list.is_array() && i < list.size(); ++i) read(list[i], pointer + "/" + std::to_string(i));
    }

    void gateway(const json& value, const std::string& pointer) {
        section(value, pointer, gateway_keys(), draft_.settings.gateway);
        note(draft_.unknown, value, "unknown", {pointer + "/unknown"});
    }

    void link(const json& value, const std::string& pointer) {
        if (value.is_string()) return read_link(value.get<std::string>(), pointer, draft_);
        const std::size_t before = draft_.errors.size();
        LinkSettings settings;
        if (!value.is_object() && !value.is_array())
            draft_.errors.push_back({pointer, "must be a LINK text or an object {...}, not " + format_json(value)});
        else if (is_object(value, pointer, draft_.errors) && has_kind(value, pointer)) {
            settings = new_link(*find_link_kind(draft_.kinds, value["kind"].get<std::string>()));
            read_keys(value, {pointer, true}, keys_of(*settings.kind, draft_.kinds), settings, draft_.errors, "kind");
        }
        draft_.add(std::move(settings), {pointer, true, draft_.errors.size() > before});
    }

    bool has_kind(const json& link, const std::string& pointer) {
        const auto kind = link.find("kind");
        if (kind == link.end()) {
            draft_.errors.push_back({pointer, "'kind' is missing, for example \"kind\": \"serial\""});
        } else if (!kind->is_string()) {
            draft_.errors.push_back({pointer + "/kind", "'kind' must be text such as \"serial\", not " + format_json(*kind)});
        } else if (const auto& name = kind->get_ref<const std::string&>(); find_link_kind(draft_.kinds, name) == nullptr) {
            draft_.errors.push_back({pointer + "/kind", unknown_kind(draft_.kinds, name)});
        } else {
            return true;
        }
        return false;
    }

    void route(const json& value, const std::string& pointer) {
        const std::size_t before = draft_.errors.size();
        RouteSettings route;
        section(value, pointer, route_keys(), route);
        if (draft_.errors.size() == before) draft_.add(std::move(route), {pointer, true});
    }

    void alias(const json& value, const std::string& pointer) {
        const std::size_t before = draft_.errors.size();
        AliasSettings alias;
        section(value, pointer, alias_keys(), alias);
        if (draft_.errors.size() == before) draft_.add(std::move(alias), {pointer, true});
    }

    void frame_class(const json& value, const std::string& pointer) {
        const std::size_t before = draft_.errors.size();
        ClassSettings of_id;
        section(value, pointer, class_keys(), of_id);
        if (draft_.errors.size() == before) draft_.add(of_id, {pointer, true});
    }

    void tunnel(const json& value, const std::string& pointer) {
        draft_.tunnel = {pointer, true};
        TunnelSettings& tunnel = draft_.settings.tunnel.emplace();
        if (!is_object(value, pointer, draft_.errors)) return;
        read_keys(value, {pointer, true}, list_of(tunnel_keys()), tunnel, draft_.errors, "wrap");
        if (!value.contains("wrap")) return;
        each(value["wrap"], pointer + "/wrap", [&](const json& entry, const std::string& where) {
            section(entry, where, wrap_keys(), tunnel.wrap.emplace_back());
        });
    }

    // The allowed keys of a line depend on its use.
    void gpio(const json& value, const std::string& pointer) {
        const std::size_t before = draft_.errors.size();
        GpioSettings line;
        std::string use;
        if (value.is_object() && value.contains("use") && value["use"].is_string() &&
            find_key(gpio_keys(), "use")->set(value["use"].get<std::string>(), line).empty())
            use = value["use"].get<std::string>();
        if (is_object(value, pointer, draft_.errors))
            read_keys(value, {pointer, true}, list_of(gpio_keys(), use), line, draft_.errors);
        draft_.add(std::move(line), {pointer, true, draft_.errors.size() > before});
    }

    void flexible(const json& value, const std::string& pointer) {
        for (ano::JsonFault& fault : ano::read_flexible(value, pointer, draft_.settings.flexible))
            draft_.errors.push_back({std::move(fault.pointer), std::move(fault.what)});
    }

    std::string file_;
    Draft& draft_;
};

}    // namespace

void read_config(std::string_view text, const std::string& file, Draft& draft) {
    if (const auto document = parse_json(text, file, draft.errors)) Reader{file, draft}.document(*document);
    else draft.broken_links = true;
}

Draft parse_config(std::string_view json, LinkKinds kinds, const std::string& file) {
    Draft draft{kinds};
    read_config(json, file, draft);
    validate(draft);
    return draft;
}

}    // namespace anogate
