#include <config/config_error.hpp>
#include <config/form.hpp>
#include <config/frame_words.hpp>
#include <config/key_facts.hpp>
#include <config/read_value.hpp>
#include <config/values.hpp>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace anogate {
namespace {

using nlohmann::json;
using Json = nlohmann::ordered_json;
using ano::Duration;

// FormRow::words.

std::optional<Words> boolean_words(const json& value) {
    return value.is_boolean() ? std::optional{Words{value.dump()}} : std::nullopt;
}
std::optional<Words> integer_words(const json& value) {
    return value.is_number_integer() ? std::optional{Words{value.dump()}} : std::nullopt;
}
std::optional<Words> number_words(const json& value) {
    return value.is_number() ? std::optional{Words{value.dump()}} : std::nullopt;
}
std::optional<Words> text_words(const json& value) {
    return value.is_string() ? std::optional{Words{value.get<std::string>()}} : std::nullopt;
}
std::optional<Words> boolean_or_text_words(const json& value) {
    return value.is_boolean() ? boolean_words(value) : text_words(value);
}
std::optional<Words> integer_or_text_words(const json& value) {
    return value.is_string() ? text_words(value) : integer_words(value);
}
std::optional<Words> count_or_text_words(const json& value) {
    return value.is_string() || value.is_number_unsigned() ? integer_or_text_words(value) : std::nullopt;
}

/// The entries of an array; std::nullopt: `is_word` refuses one.
std::optional<Words> words_from_list(const json& value, bool (*is_word)(const json&)) {
    if (!value.is_array()) return std::nullopt;
    Words words;
    for (const json& entry : value) {
        if (!is_word(entry)) return std::nullopt;
        words.push_back(entry.is_string() ? entry.get<std::string>() : entry.dump());
    }
    return words;
}

bool has(const json& text, char c) { return text.get_ref<const std::string&>().find(c) != std::string::npos; }

// A single text is one word here; only in a LINK text several are joined by +.
std::optional<Words> list_words(const json& value) {
    if (value.is_array() && value.empty()) return std::nullopt;
    return words_from_list(
        value, [](const json& entry) { return entry.is_number_integer() || (entry.is_string() && !has(entry, '+')); });
}
std::optional<Words> networks_words(const json& value) {
    if (value.is_string()) return value == "any" ? text_words(value) : std::nullopt;
    if (value.is_array() && value.empty()) return std::nullopt;
    return words_from_list(value, [](const json& entry) { return entry.is_string() && entry != "any" && !has(entry, '+'); });
}
std::optional<Words> names_words(const json& value) {
    return words_from_list(value, [](const json& entry) { return entry.is_string() && entry != "" && !has(entry, '\n'); });
}
std::optional<Words> joined_names_words(const json& value) {
    return words_from_list(value, [](const json& entry) { return entry.is_string() && !has(entry, '+'); });
}
// For Form::limits, whose entries are read one by one.
std::optional<Words> no_words(const json&) { return std::nullopt; }

// FormRow::print. printed() treats an empty list or text as not set.

Json print_boolean(const KeyFacts&, const Value& value) { return std::get<bool>(value); }
Json print_number(const KeyFacts&, const Value& value) { return std::get<std::uint64_t>(value); }
Json print_decimal(const KeyFacts&, const Value& value) {
    const auto thousandths = std::get<std::uint64_t>(value);
    return thousandths % 1000 == 0 ? Json(thousandths / 1000) : Json(static_cast<double>(thousandths) / 1000);
}
Json print_can_id(const KeyFacts&, const Value& value) { return can_id_text(std::get<std::uint64_t>(value)); }
Json print_size(const KeyFacts&, const Value& value) { return size_text(std::get<std::uint64_t>(value)); }
Json print_addresses(const KeyFacts&, const Value& value) { return addresses_text(std::get<ByteRange>(value)); }
Json print_duration(const KeyFacts&, const Value& value) { return duration_text(std::get<Duration>(value)); }
Json print_interval(const KeyFacts& key, const Value& value) {
    if (const bool* on = std::get_if<bool>(&value)) return *on ? "on" : "off";
    return print_duration(key, value);
}
Json print_silence(const KeyFacts&, const Value& value) { return "silent " + duration_text(std::get<Duration>(value)); }
Json print_text(const KeyFacts&, const Value& value) { return std::get<std::string>(value); }
Json print_endpoint(const KeyFacts&, const Value& value) { return std::get<EndpointSpec>(value).text(); }
Json print_host(const KeyFacts&, const Value& value) { return std::get<HostSpec>(value).text(); }
Json print_network(const KeyFacts& key, const Value& value) {
    const auto* network = std::get_if<Network>(&value);
    return network ? Json(network->text()) : print_text(key, value);
}
Json print_networks(const KeyFacts&, const Value& value) {
    const auto& list = std::get<NetworkList>(value);
    if (list.any) return "any";
    Json texts = Json::array();
    for (const Network& network : list.networks) texts.push_back(network.text());
    for (const std::string& host : list.hosts) texts.push_back(host);
    return texts;
}
Json print_ip(const KeyFacts& key, const Value& value) {
    const auto* address = std::get_if<IpAddress>(&value);
    return address ? Json(address->text()) : print_text(key, value);
}
Json print_names(const KeyFacts&, const Value& value) { return std::get<std::vector<std::string>>(value); }
Json print_line(const KeyFacts&, const Value& value) {
    const auto& text = std::get<std::string>(value);
    const auto number = parse_number(text);
    return number ? Json(*number) : Json(text);
}
Json print_ranges(const KeyFacts&, const Value& value) {
    Json list = Json::array();
    for (const ByteRange& range : std::get<std::vector<ByteRange>>(value)) list.push_back(range_text(range));
    return list;
}
Json print_limits(const KeyFacts&, const Value& value) {
    Json object = Json::object();
    for (const LimitRule& rule : std::get<std::vector<LimitRule>>(value)) {
        const auto whole = static_cast<std::uint64_t>(rule.per_second);
        object[address_text(rule.id)] = static_cast<double>(whole) == rule.per_second ? Json(whole) : Json(rule.per_second);
    }
    return object;
}

// FormRow::schema.

Json number_schema(const KeyFacts& key) { return {{"type", "integer"}, {"minimum", key.min}, {"maximum", key.max}}; }
Json pattern(const char* text) { return {{"type", "string"}, {"pattern", text}}; }
Json any_string(const KeyFacts&) { return {{"type", "string"}}; }
Json choices_schema(const KeyFacts& key) {
    Json list = Json::array();
    for (const std::string_view choice : split(key.choices, '|')) list.push_back(choice);
    return {{"enum", list}};
}
Json text_schema(const KeyFacts& key) { return {{"type", "string"}, {"minLength", key.min}, {"maxLength", key.max}}; }
Json id_schema(const KeyFacts& key) { return {{"anyOf", {number_schema(key), pattern("^(0[xX][0-9A-Fa-f]+|[0-9]+)$")}}}; }
Json words_schema(const KeyFacts&) {
    return {{"type", "array"}, {"items", {{"type", Json::array({"string", "integer"})}}}, {"minItems", 1}};
}

// FormRow::expected and FormRow::placeholder.

std::string between(const std::string& min, const std::string& max) { return " from " + min + " to " + max; }
std::string numbers_of(const KeyFacts& key) { return between(std::to_string(key.min), std::to_string(key.max)); }
std::string times_of(const KeyFacts& key) {
    const auto time = [](std::uint64_t count) { return duration_text(std::chrono::milliseconds{count}); };
    return between(time(key.min), time(key.max));
}
std::string listed(std::string_view choices) {
    std::string text;
    for (const std::string_view choice : split(choices, '|')) text += (text.empty() ? "" : ", ") + std::string{choice};
    return text;
}
std::string choice_expected(const KeyFacts& key) {
    return key.choices.find('|') != key.choices.npos ? "one of " + listed(key.choices) : std::string{key.choices};
}
std::string or_choices(std::string text, std::string_view choices) {
    return choices.empty() ? text : text.append("|").append(choices);
}

using Facts = const KeyFacts&;

constexpr FormRow rows[] = {
    {.form = Form::boolean,
     .may_be_alone = true,
     .words = boolean_words,
     .read = read_value::boolean,
     .print = print_boolean,
     .schema = [](Facts) -> Json {
         return {{"type", "boolean"}};
     },
     .expected = [](Facts) { return std::string{"true or false"}; },
     .placeholder = [](Facts) { return std::string{"true|false"}; }},
    {.form = Form::integer,
     .words = integer_words,
     .read = read_value::integer,
     .print = print_number,
     .schema = number_schema,
     .expected = [](Facts key) { return "a whole number" + numbers_of(key); },
     .placeholder = [](Facts) { return std::string{"NUMBER"}; }},
    {.form = Form::decimal,
     .words = number_words,
     .read = read_value::decimal,
     .print = print_decimal,
     .schema = [](Facts key) -> Json {
         return {{"type", "number"}, {"minimum", key.min / 1000}, {"maximum", key.max / 1000}};
     },
     .expected =
         [](Facts key) {
             return "a number" + between(std::to_string(key.min / 1000), std::to_string(key.max / 1000)) +
                    " such as 2 or 0.5, with at most three decimals";
         },
     .placeholder = [](Facts) { return std::string{"NUMBER"}; }},
    {.form = Form::address,
     .words = integer_or_text_words,
     .read = read_value::address,
     .print = print_number,
     .schema = id_schema,
     .expected = [](Facts key) { return "an address" + numbers_of(key) + " (or in hex such as 0x05)"; },
     .placeholder = [](Facts) { return std::string{"ADDR"}; }},
    {.form = Form::can_id,
     .words = integer_or_text_words,
     .read = read_value::can_id,
     .print = print_can_id,
     .schema = id_schema,
     .expected = [](Facts) { return std::string{"a CAN id such as 0x600, at most 0x1FFFFFFF"}; },
     .placeholder = [](Facts) { return std::string{"CAN_ID"}; }},
    {.form = Form::addresses,
     .words = integer_or_text_words,
     .read = read_value::addresses,
     .print = print_addresses,
     .schema = [](Facts key) -> Json {
         return {{"anyOf", {number_schema(key), pattern("^(0[xX][0-9A-Fa-f]+|[0-9]+)(-(0[xX][0-9A-Fa-f]+|[0-9]+))?$")}}};
     },
     .expected = [](Facts key) { return "an address such as 0xDC or a range such as 30-40," + numbers_of(key); },
     .placeholder = [](Facts) { return std::string{"ADDR"}; }},
    {.form = Form::duration,
     .words = text_words,
     .read = read_value::duration,
     .print = print_duration,
     .schema = [](Facts) { return pattern("^[0-9]+(ms|s|m|h)$"); },
     .expected =
         [](Facts key) {
             return "a duration such as " + std::string{key.min < 1000 ? "500ms, " : ""} + "30s or 2m," + times_of(key);
         },
     .placeholder = [](Facts) { return std::string{"DURATION"}; }},
    {.form = Form::interval,
     .may_be_alone = true,
     .words = boolean_or_text_words,
     .read = read_value::interval,
     .print = print_interval,
     .schema = [](Facts) -> Json {
         return {{"anyOf", {Json{{"type", "boolean"}}, pattern("^(on|off|[0-9]+(ms|s|m|h))$")}}};
     },
     .expected = [](Facts key) { return "off, on, or a duration such as 5s," + times_of(key); },
     .placeholder = [](Facts) { return std::string{"off|on|DURATION"}; }},
    {.form = Form::size,
     .words = integer_or_text_words,
     .read = read_value::size,
     .print = print_size,
     .schema = [](Facts key) -> Json {
         return {{"anyOf", {number_schema(key), pattern("^[0-9]+([kKMG]B|[KMG]iB)?$")}}};
     },
     .expected = [](Facts) { return std::string{"a size such as 500kB, 10MB or 1GB"}; },
     .placeholder = [](Facts) { return std::string{"SIZE"}; }},
    {.form = Form::choice,
     .words = text_words,
     .read = read_value::choice,
     .print = print_text,
     .schema = choices_schema,
     .expected = choice_expected,
     .placeholder = [](Facts key) { return std::string{key.choices}; }},
    {.form = Form::choice_or_link,
     .words = text_words,
     .read = read_value::choice_or_link,
     .print = print_text,
     .schema = [](Facts key) -> Json {
         return {{"anyOf", {choices_schema(key), Json{{"type", "string"}, {"minLength", key.min}}}}};
     },
     .expected = [](Facts key) { return "one of " + listed(key.choices) + " or the name of a link"; },
     .placeholder = [](Facts key) { return std::string{key.choices} + "|LINK"; }},
    {.form = Form::text,
     .words = text_words,
     .read = read_value::text,
     .print = print_text,
     .schema = text_schema,
     .expected = [](Facts key) { return "text of " + std::to_string(key.min) + " to " + std::to_string(key.max) + " bytes"; },
     .placeholder = [](Facts) { return std::string{"TEXT"}; }},
    {.form = Form::endpoint,
     .words = text_words,
     .read = read_value::endpoint,
     .print = print_endpoint,
     .schema = [](Facts) { return pattern("^.+:[0-9]+$"); },
     .expected = [](Facts) { return std::string{"an IP address and a port such as 127.0.0.1:12333 or [::1]:12333"}; },
     .placeholder = [](Facts) { return std::string{"IP:PORT"}; }},
    {.form = Form::host,
     .words = text_words,
     .read = read_value::host,
     .print = print_host,
     .schema = [](Facts) { return pattern("^.+:[0-9]+$"); },
     .expected =
         [](Facts) { return std::string{"a host name or IP address, and a port, such as 192.168.4.1:8888 or flow.local:8888"}; },
     .placeholder = [](Facts) { return std::string{"HOST:PORT"}; }},
    {.form = Form::networks,
     .is_joined = true,
     .words = networks_words,
     .read = read_value::networks,
     .print = print_networks,
     .schema = [](Facts) -> Json {
         return {{"anyOf", {Json{{"const", "any"}}, Json{{"type", "array"}, {"items", {{"type", "string"}}}, {"minItems", 1}}}}};
     },
     .expected =
         [](Facts key) {
             return std::string{key.allows_host_names
                                    ? "any, or networks such as 192.168.0.0/24 and host names such as ground.local"
                                    : "any, or networks such as 192.168.0.0/24"};
         },
     .placeholder = [](Facts) { return std::string{"CIDR[+CIDR...]|any"}; }},
    {.form = Form::network,
     .words = text_words,
     .read = read_value::network,
     .print = print_network,
     .schema = any_string,
     .expected =
         [](Facts key) {
             return std::string{"an IPv4 network such as 192.168.0.0/24"} +
                    (key.allows_host_names ? ", or a host name such as ground.local" : "");
         },
     .placeholder = [](Facts) { return std::string{"CIDR"}; }},
    {.form = Form::ip,
     .words = text_words,
     .read = read_value::ip,
     .print = print_ip,
     .schema = any_string,
     .expected =
         [](Facts key) {
             return std::string{"an IPv4 address such as 192.168.0.5"} +
                    (key.allows_host_names ? ", a host name such as gateway.example.org" : "") +
                    (key.choices.empty() ? "" : " or " + std::string{key.choices});
         },
     .placeholder = [](Facts key) { return or_choices("IP", key.choices); }},
    {.form = Form::names,
     .words = names_words,
     .read = read_value::names,
     .print = print_names,
     .schema = [](Facts) -> Json {
         return {{"type", "array"}, {"items", {{"type", "string"}}}};
     },
     .expected = [](Facts) { return std::string{"a list of names of links such as [\"fc\"]"}; },
     .placeholder = [](Facts) { return std::string{"[LINK...]"}; }},
    {.form = Form::texts,
     .words = names_words,
     .read = read_value::names,
     .print = print_names,
     .schema = [](Facts) -> Json {
         return {{"type", "array"}, {"items", {{"type", "string"}}}};
     },
     .expected = [](Facts) { return std::string{"a list of texts such as [\"vehicle.lan\"]"}; },
     .placeholder = [](Facts) { return std::string{"[TEXT...]"}; }},
    {.form = Form::words,
     .is_joined = true,
     .words = joined_names_words,
     .read = read_value::names,
     .print = print_names,
     .schema = [](Facts) -> Json {
         return {{"type", "array"}, {"items", {{"type", "string"}}}};
     },
     .expected = [](Facts) { return std::string{"a list of names such as [\"fc\"]"}; },
     .placeholder = [](Facts) { return std::string{"NAME[+NAME...]"}; }},
    {.form = Form::line,
     .words = count_or_text_words,
     .read = read_value::text,
     .print = print_line,
     .schema = [](Facts key) -> Json {
         return {{"anyOf", {Json{{"type", "integer"}, {"minimum", 0}}, text_schema(key)}}};
     },
     .expected = [](Facts) { return std::string{"a line's number such as 17 or its name such as \"GPIO17\""}; },
     .placeholder = [](Facts) { return std::string{"NUMBER|NAME"}; }},
    {.form = Form::silence,
     .words = text_words,
     .read = read_value::silence,
     .print = print_silence,
     .schema = [](Facts) { return pattern("^silent [0-9]+(ms|s|m|h)$"); },
     .expected = [](Facts key) { return "\"silent\" and a duration such as \"silent 10s\"," + times_of(key); },
     .placeholder = [](Facts) { return std::string{"silent DURATION"}; }},
    {.form = Form::frames,
     .is_joined = true,
     .words = list_words,
     .read = read_value::frames,
     .print = print_ranges,
     .schema = words_schema,
     .expected =
         [](Facts) {
             return std::string{"ids such as 0xF0 or 0x01-0x0F, names of messages such as firmware, or urgent, telemetry, bulk"};
         },
     .placeholder = [](Facts) { return std::string{"FRAMES[+FRAMES...]"}; }},
    {.form = Form::senders,
     .is_joined = true,
     .words = list_words,
     .read = read_value::senders,
     .print = print_ranges,
     .schema = words_schema,
     .expected = [](Facts) { return std::string{"addresses such as 0xFE or ranges such as 30-40"}; },
     .placeholder = [](Facts) { return std::string{"ADDR[+ADDR...]"}; }},
    {.form = Form::limits,
     .words = no_words,
     .read = read_value::limit,
     .print = print_limits,
     .schema = [](Facts) -> Json {
         return {{"type", "object"}, {"additionalProperties", {{"type", "number"}, {"exclusiveMinimum", 0}}}};
     },
     .expected = [](Facts) { return std::string{"an object such as {\"0x01\": 50}: frames a second"}; },
     .placeholder = [](Facts) { return std::string{"NUMBER"}; }},
};

constexpr bool are_in_order() {
    for (std::size_t i = 0; i < std::size(rows); ++i)
        if (static_cast<std::size_t>(rows[i].form) != i) return false;
    return true;
}
static_assert(are_in_order());

/// Whether a single text was used where JSON requires a list: only in a LINK text several are joined by +.
bool lacks_brackets(const KeyFacts& key, const json& value) {
    return row_of(key.form).is_joined && !value.is_array() &&
           (key.form != Form::networks || (value.is_string() && value != "any"));
}

}    // namespace

const FormRow& row_of(Form form) noexcept { return rows[static_cast<std::size_t>(form)]; }

std::string read_text(const KeyFacts& key, std::string_view text, Value& value) {
    const FormRow& row = row_of(key.form);
    Words words;
    for (const std::string_view word : row.is_joined ? split(text, '+') : std::vector{text}) words.emplace_back(word);
    return row.read(key, words, value);
}

std::string read_json(const KeyFacts& key, const json& given, Value& value) {
    if (lacks_brackets(key, given))
        return in_quotes(key.name) + " must be a list" + (given.is_string() ? " such as [" + printable(given.dump()) + "]" : "") +
               ", not " + format_json(given);
    const FormRow& row = row_of(key.form);
    const auto words = row.words(given);
    return words ? row.read(key, *words, value) : must_be(key, format_json(given));
}

std::optional<Json> printed(const KeyFacts& key, const Value& value) {
    if (std::holds_alternative<std::monostate>(value)) return std::nullopt;
    Json json = row_of(key.form).print(key, value);
    if (json.empty() || json == "") return std::nullopt;
    return json;
}

std::optional<std::string> format_value(const KeyFacts& key, const Value& value) {
    const auto json = printed(key, value);
    if (!json || json->is_object()) return std::nullopt;
    if (!json->is_array()) return json->is_string() ? json->get<std::string>() : json->dump();
    std::string text;
    for (const Json& word : *json) text += (text.empty() ? "" : "+") + word.get<std::string>();
    return text;
}

std::string format_json(const json& value) {
    if (value.is_object()) return "an object";
    if (value.is_array()) return "a list";
    if (value.is_string()) return "the text " + printable(value.dump());
    return printable(value.dump());
}

std::string expected(const KeyFacts& key) { return row_of(key.form).expected(key); }

std::string placeholder(const KeyFacts& key) {
    return key.stands_for.empty() ? row_of(key.form).placeholder(key) : std::string{key.stands_for};
}

}    // namespace anogate
