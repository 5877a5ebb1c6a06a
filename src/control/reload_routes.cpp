#include <ano_json/answer_json.hpp>
#include <ano_json/fault_json.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/values.hpp>
#include <control/reload_routes.hpp>
#include <http/routes.hpp>
#include <runtime/reload.hpp>

#include <nlohmann/json.hpp>

#include <variant>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr ano::Duration min_to_confirm = std::chrono::seconds{1}, max_to_confirm = std::chrono::hours{1};

http::Response json_response(unsigned status, const Json& json) {
    http::Response response;
    response.status = status;
    response.body = line_of(json);
    return response;
}

http::Response refused(unsigned status, const std::string& error, const char* what, Json faults = {}) {
    Json json;
    ano::add_fault(json, {"other", error});
    json["what"] = what;
    if (!faults.empty()) json["faults"] = std::move(faults);
    return json_response(status, json);
}

http::Response answer_of(const ReloadOutcome& outcome) {
    if (!outcome.refusal.empty()) return refused(409, "nothing was changed: " + outcome.refusal, "refused");
    if (!outcome.faults.empty()) {
        Json faults = Json::array();
        for (const ConfigError& fault : outcome.faults) faults.push_back(line_of(fault));
        const std::string error = "nothing was changed: the configuration has " + std::to_string(faults.size()) +
                                  (faults.size() == 1 ? " error" : " errors");
        return refused(422, error, "invalid", std::move(faults));
    }
    Json links = Json::array();
    for (const LinkDifference& link : outcome.difference.links)
        links.push_back({{"name", link.name}, {"change", text(link.change)}, {"differences", link.differences}});
    Json json{{"dry_run", outcome.dry_run},
              {"changed", !outcome.difference.is_none() || !outcome.files.empty()},
              {"links", std::move(links)},
              {"gateway", outcome.difference.gateway},
              {"needs_restart", outcome.difference.needs_restart},
              {"files", outcome.files}};
    json["confirm_within_s"] = outcome.confirm_within ? Json(in_seconds(*outcome.confirm_within)) : Json(nullptr);
    if (!outcome.listener_fault.empty()) json["http_error"] = outcome.listener_fault;
    return json_response(200, json);
}

// Unknown keys are refused: a client that misspells confirm_within must not get a reload without confirmation.
std::variant<ReloadRequest, std::string> read_request(const http::Request& request) {
    constexpr std::string_view names[] = {"dry_run", "confirm_within"};
    ReloadRequest reload;
    for (const http::Field& field : request.query) {
        if (field.name == "dry_run") {
            const auto value = field.value.empty() ? std::optional{true} : parse_boolean(field.value);
            if (!value) return "'dry_run' must be true or false, not " + ano::in_quotes(field.value);
            reload.dry_run = *value;
        } else if (field.name == "confirm_within") {
            reload.confirm_within = parse_duration(field.value);
            if (!reload.confirm_within || *reload.confirm_within < min_to_confirm || *reload.confirm_within > max_to_confirm)
                return "'confirm_within' must be a duration such as 30s, from 1s to 1h, not " + ano::in_quotes(field.value);
        } else {
            return "unknown word " + ano::in_quotes(field.name) + " in the query" + ano::did_you_mean(field.name, names);
        }
    }
    return reload;
}

}    // namespace

void add_reload_routes(http::Routes& routes, Reload& reload) {
    const auto ask = [&reload](const http::Request& request) {
        const auto read = read_request(request);
        if (const auto* fault = std::get_if<std::string>(&read)) return refused(400, *fault, "invalid");
        return http::later([&reload, asked = std::get<ReloadRequest>(read)](const std::function<void(http::Response)>& respond) {
            reload.reload(asked, [respond](const ReloadOutcome& outcome) { respond(answer_of(outcome)); });
        });
    };
    const auto confirm = [&reload](const http::Request&) {
        return http::later([&reload](const std::function<void(http::Response)>& respond) {
            reload.confirm([respond](const std::string& refusal) {
                respond(refusal.empty() ? json_response(200, {{"confirmed", true}}) : refused(409, refusal, "refused"));
            });
        });
    };
    routes.add_without_body(
        {"POST", "/reload", http::Access::control,
         "reloads the configuration (dry_run: only report what would change; confirm_within=30s: unless confirmed, the "
         "previous one is restored) and the tokens and certificate of control.http, and returns the result for each link and the "
         "files whose content has changed",
         ask});
    routes.add_without_body({"POST", "/reload/confirm", http::Access::control, "confirms the last reload", confirm});
}

}    // namespace anogate
