// A complete HTTP request.
#pragma once
#include <ano/time.hpp>
#include <http/large_body.hpp>
#include <http/listeners/connection_info.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// A header field, a parameter of the path, or a parameter of the query.
struct Field {
    std::string name, value;
    bool operator==(const Field&) const = default;
};

/// The value of the first field `name` (upper or lower case); empty: there is none.
std::string_view field_value(const std::vector<Field>& fields, std::string_view name) noexcept;

/// The value of Request::body_length for a chunked body, whose size is not known.
inline constexpr std::uint64_t in_chunks = 0xFFFF'FFFF'FFFF'FFFF;

/// The user of a client whose user is unknown: any client of the network.
inline constexpr std::uint32_t unknown_user = 0xFFFFFFFF;

struct Request {
    std::string method;    // "GET"
    std::string target;    // "/links/fc?n=1", as received
    std::vector<Field> headers;
    std::string body;
    std::shared_ptr<const StoredBody> stored{};    // instead of `body`, if that is large
    unsigned version = 11;                         // 10 for HTTP/1.0
    bool keep_alive = true;
    std::uint32_t user = unknown_user;    // the client's user at a Unix socket
    ConnectionInfo connection_info;
    Access access = Access::control;    // the access that it has
    std::string token{};                // the valid token that allows it; empty: none was needed, or none was sent
    std::optional<Access> judged{};     // `access`, if it was judged before the body was received
    bool is_foreign = false;            // a browser sends it for a page of another site
    std::optional<Field> also{};        // an additional header of its response
    ano::Duration slowed{};             // instead of 401 it gets 429 with this time: too many wrong cookies from its address
    std::uint64_t body_length = 0;      // bytes of the body, while only the head was received
    ano::TimePoint came_at{};           // when it was read completely

    /// Those of the path, in the order of the pattern; decoded, so they may hold any byte, even '/'. Set by Routes, like `query`.
    std::vector<Field> parameters;
    std::vector<Field> query;

    /// Empty: there is no parameter of that name.
    std::string_view parameter(std::string_view name) const noexcept;
    /// The first value of that name; std::nullopt: there is none. "?dry_run" is present with an empty value.
    std::optional<std::string_view> query_value(std::string_view name) const noexcept;
    /// `name`: upper or lower case; empty: there is no such header.
    std::string_view header(std::string_view name) const noexcept;
    /// Whether a header that is a list of words, such as Connection, has `word`.
    bool header_has(std::string_view name, std::string_view word) const noexcept;
};

/// Whether the request asks for a WebSocket.
bool is_web_socket(const Request& request) noexcept;

/// The first subprotocol offered by the request that is in `known`; empty: there is none.
std::string_view offered_subprotocol(const Request& request, std::span<const std::string_view> known) noexcept;

}    // namespace anogate::http
