// One request, read whole.
#pragma once
#include <ano/time.hpp>
#include <http/door.hpp>
#include <http/large_body.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// A header field, a parameter of the path, a word of the query.
struct Field {
    std::string name, value;
    bool operator==(const Field&) const = default;
};

/// Of the first field of this name, whatever the case of that; empty: it is not there.
std::string_view field_value(const std::vector<Field>& fields, std::string_view name) noexcept;

/// Request::body_to_come where that is not told: it comes in chunks.
inline constexpr std::uint64_t in_chunks = 0xFFFF'FFFF'FFFF'FFFF;

/// Of a client whom the system does not name.
inline constexpr std::uint32_t unknown_user = 0xFFFFFFFF;

struct Request {
    std::string method;    // "GET"
    std::string target;    // "/links/fc?n=1", as it came
    std::vector<Field> headers;
    std::string body;
    std::shared_ptr<const StoredBody> stored{};    // in the place of `body`, where that is large
    unsigned version = 11;                         // 10 for HTTP/1.0
    bool keep_alive = true;
    std::uint32_t user = unknown_user;    // who asks by a Unix socket
    Door door;
    Access access = Access::control;    // what it may
    std::optional<Access> judged{};     // the same, where that was asked when only its head was here
    std::uint64_t body_to_come = 0;     // of a head alone, in bytes
    ano::TimePoint came_at{};           // when the whole of it was read

    /// Of the path, in the order of the pattern, decoded: any bytes, '/' among them. Filled by Routes, like `query`.
    std::vector<Field> parameters;
    std::vector<Field> query;

    /// Empty: there is none of this name.
    std::string_view parameter(std::string_view name) const noexcept;
    /// The first of this name; nothing: it is not there. "?dry_run" is there and empty.
    std::optional<std::string_view> query_value(std::string_view name) const noexcept;
    /// Whatever the case of its name; empty: it is not there.
    std::string_view header(std::string_view name) const noexcept;
    /// One of the words of a header that lists words, such as Connection, is `word`.
    bool header_has(std::string_view name, std::string_view word) const noexcept;
};

/// The request wants to become a WebSocket.
bool is_web_socket(const Request& request) noexcept;

/// Of the subprotocols that it offers for that, the first that is among `known`; empty: none is.
std::string_view offered_subprotocol(const Request& request, std::span<const std::string_view> known) noexcept;

}    // namespace anogate::http
