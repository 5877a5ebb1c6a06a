#include <ano_json/strict_json.hpp>
#include <control/login_route.hpp>
#include <log/log_line.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using http::Access;

http::Response signed_in(const http::Admission& admission, Access access, std::string_view token,
                         const http::ConnectionInfo& connection_info) {
    http::Response response;
    response.body = access == Access::control ? "{\"access\": \"control\"}\n" : "{\"access\": \"view\"}\n";
    response.headers.push_back(admission.cookie(token, connection_info));
    return response;
}

std::string client(const http::ConnectionInfo& connection_info) {
    return connection_info.peer.empty() ? "a client of the control socket" : connection_info.peer;
}

http::Response login_by_code(http::Admission& admission, SignInCodes& codes, const std::string& code,
                             const http::ConnectionInfo& connection_info, ano::TimePoint now) {
    // A client that is slowed down must neither void the digits nor continue guessing.
    if (const auto slowed = admission.slowed_for(connection_info, now); slowed > ano::Duration{} && SignInCodes::is_digits(code))
        return admission.refuse_wrong(connection_info, http::slow_down(slowed), now);
    const SignInCodes::Use use = codes.use(code, now);
    const std::string token = use.access ? admission.token_for(*use.access) : std::string{};
    if (!token.empty()) {
        log_info("control.http: {} signed in with a one-time code ({})", client(connection_info), text(*use.access));
        return signed_in(admission, *use.access, token, connection_info);
    }
    if (use.voids)
        log_warning(
            "control.http: the sign-in digits are void after {} wrong attempts, the last from {}; new ones: anoctl web "
            "--pair",
            SignInCodes::max_wrong, client(connection_info));
    http::Response wrong = http::error(
        401, "this code is wrong, used, expired or void; create a new one with anoctl web --qr or --pair");
    wrong.headers.push_back({"WWW-Authenticate", "Bearer realm=\"anogate\""});
    return admission.refuse_wrong(connection_info, std::move(wrong), now);
}

/// The value of `key`, which must be one of two words; the first if it is missing. nullptr: another value.
const char* word_of(const Json& body, const char* key, const char* first, const char* second) {
    if (!body.contains(key) || body[key] == first) return first;
    return body[key] == second ? second : nullptr;
}

}    // namespace

http::Response login(http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now) {
    constexpr std::size_t longest = 4096;    // bytes of a token or a code
    if (request.body.size() > longest) return http::error(413, "the body is longer than 4096 bytes");
    const auto parsed = ano::json_body(request.body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return http::error(400, *wrong);
    const auto& body = std::get<Json>(parsed);
    const auto is_text = [&](const char* key) { return body.is_object() && body.contains(key) && body[key].is_string(); };
    if (is_text("token") == is_text("code")) return http::error(400, R"(the body must be {"token": "..."} or {"code": "..."})");
    if (is_text("code")) return login_by_code(admission, codes, body["code"], request.connection_info, now);
    const std::string token = body["token"];
    auto allowed = admission.access_of(token, request.connection_info, now);
    if (!allowed) return std::move(allowed.error());
    return signed_in(admission, *allowed, token, request.connection_info);
}

http::Response make_code(const http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now) {
    const auto parsed = ano::json_body(request.body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return http::error(400, *wrong);
    const auto& body = std::get<Json>(parsed);
    const char* const form = body.is_object() ? word_of(body, "form", "link", "digits") : nullptr;
    const char* const access = body.is_object() ? word_of(body, "access", "control", "view") : nullptr;
    if (!form || !access)
        return http::error(400, R"(the body must be {"form": "link" or "digits", "access": "control" or "view"})");
    const bool is_link = std::string_view{form} == "link";
    const Access wanted = std::string_view{access} == "view" ? Access::view : Access::control;
    if (admission.token_for(wanted).empty())
        return http::error(409, std::string{"no token allows '"} + access +
                                    "': control.http needs no token, or the token file has none; see anoctl web");
    const auto code = codes.make(is_link ? SignInCodes::Form::link : SignInCodes::Form::digits, wanted, now);
    if (!code) return http::error(503, "can't create a code: the system has no random numbers");
    Json made{{"code", *code}, {"access", access}};
    if (is_link) made["link"] = "/#once=" + *code;
    made["expires_s"] = std::chrono::duration_cast<std::chrono::seconds>(SignInCodes::lifetime).count();
    http::Response response;
    response.body = made.dump() + "\n";
    return response;
}

http::Response logout(const http::Admission& admission, const http::Request& request) {
    http::Response response;
    response.body = "{\"signed_out\": true}\n";
    response.headers.push_back(admission.no_cookie(request.connection_info));
    return response;
}

}    // namespace anogate
