#include <ano_json/nearest.hpp>
#include <config/config_error.hpp>
#include <config/key_facts.hpp>
#include <config/values.hpp>

#include <algorithm>

namespace anogate {
namespace {

std::string listed(std::string_view choices) {
    std::string text;
    for (const std::string_view choice : split(choices, '|')) text += (text.empty() ? "" : ", ") + std::string{choice};
    return text;
}

std::string between(const std::string& least, const std::string& most) { return " from " + least + " to " + most; }

std::string milliseconds(std::uint64_t count) { return duration_text(std::chrono::milliseconds{count}); }

}    // namespace

bool KeyFacts::is_of(std::string_view kind) const {
    if (kinds.empty() || kind.empty()) return true;
    const auto all = split(kinds, ' ');
    return std::find(all.begin(), all.end(), kind) != all.end();
}

std::string expected(const KeyFacts& key) {
    const std::string least = std::to_string(key.least);
    const std::string most = std::to_string(key.most);
    switch (key.form) {
    case Form::boolean: return "true or false";
    case Form::integer: return "a whole number" + between(least, most);
    case Form::address: return "an address" + between(least, most) + " (or in hex such as 0x05)";
    case Form::can_id: return "a CAN id such as 0x600, at most 0x1FFFFFFF";
    case Form::addresses: return "an address such as 0xDC or a range such as 30-40," + between(least, most);
    case Form::duration: return "a duration such as 500ms, 30s or 2m," + between(milliseconds(key.least), milliseconds(key.most));
    case Form::interval: return "off, on, or a duration such as 5s," + between(milliseconds(key.least), milliseconds(key.most));
    case Form::size: return "a size such as 500kB, 10MB or 1GB";
    case Form::choice:
        return key.choices.find('|') != key.choices.npos ? "one of " + listed(key.choices) : std::string{key.choices};
    case Form::choice_or_link: return "one of " + listed(key.choices) + " or the name of a link";
    case Form::text: return "text of " + least + " to " + most + " bytes";
    case Form::endpoint: return "an IP address and a port such as 127.0.0.1:12333 or [::1]:12333";
    case Form::networks: return "any, or networks such as 192.168.0.0/24";
    case Form::network: return "an IPv4 network such as 192.168.0.0/24";
    case Form::ip: return "an IPv4 address such as 192.168.0.5" + (key.choices.empty() ? "" : " or " + std::string{key.choices});
    case Form::names: return "a list of names of links such as [\"fc\"]";
    case Form::line: return "a line's number such as 17 or its name such as \"GPIO17\"";
    case Form::silence:
        return "\"silent\" and a duration such as \"silent 10s\"," + between(milliseconds(key.least), milliseconds(key.most));
    case Form::frames: return "ids such as 0xF0 or 0x01-0x0F, names of messages such as firmware, or urgent, telemetry, bulk";
    case Form::senders: return "addresses such as 0xFE or ranges such as 30-40";
    case Form::limits: return "an object such as {\"0x01\": 50}: frames a second";
    }
    return {};
}

std::string must_be(const KeyFacts& key, const std::string& given) {
    return in_quotes(key.name) + " must be " + expected(key) + ", not " + given;
}

std::string placeholder(const KeyFacts& key) {
    if (!key.stands_for.empty()) return std::string{key.stands_for};
    switch (key.form) {
    case Form::boolean: return "true|false";
    case Form::integer: return "NUMBER";
    case Form::address: return "ADDR";
    case Form::can_id: return "CAN_ID";
    case Form::addresses: return "ADDR";
    case Form::duration: return "DURATION";
    case Form::interval: return "off|on|DURATION";
    case Form::size: return "SIZE";
    case Form::choice: return std::string{key.choices};
    case Form::choice_or_link: return std::string{key.choices} + "|LINK";
    case Form::text: return "TEXT";
    case Form::endpoint: return "IP:PORT";
    case Form::networks: return "CIDR[+CIDR...]|any";
    case Form::network: return "CIDR";
    case Form::ip: return key.choices.empty() ? "IP" : "IP|" + std::string{key.choices};
    case Form::names: return "[LINK...]";
    case Form::line: return "NUMBER|NAME";
    case Form::silence: return "silent DURATION";
    case Form::frames: return "FRAMES[+FRAMES...]";
    case Form::senders: return "ADDR[+ADDR...]";
    case Form::limits: return "NUMBER";
    }
    return {};
}

std::string unknown_key(std::string_view name, std::span<const KeyFacts* const> keys, std::string_view kind) {
    if (kind == "can" && (name == "bitrate" || name == "dbitrate" || name == "baud"))
        return in_quotes(name) +
               " is not a key of can: the system sets the bit rate, by sudo ip link set can0 up type can bitrate 500000";
    std::vector<std::string_view> usable;
    std::string owners;
    for (const KeyFacts* key : keys) {
        if (key->is_of(kind)) usable.push_back(key->name);
        else if (key->name == name)
            for (const std::string_view owner : split(key->kinds, ' '))
                owners += (owners.empty() ? "" : ", ") + std::string{owner};
    }
    if (!owners.empty()) return in_quotes(name) + " is not a key of " + std::string{kind} + ", but of " + owners;
    return "unknown key " + in_quotes(name) + ano::did_you_mean(name, usable);
}

std::string in_quotes(std::string_view text) { return "'" + printable(std::string{text}) + "'"; }

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t end = 0; end != std::string_view::npos;) {
        end = text.find(separator);
        parts.push_back(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return parts;
}

}    // namespace anogate
