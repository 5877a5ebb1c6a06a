// Decides what a request may do, from the request, its door and the tokens. No I/O.
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
    std::string host_name;               // our host name: it and HOST.local are our names
    std::vector<std::string> hosts;      // further names of ours: "vehicle.lan"
    std::vector<std::string> origins;    // other pages that may send requests: "https://ground.example:8443"
    /// A WebSocket at one of these paths that offers one of these subprotocols may have its token in the query (?token=), because its
    /// clients can't send it otherwise.
    std::vector<std::string_view> paths{}, subprotocols{};
};

class Admission {
public:
    void set(AdmissionRules rules) { rules_ = std::move(rules); }

    /// What the request may do, or the answer that refuses it. At a network door it refuses: a Host that is not one of our names,
    /// since any other name may be made to resolve to us (DNS rebinding); an Origin other than our own; a body that a form of any page
    /// could send; a wrong token. A token that was checked with the head of the request (Request::judged) is not checked again. A
    /// request passed on by a proxy needs a token at every door.
    tl::expected<Access, Response> judge(const Request& request, ano::TimePoint now);

    /// Removes a checked token from the target, so that it can't appear in anything written about the request.
    void forget_token(Request& request) const;

    /// What a token that did not come in a header allows; otherwise 401, or 429 after too many failures.
    tl::expected<Access, Response> access_of(std::string_view token, const Door& door, ano::TimePoint now);
    /// The header Set-Cookie, by which a browser sends this token from now on.
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
