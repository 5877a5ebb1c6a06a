#include <ano_json/flexible_json.hpp>
#include <ano_json/nearest.hpp>
#include <config/config.hpp>
#include <config/json_text.hpp>
#include <config/keys.hpp>
#include <config/read_link.hpp>
#include <link/kinds.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using nlohmann::json;

/// For an error: the value, or what it is when it is no short one.
std::string shown(const json& value) {
    if (value.is_object()) return "an object";
    if (value.is_array()) return "a list";
    if (value.is_string()) return "the text " + printable(value.dump());
    return printable(value.dump());
}

/// "any", or a list of texts; a text may not stand for several.
std::optional<std::string> networks_text(const json& value) {
    if (value.is_string()) return value == "any" ? std::optional<std::string>{"any"} : std::nullopt;
    if (!value.is_array() || value.empty()) return std::nullopt;
    std::string text;
    for (const json& entry : value) {
        if (!entry.is_string() || entry == "any" || entry.get_ref<const std::string&>().find('+') != std::string::npos)
            return std::nullopt;
        text += (text.empty() ? "" : "+") + entry.get<std::string>();
    }
    return text;
}

/// One name a line. A name with a line break is no link's name: left in, it is refused as such.
std::optional<std::string> names_text(const json& value) {
    if (!value.is_array()) return std::nullopt;
    std::string text;
    for (const json& entry : value) {
        if (!entry.is_string() || entry == "" || entry.get_ref<const std::string&>().find('\n') != std::string::npos)
            return std::nullopt;
        text += (text.empty() ? "" : "\n") + entry.get<std::string>();
    }
    return text;
}

/// Words and numbers, joined by +.
std::optional<std::string> words_text(const json& value) {
    if (!value.is_array() || value.empty()) return std::nullopt;
    std::string text;
    for (const json& entry : value) {
        if (!entry.is_string() && !entry.is_number_integer()) return std::nullopt;
        const std::string word = entry.is_string() ? entry.get<std::string>() : entry.dump();
        if (word.find('+') != std::string::npos) return std::nullopt;
        text += (text.empty() ? "" : "+") + word;
    }
    return text;
}

/// The value as it stands in a LINK text; nothing when it is not of the key's JSON type.
std::optional<std::string> text_of(const json& value, Form form) {
    const auto digits = [&] { return value.is_number_integer() ? std::optional{value.dump()} : std::nullopt; };
    const auto text = [&] { return value.is_string() ? std::optional{value.get<std::string>()} : std::nullopt; };
    switch (form) {
    case Form::boolean: return value.is_boolean() ? std::optional{value.dump()} : std::nullopt;
    case Form::interval: return value.is_boolean() ? std::optional{value.dump()} : text();
    case Form::integer: return digits();
    case Form::address:
    case Form::can_id:
    case Form::addresses:
    case Form::size: return value.is_string() ? text() : digits();
    case Form::line: return value.is_string() ? text() : value.is_number_unsigned() ? digits() : std::nullopt;
    case Form::networks: return networks_text(value);
    case Form::names: return names_text(value);
    case Form::frames:
    case Form::senders: return words_text(value);
    case Form::limits: return std::nullopt;    // each of its keys is read by itself
    case Form::network:
    case Form::ip:
    case Form::duration:
    case Form::silence:
    case Form::choice:
    case Form::choice_or_link:
    case Form::text:
    case Form::endpoint: return text();
    }
    return std::nullopt;
}

/// `keys`: those it has, " of level, file"; empty where they are too many to tell.
bool is_object(const json& value, const std::string& where, ConfigErrors& errors, const std::string& keys = {}) {
    if (!value.is_object()) errors.push_back({where, "must be an object {...}" + keys + ", not " + shown(value)});
    return value.is_object();
}

/// " of allow, deny": the keys whose names begin with `inside`, "send.".
template <class Section>
std::string of_keys(Keys<Section> keys, std::string_view inside = {}) {
    std::string names;
    for (const Key<Section>& key : keys)
        if (key.name.starts_with(inside)) names.append(names.empty() ? " of " : ", ").append(key.name.substr(inside.size()));
    return names;
}

/// What must be a list, for one text may be several in a LINK text only.
bool is_a_list(Form form, const json& value) {
    return form == Form::frames || form == Form::senders || (form == Form::networks && value.is_string() && value != "any");
}

/// "send.deny" of a LINK text, as it is in a file.
std::string nested(const std::string& name) {
    const std::size_t dot = name.find('.');
    return printable("\"" + name.substr(0, dot) + "\": {\"" + name.substr(dot + 1) + "\": ...}");
}

/// One entry of a limit, {"0x01": 50}.
template <class Section>
std::string read_entry(const Key<Section>& key, const std::string& name, const json& value, Section& section) {
    if (!value.is_number()) return in_quotes(name) + " must be a number of frames a second, not " + shown(value);
    return key.set(name + "=" + value.dump(), section);
}

/// Every key of `object` into `section`; the kind of a link is known already. `inside` is what comes before their names in
/// the table: "send.".
template <class Section>
void read_keys(const json& object, const Origin& origin, Keys<Section> keys, Section& section, ConfigErrors& errors,
               std::string_view kind = {}, std::string_view but = {}, const std::string& inside = {}) {
    for (const auto& [name, value] : object.items()) {
        if (!but.empty() && name == but) continue;
        const auto where = origin.where + pointer_step(name);
        const std::string full = inside + name;
        const Key<Section>* key = name.find('.') == name.npos ? find_key(keys, full, kind) : nullptr;
        std::string error;
        if (key == nullptr && is_object_of_keys(keys, full, kind)) {
            if (is_object(value, where, errors, of_keys(keys, full + ".")))
                read_keys(value, {where, true}, keys, section, errors, kind, but, full + ".");
        } else if (key == nullptr) {
            const std::string object_of = full.substr(0, full.find('.'));
            const bool dotted = name.find('.') != name.npos && (is_object_of_keys(keys, object_of, kind) || object_of == "limit");
            error = dotted ? "unknown key " + in_quotes(name) + ": in a file it is " + nested(full)
                           : unknown_key_of(keys, full, kind);
        } else if (key->form == Form::limits) {
            if (!is_object(value, where, errors)) continue;
            for (const auto& [entry, rate] : value.items())
                if (std::string wrong = read_entry(*key, entry, rate, section); !wrong.empty())
                    errors.push_back({where + pointer_step(entry), std::move(wrong)});
        } else if (is_a_list(key->form, value) && !value.is_array()) {
            error = in_quotes(full) + " must be a list" +
                    (value.is_string() ? " such as [" + printable(value.dump()) + "]" : "") + ", not " + shown(value);
        } else {
            const auto text = text_of(value, key->form);
            error = text ? key->set(*text, section) : must_be(*key, shown(value));
        }
        if (!error.empty()) errors.push_back({where, std::move(error)});
    }
    if (!inside.empty()) return;
    for (const Key<Section>& key : keys)
        if (key.required && key.is_of(kind) && !object.contains(key.name))
            errors.push_back({origin.where, in_quotes(key.name) + " is missing" +
                                                (key.form == Form::choice ? ", " + expected(key) : "") + ": " +
                                                std::string{key.help}});
}

class Reader {
public:
    Reader(std::string file, Draft& draft) : file_{std::move(file)}, draft_{draft} {}

    void document(const json& document) {
        if (!is_object(document, file_, draft_.errors)) return;
        constexpr std::string_view names[] = {"gateway", "links",    "routes",  "alias", "tunnel",
                                              "gpio",    "flexible", "control", "log"};
        for (const auto& [name, value] : document.items()) {
            const std::string pointer = at(file_, pointer_step(name));
            if (name == "$schema") continue;    // how a file tells editors where config/anogate.schema.json is
            if (name == "gateway") gateway(value, pointer);
            else if (name == "links" && !value.is_array()) no_links(value, pointer);
            else if (name == "links")
                each(value, pointer, [&](const json& entry, const std::string& where) { link(entry, where); });
            else if (name == "routes")
                each(value, pointer, [&](const json& entry, const std::string& where) { route(entry, where); });
            else if (name == "alias")
                each(value, pointer, [&](const json& entry, const std::string& where) { alias(entry, where); });
            else if (name == "tunnel") tunnel(value, pointer);
            else if (name == "gpio")
                each(value, pointer, [&](const json& entry, const std::string& where) { gpio(entry, where); });
            else if (name == "flexible") flexible(value, pointer);
            else if (name == "control")
                section(value, pointer, control_keys(), draft_.settings.control), draft_.control = {pointer, true};
            else if (name == "log") section(value, pointer, log_keys(), draft_.settings.log), draft_.log = {pointer, true};
            else draft_.errors.push_back({pointer, "unknown key " + in_quotes(name) + ano::did_you_mean(name, names)});
        }
    }

private:
    template <class Section>
    void section(const json& value, const std::string& pointer, Keys<Section> keys, Section& into) {
        if (is_object(value, pointer, draft_.errors, of_keys(keys))) read_keys(value, {pointer, true}, keys, into, draft_.errors);
    }

    void no_list(const json& value, const std::string& pointer) {
        draft_.errors.push_back({pointer, "must be a list [...], not " + shown(value)});
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
        draft_.unknown = {pointer + "/unknown"};
    }

    void link(const json& value, const std::string& pointer) {
        if (value.is_string()) return read_link(value.get<std::string>(), pointer, draft_);
        const std::size_t before = draft_.errors.size();
        LinkSettings settings;
        if (!value.is_object() && !value.is_array())
            draft_.errors.push_back({pointer, "must be a LINK text or an object {...}, not " + shown(value)});
        else if (is_object(value, pointer, draft_.errors) && has_kind(value, pointer)) {
            settings = new_link(value["kind"].get<std::string>());
            read_keys(value, {pointer, true}, link_keys(), settings, draft_.errors, settings.kind, "kind");
        }
        draft_.add(std::move(settings), {pointer, true, draft_.errors.size() > before});
    }

    bool has_kind(const json& link, const std::string& pointer) {
        const auto kind = link.find("kind");
        if (kind == link.end()) {
            draft_.errors.push_back({pointer, "'kind' is missing, for example \"kind\": \"serial\""});
        } else if (!kind->is_string()) {
            draft_.errors.push_back({pointer + "/kind", "'kind' must be text such as \"serial\", not " + shown(*kind)});
        } else if (const auto& name = kind->get_ref<const std::string&>(); find_link_kind(name) == nullptr) {
            draft_.errors.push_back({pointer + "/kind", unknown_kind(name)});
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

    void tunnel(const json& value, const std::string& pointer) {
        draft_.tunnel = {pointer, true};
        TunnelSettings& tunnel = draft_.settings.tunnel.emplace();
        if (!is_object(value, pointer, draft_.errors)) return;
        read_keys(value, {pointer, true}, tunnel_keys(), tunnel, draft_.errors, {}, "wrap");
        if (!value.contains("wrap")) return;
        each(value["wrap"], pointer + "/wrap", [&](const json& entry, const std::string& where) {
            section(entry, where, wrap_keys(), tunnel.wrap.emplace_back());
        });
    }

    // Which keys it may have depends on its use.
    void gpio(const json& value, const std::string& pointer) {
        const std::size_t before = draft_.errors.size();
        GpioSettings line;
        std::string use;
        if (value.is_object() && value.contains("use") && value["use"].is_string() &&
            find_key(gpio_keys(), "use")->set(value["use"].get<std::string>(), line).empty())
            use = value["use"].get<std::string>();
        if (is_object(value, pointer, draft_.errors)) read_keys(value, {pointer, true}, gpio_keys(), line, draft_.errors, use);
        draft_.add(std::move(line), {pointer, true, draft_.errors.size() > before});
    }

    void flexible(const json& value, const std::string& pointer) {
        ano::FlexibleLayouts layouts;
        for (ano::JsonFault& fault : ano::add_flexible(value, pointer, layouts))
            draft_.errors.push_back({std::move(fault.pointer), std::move(fault.what)});
        draft_.settings.flexible = value.dump();
    }

    std::string file_;
    Draft& draft_;
};

}    // namespace

void read_config(std::string_view text, const std::string& file, Draft& draft) {
    if (const auto document = parse_json(text, file, draft.errors)) Reader{file, draft}.document(*document);
    else draft.broken_links = true;
}

Draft parse_config(std::string_view json, const std::string& file) {
    Draft draft;
    read_config(json, file, draft);
    validate(draft);
    return draft;
}

}    // namespace anogate
