#include <ano_json/nearest.hpp>
#include <config/json_text.hpp>
#include <config/key_objects.hpp>
#include <ros2/ros2_config.hpp>
#include <ros2/topic_table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using nlohmann::json;

constexpr std::string_view qos_words[] = {"reliable", "best_effort"};    // in the order of Reliability
constexpr std::string_view sections[] = {"qos", "variances", "devices", "log"};

class Ros2Reader {
public:
    Ros2Reader(std::string file, Ros2Settings& settings, ConfigErrors& errors)
        : file_{std::move(file)}, settings_{settings}, errors_{errors} {}

    void document(const json& document) {
        if (!key_objects::is_object(document, file_, errors_)) return;
        json own = json::object();
        for (const auto& [name, value] : document.items()) {
            const std::string where = at(file_, ano::pointer_step(name));
            if (name == "$schema") continue;
            if (name == "qos") qos(value, where);
            else if (name == "variances") variances(value, where);
            else if (name == "devices") devices(value, where);
            else if (name == "log") section(value, where, log_keys(), settings_.log);
            else if (find_key(ros2_keys(), name) != nullptr) own[name] = value;
            else errors_.push_back({where, unknown(name)});
        }
        key_objects::read_keys(own, {file_.empty() ? "" : file_ + ": ", true}, list_of(ros2_keys()), settings_, errors_);
    }

private:
    static std::string unknown(const std::string& name) {
        std::vector<std::string_view> known{std::begin(sections), std::end(sections)};
        for (const auto& key : ros2_keys()) known.push_back(key.name);
        return "unknown key " + in_quotes(name) + ano::did_you_mean(name, known);
    }

    template <class Section>
    void section(const json& value, const std::string& where, Keys<Section> table, Section& into) {
        const KeyList<Section> list = list_of(table);
        if (key_objects::is_object(value, where, errors_, key_objects::of_keys(list)))
            key_objects::read_keys(value, {where, true}, list, into, errors_);
    }

    void qos(const json& value, const std::string& where) {
        if (!key_objects::is_object(value, where, errors_)) return;
        for (const auto& [topic, word] : value.items()) {
            const std::string place = where + ano::pointer_step(topic);
            const auto names = topic_names();
            if (std::find(names.begin(), names.end(), topic) == names.end())
                errors_.push_back({place, "unknown topic " + in_quotes(topic) + ano::did_you_mean(topic, names)});
            else if (word == qos_words[0] || word == qos_words[1])
                settings_.qos[topic] = word == qos_words[0] ? Reliability::reliable : Reliability::best_effort;
            else errors_.push_back({place, "must be \"reliable\" or \"best_effort\", not " + format_json(word)});
        }
    }

    void variances(const json& value, const std::string& where) {
        if (!key_objects::is_object(value, where, errors_)) return;
        for (const auto& [name, number] : value.items()) variance(name, number, where + ano::pointer_step(name));
        if ((settings_.variances.fix > 0) != (settings_.variances.fix_altitude > 0))
            errors_.push_back({where, "'fix' and 'fix_altitude' are used only together: set both"});
    }

    void variance(const std::string& name, const json& number, const std::string& where) {
        std::vector<std::string_view> known;
        for (const VarianceKey& key : variance_keys()) {
            known.push_back(key.name);
            if (key.name != name) continue;
            constexpr double most = 1e12;
            if (number.is_number() && number.get<double>() > 0 && number.get<double>() <= most)
                settings_.variances.*key.field = number.get<double>();
            else
                errors_.push_back(
                    {where, "must be a number above 0, in " + std::string{key.help} + ", not " + format_json(number)});
            return;
        }
        errors_.push_back({where, "unknown key " + in_quotes(name) + ano::did_you_mean(name, known)});
    }

    void devices(const json& value, const std::string& where) {
        if (!value.is_array()) return errors_.push_back({where, "must be a list [...], not " + format_json(value)});
        for (std::size_t i = 0; i < value.size(); ++i) {
            const std::string place = where + "/" + std::to_string(i);
            Ros2Device device;
            json object = value[i];
            if (object.is_object() && object.contains("velocity_modes")) {
                modes(object["velocity_modes"], place + "/velocity_modes", device);
                object.erase("velocity_modes");
            }
            section(object, place, ros2_device_keys(), device);
            check(device, place);
            settings_.devices.push_back(std::move(device));
        }
    }

    void modes(const json& value, const std::string& where, Ros2Device& device) {
        const auto is_mode = [](const json& one) { return one.is_number_unsigned() && one.get<std::uint64_t>() <= 0xFF; };
        if (!value.is_array() || value.empty() || !std::all_of(value.begin(), value.end(), is_mode))
            return errors_.push_back({where, "must be a list of numbers up to 255, such as [2], not " + format_json(value)});
        device.velocity_modes = value.get<std::vector<std::uint8_t>>();
    }

    void check(const Ros2Device& device, const std::string& where) {
        if (device.accepts(Input::cmd_vel) && device.hover_throttle == 0)
            errors_.push_back({where, "'hover_throttle' is missing: cmd_vel needs the throttle at which the device hovers"});
        if (device.accepts(Input::cmd_vel) && device.accepts(Input::joy))
            errors_.push_back({where + "/accept", "has cmd_vel and joy: only one of them may control a device"});
        for (const Ros2Device& other : settings_.devices) {
            if (!device.prefix.empty() && device.prefix == other.prefix)
                errors_.push_back({where + "/prefix", in_quotes(device.prefix) + " is also the prefix of another device"});
            if (device.address == other.address && (device.link == other.link || device.link.empty() || other.link.empty()))
                errors_.push_back({where, "another entry is for the same device: give both a 'link', or remove one"});
        }
    }

    std::string file_;
    Ros2Settings& settings_;
    ConfigErrors& errors_;
};

}    // namespace

void read_ros2_config(std::string_view text, const std::string& file, Ros2Settings& settings, ConfigErrors& errors) {
    if (const auto document = parse_json(text, file, errors)) Ros2Reader{file, settings, errors}.document(*document);
}

std::string print_ros2_config(const Ros2Settings& settings) {
    Json document = Json::object();
    key_objects::print_keys(settings, list_of(ros2_keys()), document);
    for (const auto& [topic, reliability] : settings.qos)
        document["qos"][topic] = qos_words[static_cast<std::size_t>(reliability)];
    for (const VarianceKey& key : variance_keys())
        if (settings.variances.*key.field > 0) document["variances"][std::string{key.name}] = settings.variances.*key.field;
    document["devices"] = Json::array();
    for (const Ros2Device& device : settings.devices) {
        Json object = Json::object();
        key_objects::print_keys(device, list_of(ros2_device_keys()), object);
        object["velocity_modes"] = device.velocity_modes;
        document["devices"].push_back(std::move(object));
    }
    document["log"] = Json::object();
    key_objects::print_keys(settings.log, list_of(log_keys()), document["log"]);
    return document.dump(2) + "\n";
}

std::string ros2_config_schema() {
    Json schema = key_objects::closed_object();
    schema["properties"]["$schema"] = {{"type", "string"}};
    key_objects::add_keys(schema, list_of(ros2_keys()));
    Json& properties = schema["properties"];
    properties["qos"] = key_objects::closed_object();
    properties["qos"]["description"] = "the reliability of topics, by name without prefix; others are reliable";
    for (const std::string_view topic : topic_names())
        properties["qos"]["properties"][std::string{topic}] = {{"enum", qos_words}};
    properties["variances"] = key_objects::closed_object();
    properties["variances"]["description"] = "variances for the covariances of messages; 0, unknown, if not set";
    for (const VarianceKey& key : variance_keys())
        properties["variances"]["properties"][std::string{key.name}] = {
            {"description", key.help}, {"type", "number"}, {"exclusiveMinimum", 0}};
    Json device = key_objects::closed_object();
    key_objects::add_keys(device, list_of(ros2_device_keys()));
    device["properties"]["velocity_modes"] = {{"description", velocity_modes_help},
                                              {"type", "array"},
                                              {"minItems", 1},
                                              {"items", {{"type", "integer"}, {"minimum", 0}, {"maximum", 255}}}};
    properties["devices"] = {{"type", "array"}, {"items", device}};
    Json log = key_objects::closed_object();
    properties["log"] = key_objects::add_keys(log, list_of(log_keys()));
    Json document{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "anogate-ros2 configuration"}};
    document.update(schema);
    return document.dump(2) + "\n";
}

}    // namespace anogate
