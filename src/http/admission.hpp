// What a request may. It decides by the request, the door it came by, and the tokens; it does no I/O.
#pragma once
#include <ano/time.hpp>
#include <http/attempts.hpp>
#include <http/request.hpp>
#include <http/response.hpp>
#include <link/expected.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Token {
    Access access = Access::view;
    std::string text;
    bool operator==(const Token&) const = default;
};

struct AdmissionRules {
    std::vector<Token> tokens;
    std::string host_name;               // ours: it and HOST.local are names of ours
    std::vector<std::string> hosts;      // more of them: "vehicle.lan"
    std::vector<std::string> origins;    // pages of others that may ask: "https://ground.example:8443"
    /// A WebSocket at one of these paths that offers one of these may have its token in the query, ?token=: its clients have no other
    /// place for it.
    std::vector<std::string_view> paths{}, subprotocols{};
};

class Admission {
public:
    void set(AdmissionRules rules) { rules_ = std::move(rules); }

    /// What it may, or the answer that refuses it. At a network door: a Host that is not a name of ours, for a name of others may
    /// be made to lead to us (DNS rebinding); an Origin that is not where the request goes; a body that a form of any page could
    /// send; a wrong token. A token that was judged at the head of the request (Request::judged) is not looked at again. A request
    /// that a proxy passed on needs a token wherever it came in.
    tl::expected<Access, Response> judge(const Request& request, ano::TimePoint now);

    /// Takes a token that was judged out of the target: what is said of the request from here on can't have it.
    void forget_token(Request& request) const;

    /// What a token allows that was given by other means than a header: 401, or 429 for who fails often.
    tl::expected<Access, Response> access_of(std::string_view token, const Door& door, ano::TimePoint now);
    /// The header of an answer that makes a browser give this token from now on: Set-Cookie.
    static Field cookie(std::string_view token, const Door& door);

private:
    std::optional<Response> refusal(const Request& request) const;
    bool may_have_it_in_query(const Request& request) const;
    std::string token_of(const Request& request) const;
    bool is_own_name(std::string_view host, const Door& door) const;
    bool may_ask(std::string_view origin, std::string_view host, bool is_encrypted) const;

    AdmissionRules rules_;
    Attempts attempts_;
};

}    // namespace anogate::http
