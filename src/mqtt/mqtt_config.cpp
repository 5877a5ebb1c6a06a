#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/json_text.hpp>
#include <config/key_objects.hpp>
#include <mqtt/mqtt_config.hpp>

#include <nlohmann/json.hpp>

#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using Plain = nlohmann::json;

class MqttReader {
public:
    MqttReader(std::string file, MqttSettings& settings, ConfigErrors& errors)
        : file_{std::move(file)}, settings_{settings}, errors_{errors} {}

    void document(const Plain& document) {
        if (!key_objects::is_object(document, file_, errors_)) return;
        Plain own = Plain::object();
        for (const auto& [name, value] : document.items()) {
            const std::string where = at(file_, ano::pointer_step(name));
            if (name == "$schema") continue;
            if (name == "messages") messages(value, where);
            else if (name == "log") section(value, where, log_keys(), settings_.log);
            else if (name == "tls" || find_key(mqtt_keys(), name) != nullptr) own[name] = value;
            else errors_.push_back({where, unknown(name)});
        }
        key_objects::read_keys(own, {file_.empty() ? "" : file_ + ": ", true}, list_of(mqtt_keys()), settings_, errors_);
    }

private:
    static std::string unknown(const std::string& name) {
        std::vector<std::string_view> known{"messages", "log", "tls"};
        for (const auto& key : mqtt_keys()) known.push_back(key.name);
        return "unknown key " + in_quotes(name) + ano::did_you_mean(name, known);
    }

    template <class Section>
    void section(const Plain& value, const std::string& where, Keys<Section> table, Section& into) {
        const KeyList<Section> list = list_of(table);
        if (key_objects::is_object(value, where, errors_, key_objects::of_keys(list)))
            key_objects::read_keys(value, {where, true}, list, into, errors_);
    }

    void messages(const Plain& value, const std::string& where) {
        if (!value.is_array()) return errors_.push_back({where, "must be a list [...], not " + format_json(value)});
        for (std::size_t i = 0; i < value.size(); ++i) {
            MessageRule rule;
            section(value[i], where + "/" + std::to_string(i), message_rule_keys(), rule);
            settings_.messages.push_back(std::move(rule));
        }
    }

    std::string file_;
    MqttSettings& settings_;
    ConfigErrors& errors_;
};

}    // namespace

void read_mqtt_config(std::string_view text, const std::string& file, MqttSettings& settings, ConfigErrors& errors) {
    if (const auto document = parse_json(text, file, errors)) MqttReader{file, settings, errors}.document(*document);
}

void check_mqtt_settings(const MqttSettings& settings, ConfigErrors& errors) {
    if (settings.broker.empty()) errors.push_back({"", "'broker' is missing: the address of the broker, --broker HOST:PORT"});
    if (settings.tls_certificate.empty() != settings.tls_key.empty())
        errors.push_back({"", "'tls.certificate' and 'tls.key' are used only together: set both"});
    if (settings.tls_ca.empty() && !settings.tls_certificate.empty())
        errors.push_back({"", "'tls.ca' is missing: without it, the connection is not encrypted"});
    if (!settings.password_file.empty() && settings.username.empty())
        errors.push_back({"", "'username' is missing: 'password_file' needs it"});
}

std::string print_mqtt_config(const MqttSettings& settings) {
    Json document = Json::object();
    key_objects::print_keys(settings, list_of(mqtt_keys()), document);
    document["messages"] = Json::array();
    for (const MessageRule& rule : settings.messages) {
        Json object = Json::object();
        key_objects::print_keys(rule, list_of(message_rule_keys()), object);
        document["messages"].push_back(std::move(object));
    }
    document["log"] = Json::object();
    key_objects::print_keys(settings.log, list_of(log_keys()), document["log"]);
    return document.dump(2) + "\n";
}

std::string mqtt_config_schema() {
    Json schema = key_objects::closed_object();
    schema["properties"]["$schema"] = {{"type", "string"}};
    key_objects::add_keys(schema, list_of(mqtt_keys()));
    Json rule = key_objects::closed_object();
    key_objects::add_keys(rule, list_of(message_rule_keys()));
    schema["properties"]["messages"] = {
        {"description", "how messages are published; of several rules for a message, the last one applies"},
        {"type", "array"},
        {"items", rule}};
    Json log = key_objects::closed_object();
    schema["properties"]["log"] = key_objects::add_keys(log, list_of(log_keys()));
    Json document{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "anogate-mqtt configuration"}};
    document.update(schema);
    return document.dump(2) + "\n";
}

BrokerAddress broker_address(std::string_view text) {
    constexpr std::uint64_t max_port = 65535;
    const std::size_t colon = text.rfind(':');
    if (colon == text.npos || colon == 0) return {};
    std::string_view host = text.substr(0, colon);
    if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    else if (host.find(':') != host.npos) return {};
    const auto port = ano::parse_number(text.substr(colon + 1));
    const auto* number = port ? std::get_if<std::uint64_t>(&*port) : nullptr;
    if (host.empty() || number == nullptr || *number == 0 || *number > max_port) return {};
    return {std::string{host}, static_cast<std::uint16_t>(*number)};
}

}    // namespace anogate
