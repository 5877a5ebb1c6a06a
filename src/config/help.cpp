#include <config/help.hpp>
#include <config/values.hpp>

namespace anogate {
namespace {

std::string line(std::string_view left, std::string_view right, std::size_t indent) {
    constexpr std::size_t column = 46;
    std::string text = std::string(indent, ' ') + std::string{left};
    text.resize(std::max(text.size() + 2, column), ' ');
    return text + std::string{right} + "\n";
}

/// A default as text; hardware ids in hex.
std::string usual_text(const KeyFacts& key, const std::string& usual) {
    const auto address = key.form == Form::address ? parse_address(usual) : std::nullopt;
    return address ? address_text(*address) : usual;
}

template <class Section>
std::string key_line(const Key<Section>& key, const Section& defaults, std::size_t indent, std::string_view between) {
    return line(std::string{key.name} + (key.form == Form::limits ? ".MESSAGE" : "") + std::string{between} + placeholder(key),
                help_of(key, key.text_in(defaults)), indent);
}

template <class Section>
std::string section(std::string_view name, Keys<Section> keys) {
    std::string text = "  " + std::string{name} + "\n";
    for (const Key<Section>& key : keys) text += key_line(key, Section{}, 4, ": ");
    return text;
}

std::string links(LinkKinds kinds) {
    std::string text;
    for (const LinkKind* kind : kinds) {
        text += line(std::string{kind->name} + ":" + std::string{kind->example}, kind->help, 2);
        const LinkSettings usual = new_link(*kind);
        for (const Key<LinkSettings>& key : kind->keys)
            if (key.name != kind->address) text += key_line(key, usual, 4, "=");
        for (const Key<LinkSettings>* key : keys_of(*kind, kinds).keys)
            if (!key->kinds.empty()) text += key_line(*key, usual, 4, "=");    // a common key of some kinds only
    }
    text += "Keys of every link; a key alone means true; send.deny=... is {\"send\": {\"deny\": [...]}} in the file:\n";
    for (const Key<LinkSettings>& key : common_link_keys())
        if (key.kinds.empty()) text += key_line(key, LinkSettings{}, 4, "=");
    return text;
}

/// The key for the ADDRESS in the file, for each kind.
std::string link_objects(LinkKinds kinds) {
    std::string text = "  links: a list of LINK texts, or of objects with \"kind\", the keys above, and the address:\n";
    for (const LinkKind* kind : kinds) {
        const std::string address = "\"" + std::string{kind->address} + "\": \"" + std::string{kind->example} + "\"";
        const KeyFacts* key = find_key(kind->keys, kind->address);
        text += line("{\"kind\": \"" + std::string{kind->name} + "\", " + address + "}", key->help, 4);
    }
    return text;
}

}    // namespace

std::string help_of(const KeyFacts& key, const std::optional<std::string>& usual) {
    std::string help{key.help};
    if (!key.required && usual && !usual->empty() && help.find("(default") == help.npos)
        help += " (default " + usual_text(key, *usual) + ")";
    return help;
}

std::string short_help(LinkKinds kinds, const std::string& default_file) {
    static constexpr std::size_t column = 30;
    const auto row = [](std::string left, std::string_view right) {
        left.insert(0, "  ");
        left.resize(std::max(left.size() + 2, column), ' ');
        return left.append(right) + "\n";
    };
    std::string text =
        "Forwards ANO V8 frames between devices and ground stations.\n\n"
        "  anogated [OPTIONS] LINK...  with LINK = KIND:ADDRESS[,KEY=VALUE...]\n"
        "  anogated [--config FILE]    default: " +
        default_file + "\n\nLinks:\n";
    for (const LinkKind* kind : kinds)
        if (!kind->encrypts)
            text += row(std::string{kind->name} + ":" + std::string{kind->example},
                        kind->help.substr(0, kind->help.find_first_of(";,.:")));
    text += "\nOptions:\n" + row("--http ADDR:PORT", "serve the page for browsers") +
            row("--route ADDR=LINK", "pin an address (0xDC, 30-40) to a link") +
            row("--check, --print-config", "check the configuration; print it as a file") +
            row("--help all, --version", "show all options, kinds and keys; the version") +
            "\nExample: anogated serial:/dev/ttyUSB0,baud=500000 udp-listen:0.0.0.0:12333\n";
    return text;
}

std::string links_and_keys_help(LinkKinds kinds) {
    return "LINK = KIND:ADDRESS[,KEY=VALUE...]; everything before the first comma after KIND: is the address:\n" + links(kinds) +
           "Configuration file (JSON, comments allowed); durations are written 500ms, 30s, 2m:\n" +
           section("gateway", gateway_keys()) + link_objects(kinds) + section("routes: a list of objects", route_keys()) +
           section("alias: a list of objects", alias_keys()) + section("classes: a list of objects", class_keys()) +
           section("tunnel", tunnel_keys()) + section("tunnel/wrap: a list of objects", wrap_keys()) +
           section("gpio: a list of objects", gpio_keys()) + section("control", control_keys()) +
           section("record", record_keys()) + section("log", log_keys());
}

}    // namespace anogate
