#include <config/json_text.hpp>
#include <daemon/login_route.hpp>

#include <nlohmann/json.hpp>

namespace anogate {

http::Response login(http::Admission& admission, const http::Request& request, ano::TimePoint now) {
    ConfigErrors faults;
    const auto body = parse_json(request.body, {}, faults);
    if (!faults.empty()) return http::error(400, faults.front().what);
    if (!body || !body->is_object() || !body->contains("token") || !(*body)["token"].is_string())
        return http::error(400, "the body must be {\"token\": \"...\"}");
    const std::string token = (*body)["token"];
    auto allowed = admission.access_of(token, request.door, now);
    if (!allowed) return std::move(allowed.error());
    http::Response response;
    response.body = *allowed == http::Access::control ? "{\"access\": \"control\"}\n" : "{\"access\": \"view\"}\n";
    response.headers.push_back(http::Admission::cookie(token, request.door));
    return response;
}

}    // namespace anogate
