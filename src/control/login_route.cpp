#include <ano_json/strict_json.hpp>
#include <control/login_route.hpp>

#include <nlohmann/json.hpp>

namespace anogate {

http::Response login(http::Admission& admission, const http::Request& request, ano::TimePoint now) {
    const auto parsed = ano::json_body(request.body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return http::error(400, *wrong);
    const auto& body = std::get<nlohmann::ordered_json>(parsed);
    if (!body.is_object() || !body.contains("token") || !body["token"].is_string())
        return http::error(400, "the body must be {\"token\": \"...\"}");
    const std::string token = body["token"];
    auto allowed = admission.access_of(token, request.door, now);
    if (!allowed) return std::move(allowed.error());
    http::Response response;
    response.body = *allowed == http::Access::control ? "{\"access\": \"control\"}\n" : "{\"access\": \"view\"}\n";
    response.headers.push_back(admission.cookie(token, request.door));
    return response;
}

http::Response logout(const http::Admission& admission, const http::Request& request) {
    http::Response response;
    response.body = "{\"signed_out\": true}\n";
    response.headers.push_back(admission.no_cookie(request.door));
    return response;
}

}    // namespace anogate
