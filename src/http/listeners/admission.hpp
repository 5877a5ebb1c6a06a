// Decides the access of a request from the request, its listener and the tokens. No I/O.
#pragma once
#include <ano/time.hpp>
#include <http/listeners/attempts.hpp>
#include <http/request.hpp>
#include <http/response.hpp>
#include <sys/expected.hpp>

#include <cstdint>
#include <functional>
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
    std::string host_name;               // the host name of this machine: it and HOST.local are its names
    std::vector<std::string> hosts;      // further names of this machine: "vehicle.lan"
    std::vector<std::string> origins;    // other pages that may send requests: "https://ground.example:8443"
    /// A WebSocket at one of these paths that offers one of these subprotocols may have its token in the query (?token=), because its
    /// clients can't send it in another way.
    std::vector<std::string_view> paths{}, subprotocols{};
    std::string token_file_id{};    // part of the name of the cookie, so that the cookies of other gateways are ignored
};

/// 429 for a client that sent too many wrong tokens; `time`: until it may try again.
Response slow_down(ano::Duration time);

class Admission {
public:
    void set(AdmissionRules rules) { rules_ = std::move(rules); }

    /// The access of the request, or the response that refuses it. At a network listener it refuses: a Host that is not a name of
    /// this machine, since any other name may be made to resolve to it (DNS rebinding); an Origin other than our own or one of
    /// `origins`; a body that a form of any page could send; a wrong token. A wrong token in a cookie counts as no token, and the
    /// response clears the cookie (Request::also); each different one is counted and slowed down as others are, but only at paths
    /// that need a token (Request::slowed). Requests that sign in or out ignore cookies. A token that was checked with the head of
    /// the request (Request::judged) is not checked again. A request forwarded by a proxy needs a token at every listener.
    tl::expected<Access, Response> judge(Request& request, ano::TimePoint now);

    /// Whether a request with this head may control, unless judge() refuses it. Counts nothing.
    bool shows_control(const Request& head) const;

    /// Whether the headers of a browser show that the request is sent for a page of another site that is not one of `origins`.
    bool is_foreign(const Request& request) const;

    /// Removes a checked token from the target, so that it can't appear in any text about the request.
    void forget_token(Request& request) const;

    /// The access of a valid token, however many wrong ones were sent before; for a wrong one 401, or 429 after too many.
    tl::expected<Access, Response> access_of(std::string_view token, const ConnectionInfo& connection_info, ano::TimePoint now);
    /// Counts a wrong token or code. Returns `answer`, or 429 after too many.
    Response refuse_wrong(const ConnectionInfo& connection_info, Response answer, ano::TimePoint now);
    /// The time for which wrong tokens and codes of this client are still slowed down; zero: they are not.
    ano::Duration slowed_for(const ConnectionInfo& connection_info, ano::TimePoint now) const {
        return attempts_.slowed_for(connection_info.peer, now);
    }
    /// The first token whose access is exactly `access`; empty: there is none.
    std::string token_for(Access access) const;
    /// Whether the token still allows `access` after set().
    bool still_allows(std::string_view token, Access access) const { return access_of_known(token) >= access; }
    /// The header Set-Cookie that makes a browser send this token with its requests.
    Field cookie(std::string_view token, const ConnectionInfo& connection_info) const;
    /// The header that makes a browser delete the cookie.
    Field no_cookie(const ConnectionInfo& connection_info) const;

    std::uint64_t wrong_tokens() const noexcept { return wrong_tokens_; }
    /// Clients whose wrong tokens were slowed down.
    std::uint64_t guessing_clients() const noexcept { return attempts_.slowed(); }
    /// `call` is called with the address of a client when its wrong tokens are slowed down for the first time: a few times a minute.
    using OnGuessing = std::function<void(const std::string& peer, const Attempts::News& news)>;
    void on_guessing(OnGuessing call) { on_guessing_ = std::move(call); }

private:
    std::optional<Response> refusal(const Request& request) const;
    bool may_have_it_in_query(const Request& request) const;
    std::string token_of(const Request& request) const;
    std::string cookie_name(const ConnectionInfo& connection_info) const;
    ano::Duration count_wrong_cookie(std::string_view token, const ConnectionInfo& connection_info, ano::TimePoint now);
    ano::Duration count_wrong(const ConnectionInfo& connection_info, ano::TimePoint now,
                              std::size_t token = 0);    // as Attempts::failed()
    std::optional<Access> access_of_known(std::string_view token) const;
    bool is_listed(std::string_view origin) const;
    bool is_own_name(std::string_view host, const ConnectionInfo& connection_info) const;
    bool may_ask(std::string_view origin, std::string_view host, bool is_encrypted) const;

    AdmissionRules rules_;
    Attempts attempts_;
    std::uint64_t wrong_tokens_ = 0;
    OnGuessing on_guessing_;
};

}    // namespace anogate::http
