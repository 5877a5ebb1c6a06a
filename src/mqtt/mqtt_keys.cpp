// The keys of mqtt.json.
#include <ano_json/frame_json.hpp>
#include <config/key_rows.hpp>
#include <config/values.hpp>
#include <mqtt/allowed_requests.hpp>
#include <mqtt/mqtt_config.hpp>
#include <mqtt/topics.hpp>

namespace anogate {
namespace {

using namespace key_rows;
using S = MqttSettings;
using R = MessageRule;

constexpr std::uint64_t max_socket = 107, max_text = 256, max_rate = 1'000'000, max_change = 1'000'000'000, max_will_delay = 5000;

template <std::string S::*field, std::string (*fault)(const std::string&)>
constexpr Key<S> checked_text(std::string_view name, std::uint64_t max, std::string_view help) {
    return {{.name = name, .form = Form::text, .help = help, .min = 1, .max = max},
            [](const KeyFacts&, const S& settings) { return (settings.*field).empty() ? Value{} : Value{settings.*field}; },
            [](const KeyFacts& key, Value value, S& settings) {
                auto& given = std::get<std::string>(value);
                if (std::string wrong = fault(given); !wrong.empty()) return must_be(key, in_quotes(given)) + ": " + wrong;
                settings.*field = std::move(given);
                return std::string{};
            }};
}

std::string fault_in_broker(const std::string& text) {
    return broker_address(text).port == 0 ? "write HOST:PORT, such as broker.example:8883" : "";
}
std::string fault_in_name(const std::string& text) {
    return is_level(text) ? "" : "a name in topics has no '+', '#', '/' and control characters, and does not begin with '$'";
}

std::string set_allow(const KeyFacts& key, Value value, S& settings) {
    auto& rules = std::get<std::vector<std::string>>(value);
    for (const std::string& rule : rules)
        if (const std::string wrong = fault_in_rule(rule); !wrong.empty()) return in_quotes(key.name) + ": " + wrong;
    settings.allow = std::move(rules);
    return {};
}

constexpr Key<S> setting_rows[] = {
    text<&S::control>("control", 0, max_socket, "the control socket of the gateway (default: the one that anoctl finds)") |
        as("PATH") | by("--control"),
    checked_text<&S::broker, fault_in_broker>("broker", max_text, "the address of the broker") | as("HOST:PORT") | by("--broker"),
    checked_text<&S::name, fault_in_name>("name", max_level, "the gateway in topics (default: the name of this computer)") |
        as("GATEWAY") | by("--name"),
    text<&S::username>("username", 1, max_text, "the user name for the broker") | as("USER") | by("--username"),
    text<&S::password_file>("password_file", 1, max_path, "a file with the password in its first line") | as("FILE") |
        by("--password-file"),
    text<&S::tls_ca>("tls.ca", 1, max_path,
                     "certificates of the authorities that the broker's certificate is checked with; needed "
                     "for TLS") |
        as("FILE") | by("--tls-ca"),
    text<&S::tls_certificate>("tls.certificate", 1, max_path, "the certificate of this client") | as("FILE") |
        by("--tls-certificate"),
    text<&S::tls_key>("tls.key", 1, max_path, "its key") | as("FILE") | by("--tls-key"),
    text<&S::spool>("spool", 1, max_path,
                    "the folder for records that the broker did not acknowledge (default: the state folder)") |
        as("FOLDER") | by("--spool"),
    size<&S::spool_size>("spool_size",
                         "the size of the spool; when it is full, the oldest records of the lowest class are dropped"),
    duration<&S::spool_age>("spool_age", 60 * second, 365 * day, "records in the spool are dropped when they are older"),
    size<&S::backlog_rate>("backlog_rate", "publishes at most this many bytes per second from the spool"),
    duration<&S::will_delay>("will_delay", 0, max_will_delay,
                             "the broker reports this gateway as offline when it is away for longer"),
    boolean<&S::raw>("raw", "publish all received frames unchanged on raw/up"),
    Key<S>{
        {.name = "allow",
         .form = Form::words,
         .help = "requests that clients of the broker may send besides reading the status, the devices, alarms and jobs, such as "
                 "\"POST /devices/*/commands\"; \"POST /send\" also allows frames on raw/down",
         .min = 1,
         .max = max_text,
         .stands_for = "RULE"},
        [](const KeyFacts&, const S& settings) { return Value{settings.allow}; },
        set_allow},
};

std::string set_message(const KeyFacts&, Value value, R& rule) {
    auto& given = std::get<std::string>(value);
    if (given != "*") {
        const auto id = ano::message_id(given);
        if (const auto* fault = std::get_if<ano::JsonFault>(&id)) return fault->what;
    }
    rule.message = std::move(given);
    return {};
}

constexpr Key<R> rule_rows[] = {
    Key<R>{{.name = "message",
            .form = Form::text,
            .help = "its name or id; \"*\" for all messages",
            .min = 1,
            .max = max_name,
            .stands_for = "MESSAGE",
            .required = true},
           [](const KeyFacts&, const R& rule) { return rule.message.empty() ? Value{} : Value{rule.message}; },
           set_message},
    boolean<&R::publish>("publish", "false: it is not published"),
    decimal<&R::rate>("rate", 0, max_rate, "the most messages per second of each device; 0: every frame"),
    decimal<&R::change>("change", 0, max_change,
                        "published only after a number has changed by this much, or another field at all, and once a minute; 0: "
                        "always"),
    choice<&R::keep>("keep", "low|normal|high", "a full spool drops messages of the lowest class first"),
};

}    // namespace

Keys<MqttSettings> mqtt_keys() noexcept { return setting_rows; }
Keys<MessageRule> message_rule_keys() noexcept { return rule_rows; }

}    // namespace anogate
