#include "gateway.hpp"

#include <anoctl/text/table.hpp>
#include "anoctl.hpp"

#include <http/client/client.hpp>
#include <http/socket_path.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anoctl {

namespace http = anogate::http;

void GatewayOptions::add(Options& declared, GatewayOptions& options) {
    declared.push_back({"--control", &options.control, "PATH", "The control socket of the gateway, if not the default"});
}

std::string GatewayOptions::socket() const {
    if (control == "none") throw UsageError{"--control none: a gateway without a control socket cannot be reached; give a path"};
    return http::socket_to_ask(control, http::this_runner());
}

namespace {

http::Answer answer_to(http::Request request, const std::string& socket) {
    http::Outcome outcome = http::ask(socket, std::move(request));
    if (!outcome.fault.empty()) throw Failure{outcome.fault};
    return std::move(outcome.answer);
}

std::string body_of(http::Answer answer) {
    if (answer.status / 100 != 2) throw Failure{format_failure(answer)};
    return std::move(answer.body);
}

}    // namespace

http::Answer GatewayOptions::answer(const std::string& method, const std::string& target, const std::string& accept) const {
    http::Request request;
    request.method = method;
    request.target = target;
    if (!accept.empty()) request.headers.push_back({"Accept", accept});
    return answer_to(std::move(request), socket());
}

std::string GatewayOptions::ask(const std::string& method, const std::string& target, const std::string& accept) const {
    return body_of(answer(method, target, accept));
}

std::string GatewayOptions::post(const std::string& target, const std::string& body) const {
    http::Request request;
    request.method = "POST";
    request.target = target;
    request.headers.push_back({"Content-Type", "application/json"});
    request.body = body;
    return body_of(answer_to(std::move(request), socket()));
}

std::string format_failure(const http::Answer& answer) {
    const auto json = nlohmann::json::parse(answer.body, nullptr, false);
    if (json.is_object() && json.contains("error") && json["error"].is_string())
        return without_controls(json["error"].get<std::string>());
    return "the gateway returned HTTP status " + std::to_string(answer.status);
}

}    // namespace anoctl
