#include "complete.hpp"

#include <anoctl/text/gateway_json.hpp>
#include "complete_fields.hpp"
#include "gateway.hpp"

#include <http/client/client.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <exception>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>

namespace anoctl {
namespace {

using ano::Json;
using Words = std::span<const char* const>;

constexpr ano::Duration patience = std::chrono::milliseconds{300};    // the user has pressed Tab and waits
constexpr ano::Duration patience_with_device = std::chrono::milliseconds{1500};

/// The value of an option on the command line being typed; bash passes --control=PATH as three words.
std::string value_of(Words words, std::string_view option) {
    const auto at = [&](std::size_t i) { return i < words.size() ? std::string_view{words[i]} : std::string_view{}; };
    const std::string with_value = std::string{option} + "=";
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (at(i) == option) return std::string{at(i + 1) == "=" ? at(i + 2) : at(i + 1)};
        if (at(i).starts_with(with_value)) return std::string{at(i).substr(with_value.size())};
    }
    return {};
}

Json asked(const GatewayOptions& gateway, const std::string& target, ano::Duration time = patience) {
    anogate::http::Request request;
    request.method = "GET";
    request.target = target;
    anogate::http::ClientLimits limits;
    limits.patience = time;
    const anogate::http::Outcome outcome = anogate::http::ask(gateway.socket(), std::move(request), limits);
    if (!outcome.fault.empty() || outcome.answer.status / 100 != 2) return Json::array();
    return parse_answer(outcome.answer.body);
}

/// One "word<tab>description" per line; shells show the description.
void offer_devices(const Json& routes, std::ostream& out) {
    for (const Json& route : routes)
        out << text_at(route, "address") << '\t' << text_at(route, "who") << ", " << names_at(route, "links") << '\n';
}

void offer_links(const Json& links, std::ostream& out) {
    for (const Json& link : links)
        out << text_at(link, "name") << '\t' << text_at(link, "kind") << ", " << text_at(link, "state") << '\n';
}

/// Offers the name of each device, or its address if it has no name.
void offer_names(const Json& devices, std::ostream& out) {
    for (const Json& device : devices) {
        const std::string name = text_at(device, "name"), address = text_at(device, "address");
        out << (name.empty() ? address : name) << '\t' << address << '\n';
    }
}

/// The device of --device, else the only one. Empty: there are several, or none.
std::string device_of(const GatewayOptions& gateway, Words words) {
    if (std::string value = value_of(words, "--device"); !value.empty()) return value;
    const Json answer = asked(gateway, "/devices");
    const Json& devices = at(answer, "devices");
    return devices.size() == 1 ? text_at(devices.front(), "address") : std::string{};
}

/// The gateway reads the descriptions from the device if it does not have them yet. Names with spaces are omitted, because a
/// shell would split them.
void offer_of_device(const GatewayOptions& gateway, Words words, const std::string& what, std::ostream& out) {
    const std::string device = device_of(gateway, words);
    if (device.empty()) return;
    const std::string target = "/devices/" + percent_encoded(device) + "/" + what + "?values=0&while_connected";
    const Json answer = asked(gateway, target, patience_with_device);
    for (const Json& one : at(answer, what))
        if (const std::string name = text_at(one, "name"); !name.empty() && name.find(' ') == name.npos)
            out << name << '\t' << text_at(one, "text") << '\n';
}

}    // namespace

int complete(Words words, Streams& streams) noexcept {
    try {
        const std::string_view what = words.empty() ? std::string_view{} : words[0];
        GatewayOptions gateway;
        if (!words.empty()) gateway.control = value_of(words.subspan(1), "--control");
        if (what == "devices") offer_devices(asked(gateway, "/routes"), streams.out);
        else if (what == "links") offer_links(asked(gateway, "/links"), streams.out);
        else if (what == "names") offer_names(at(asked(gateway, "/devices"), "devices"), streams.out);
        else if (what == "parameters" || what == "commands")
            offer_of_device(gateway, words.subspan(1), std::string{what}, streams.out);
        else if (what == "fields")
            for (const std::string& word : field_words(words.subspan(1))) streams.out << word << '\n';
        streams.out.flush();
    } catch (const std::exception&) {    // prints nothing: an error message would disturb the line being typed
    }
    return fine;
}

}    // namespace anoctl
