#include <ano_json/lower_case.hpp>
#include <http/listeners/admission.hpp>
#include <http/listeners/same_token.hpp>
#include <http/target.hpp>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

namespace anogate::http {
namespace {

struct Authority {
    std::string host;         // lower case, without brackets and final dot
    std::string_view port;    // empty: the default of the scheme
};

Authority authority_of(std::string_view text) {
    std::size_t colon = text.rfind(':');
    if (const std::size_t bracket = text.rfind(']'); bracket != text.npos && colon != text.npos && colon < bracket)
        colon = text.npos;
    std::string host = ano::lower_case(text.substr(0, colon));
    if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    else if (!host.empty() && host.back() == '.') host.pop_back();
    return {std::move(host), colon == text.npos ? std::string_view{} : text.substr(colon + 1)};
}

std::string_view usual_port(bool is_encrypted) { return is_encrypted ? "443" : "80"; }

bool is_passed_on(const Request& request) {
    return std::any_of(request.headers.begin(), request.headers.end(), [](const Field& field) {
        const std::string name = ano::lower_case(field.name);
        constexpr std::string_view of_proxies[] = {"forwarded",           "via",
                                                   "x-real-ip",           "x-client-ip",
                                                   "x-cluster-client-ip", "x-original-forwarded-for",
                                                   "cf-connecting-ip",    "true-client-ip",
                                                   "fastly-client-ip",    "fly-client-ip"};
        return name.starts_with("x-forwarded-") ||
               std::find(std::begin(of_proxies), std::end(of_proxies), name) != std::end(of_proxies);
    });
}

/// The values of the cookie `name` in headers "a=1; b=2": a browser may send an old one besides the current one.
std::vector<std::string_view> cookies_of(const Request& request, std::string name) {
    name += '=';
    std::vector<std::string_view> values;
    for (const Field& field : request.headers) {
        if (ano::lower_case(field.name) != "cookie") continue;
        for (std::string_view rest = field.value; !rest.empty();) {
            const std::string_view one = rest.substr(0, rest.find(';'));
            rest.remove_prefix(std::min(rest.size(), one.size() + 1));
            const std::size_t begin = std::min(one.find_first_not_of(' '), one.size());
            if (one.substr(begin).starts_with(name)) values.push_back(one.substr(begin + name.size()));
        }
    }
    return values;
}

std::optional<std::string_view> bearer_of(const Request& request) {
    constexpr std::string_view scheme = "bearer ";
    const std::string_view given = request.header("Authorization");
    if (ano::lower_case(given.substr(0, scheme.size())) != scheme) return std::nullopt;
    const std::string_view token = given.substr(scheme.size());
    return token.substr(std::min(token.find_first_not_of(' '), token.size()));
}

constexpr std::string_view query_name = "token";

std::string query_token_of(const Request& request) {
    const auto query = parse_query(split(request.target).query);
    if (!query) return {};
    const auto given = std::find_if(query->begin(), query->end(), [](const Field& field) { return field.name == query_name; });
    return given == query->end() ? std::string{} : given->value;
}

/// Whether a page of another origin can't send this type without a preflight request (CORS).
bool is_plain_data(std::string_view type) {
    std::string_view kind = type.substr(0, type.find(';'));
    kind = kind.substr(0, kind.find_last_not_of(' ') + 1);
    const std::string name = ano::lower_case(kind);
    return name == "application/json" || name == "application/octet-stream";
}

}    // namespace

bool Admission::is_own_name(std::string_view host, const ConnectionInfo& connection_info) const {
    const std::string own = ano::lower_case(rules_.host_name);
    if (host == "localhost" || host == ano::lower_case(connection_info.local.substr(0, connection_info.local.find('%'))))
        return true;
    if (!own.empty() && (host == own || host == own + ".local")) return true;
    return std::any_of(rules_.hosts.begin(), rules_.hosts.end(),
                       [&](const std::string& name) { return host == ano::lower_case(name); });
}

// Our own origin, or a configured one. A page at another port of this host is another origin.
bool Admission::may_ask(std::string_view origin, std::string_view host, bool is_encrypted) const {
    if (is_listed(origin)) return true;
    const std::size_t slashes = origin.find("://");
    if (slashes == origin.npos) return false;
    const std::string scheme = ano::lower_case(origin.substr(0, slashes));
    const bool is_https = scheme == "https";
    if (!is_https && scheme != "http") return false;
    const Authority from = authority_of(origin.substr(slashes + 3)), to = authority_of(host);
    const auto port = [](const Authority& of, bool encrypted) { return of.port.empty() ? usual_port(encrypted) : of.port; };
    return from.host == to.host && port(from, is_https) == port(to, to.port.empty() ? is_https : is_encrypted);
}

bool Admission::may_have_it_in_query(const Request& request) const {
    return std::find(rules_.paths.begin(), rules_.paths.end(), split(request.target).path) != rules_.paths.end() &&
           is_web_socket(request) && !offered_subprotocol(request, rules_.subprotocols).empty();
}

bool Admission::is_listed(std::string_view origin) const {
    return std::any_of(rules_.origins.begin(), rules_.origins.end(),
                       [&](const std::string& allowed) { return ano::lower_case(origin) == ano::lower_case(allowed); });
}

// Sec-Fetch-Site has priority, since a page can't set it; of several, each must allow the request. Older browsers don't send it, but
// send Origin with requests that change something.
bool Admission::is_foreign(const Request& request) const {
    const std::string_view origin = request.header("Origin");
    bool is_marked = false, is_of_other_site = false;
    for (const Field& field : request.headers) {
        if (field.value.empty() || ano::lower_case(field.name) != "sec-fetch-site") continue;
        const std::string site = ano::lower_case(field.value);
        is_marked = true;
        is_of_other_site = is_of_other_site || (site != "same-origin" && site != "none");
    }
    if (is_marked) return is_of_other_site && !is_listed(origin);
    return !origin.empty() && !may_ask(origin, request.header("Host"), request.connection_info.is_encrypted);
}

std::string Admission::cookie_name(const ConnectionInfo& connection_info) const {
    return "anogate-" + std::to_string(connection_info.port) + (rules_.token_file_id.empty() ? "" : "-" + rules_.token_file_id);
}

// The token in a header or the query; empty: there is none. The cookie is not considered.
std::string Admission::token_of(const Request& request) const {
    if (const auto bearer = bearer_of(request)) return std::string{*bearer};
    return may_have_it_in_query(request) ? query_token_of(request) : std::string{};
}

void Admission::forget_token(Request& request) const {
    if (may_have_it_in_query(request)) request.target = without_query_value(request.target, query_name);
}

std::optional<Response> Admission::refusal(const Request& request) const {
    const std::string_view host = request.header("Host"), origin = request.header("Origin");
    const auto count = [&](std::string_view name) {
        return std::count_if(request.headers.begin(), request.headers.end(),
                             [name](const Field& field) { return ano::lower_case(field.name) == name; });
    };
    if (count("origin") > 1) return error(400, "more than one Origin header");
    if (count("host") != 1 || !is_own_name(authority_of(host).host, request.connection_info))
        return error(403, "unknown host name '" + std::string{host} + "'; add it to control.hosts");
    if (!origin.empty() && !may_ask(origin, host, request.connection_info.is_encrypted))
        return error(403, "pages of '" + std::string{origin} + "' may not use this gateway; add them to control.origins");
    const bool is_told = request.body_length > 0 && request.body_length != in_chunks;
    if ((!request.body.empty() || request.stored || is_told) && !is_plain_data(request.header("Content-Type")))
        return error(415, "Content-Type must be application/json or application/octet-stream");
    return std::nullopt;
}

tl::expected<Access, Response> Admission::judge(Request& request, ano::TimePoint now) {
    const bool passed_on = is_passed_on(request);
    if (request.connection_info.is_network)
        if (auto no = refusal(request)) return tl::unexpected{std::move(*no)};
    if (request.judged) return *request.judged;
    if (!request.connection_info.needs_token && !passed_on) return Access::control;
    if (std::string token = token_of(request); !token.empty()) {
        auto access = access_of(token, request.connection_info, now);
        if (access) request.token = std::move(token);
        return access;
    }
    // The token of a header has priority over the cookie, which a browser adds to every request, also to those that sign in or out.
    const auto kept = cookies_of(request, cookie_name(request.connection_info));
    const std::string_view path = split(request.target).path;
    if (kept.empty() || path == "/login" || path == "/logout") return Access::open;
    std::optional<Access> access;
    for (const std::string_view token : kept) {
        const auto one = access_of_known(token);
        if (one <= access) continue;
        access = one;
        request.token = token;
    }
    if (!access) {
        for (const std::string_view token : kept)
            request.slowed = std::max(request.slowed, count_wrong_cookie(token, request.connection_info, now));
        request.also = no_cookie(request.connection_info);
    }
    return access.value_or(Access::open);
}

bool Admission::shows_control(const Request& head) const {
    if (!head.connection_info.needs_token && !is_passed_on(head)) return true;
    if (const std::string token = token_of(head); !token.empty()) return access_of_known(token) == Access::control;
    const auto kept = cookies_of(head, cookie_name(head.connection_info));
    return std::any_of(kept.begin(), kept.end(),
                       [&](std::string_view token) { return access_of_known(token) == Access::control; });
}

std::optional<Access> Admission::access_of_known(std::string_view token) const {
    std::optional<Access> access;
    for (const Token& known : rules_.tokens)    // compares all of them: the duration must not depend on the token
        if (is_same_token(known.text, token)) access = std::max(access.value_or(Access::open), known.access);
    return access;
}

tl::expected<Access, Response> Admission::access_of(std::string_view token, const ConnectionInfo& connection_info,
                                                    ano::TimePoint now) {
    if (const auto access = access_of_known(token)) return *access;
    return tl::unexpected{refuse_wrong(connection_info, needs_token("wrong token"), now)};
}

Response Admission::refuse_wrong(const ConnectionInfo& connection_info, Response answer, ano::TimePoint now) {
    const auto slowed = count_wrong(connection_info, now);
    return slowed > ano::Duration{} ? slow_down(slowed) : std::move(answer);
}

std::string Admission::token_for(Access access) const {
    const auto found = std::find_if(rules_.tokens.begin(), rules_.tokens.end(),
                                    [access](const Token& token) { return token.access == access; });
    return found == rules_.tokens.end() ? std::string{} : found->text;
}

// A browser sends a cookie that became stale with each request until the response clears it: the same one again is no guess.
ano::Duration Admission::count_wrong_cookie(std::string_view token, const ConnectionInfo& connection_info, ano::TimePoint now) {
    const std::size_t hash = std::hash<std::string_view>{}(token);
    return attempts_.knows(connection_info.peer, hash) ? ano::Duration{} : count_wrong(connection_info, now, hash);
}

// Returns the time for which the client's wrong tokens were already slowed down before this one; zero: they were not.
ano::Duration Admission::count_wrong(const ConnectionInfo& connection_info, ano::TimePoint now, std::size_t token) {
    ++wrong_tokens_;
    const auto slowed = attempts_.slowed_for(connection_info.peer, now);
    if (slowed > ano::Duration{}) return slowed;
    const auto news = attempts_.failed(connection_info.peer, now, token);
    if (news.is_told && on_guessing_) on_guessing_(connection_info.peer, news);
    return slowed;
}

Response slow_down(ano::Duration time) {
    const auto seconds = std::to_string(std::chrono::ceil<std::chrono::seconds>(time).count());
    Response response = error(429, "wrong token, and too many wrong ones from this address; try again in " + seconds + " s");
    response.headers.push_back({"Retry-After", seconds});
    return response;
}

Field Admission::cookie(std::string_view token, const ConnectionInfo& connection_info) const {
    constexpr std::string_view year = "31536000";
    std::string value = cookie_name(connection_info);
    value.append("=").append(token).append("; HttpOnly; SameSite=Strict; Path=/; Max-Age=").append(year);
    return {"Set-Cookie", std::move(value) + (connection_info.is_encrypted ? "; Secure" : "")};
}

Field Admission::no_cookie(const ConnectionInfo& connection_info) const {
    return {"Set-Cookie", cookie_name(connection_info) + "=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0" +
                              (connection_info.is_encrypted ? "; Secure" : "")};
}

}    // namespace anogate::http
