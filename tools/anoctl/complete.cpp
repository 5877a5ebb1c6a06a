#include "complete.hpp"

#include "complete_fields.hpp"
#include "gateway.hpp"
#include "gateway_json.hpp"

#include <http/client.hpp>

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

constexpr ano::Duration patience = std::chrono::milliseconds{300};    // somebody has pressed a key and waits

/// As on the command line that is being written; bash takes --control=PATH for three words.
std::string control_of(Words words) {
    const auto at = [&](std::size_t i) { return i < words.size() ? std::string_view{words[i]} : std::string_view{}; };
    constexpr std::string_view option = "--control", with_value = "--control=";
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (at(i) == option) return std::string{at(i + 1) == "=" ? at(i + 2) : at(i + 1)};
        if (at(i).starts_with(with_value)) return std::string{at(i).substr(with_value.size())};
    }
    return {};
}

Json asked(const GatewayOptions& gateway, const char* target) {
    anogate::http::Request request;
    request.method = "GET";
    request.target = target;
    anogate::http::ClientLimits limits;
    limits.patience = patience;
    const anogate::http::Outcome outcome = anogate::http::ask(gateway.socket(), std::move(request), limits);
    if (!outcome.fault.empty() || outcome.answer.status / 100 != 2) return Json::array();
    return parse_answer(outcome.answer.body);
}

/// What a shell shows beside a word stands behind a tab.
void write_devices(const Json& routes, std::ostream& out) {
    for (const Json& route : routes)
        out << text_at(route, "address") << '\t' << text_at(route, "who") << ", " << names_at(route, "links") << '\n';
}

void write_links(const Json& links, std::ostream& out) {
    for (const Json& link : links)
        out << text_at(link, "name") << '\t' << text_at(link, "kind") << ", " << text_at(link, "state") << '\n';
}

}    // namespace

int complete(Words words, Streams& streams) noexcept {
    try {
        const std::string_view what = words.empty() ? std::string_view{} : words[0];
        GatewayOptions gateway;
        if (!words.empty()) gateway.control = control_of(words.subspan(1));
        if (what == "devices") write_devices(asked(gateway, "/routes"), streams.out);
        else if (what == "links") write_links(asked(gateway, "/links"), streams.out);
        else if (what == "fields")
            for (const std::string& word : field_words(words.subspan(1))) streams.out << word << '\n';
        streams.out.flush();
    } catch (const std::exception&) {    // nothing is offered then: a line is being written, and words in it would disturb
    }
    return fine;
}

}    // namespace anoctl
