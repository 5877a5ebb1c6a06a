// The answer to a request: a text, a stream of parts, or a WebSocket.
#pragma once
#include <ano/fault.hpp>
#include <http/producer.hpp>
#include <http/request.hpp>
#include <http/web_socket.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Response;

/// Gets a function `respond`, to be called once from the loop with the response. The call has no effect if the client is gone by
/// then. That response must not have `later` or `patient` again.
using Later = std::function<void(std::function<void(Response)> respond)>;

struct Response {
    unsigned status = 200;
    std::string body;
    std::shared_ptr<const std::string> shared{};    // sent after `body`: a text shared by several answers, not copied
    std::string type = "application/json";
    std::vector<Field> headers;                   // in addition to the standard ones
    std::unique_ptr<Producer> producer;           // makes the body, instead of `body`
    std::optional<std::uint64_t> length{};        // bytes that `producer` makes; if it makes fewer, the connection is closed
    std::unique_ptr<WebSocketUser> web_socket;    // the connection becomes a WebSocket; for requests that is_web_socket() only
    Later later;                       // instead of everything else: the response is made later, within SessionLimits::patience
    bool patient = false;              // `later` has no time limit
    std::shared_ptr<void> needed{};    // with `patient`: destroyed when the response is known or the client is gone

    std::size_t size() const noexcept { return body.size() + (shared ? shared->size() : 0); }
    /// The complete body; `body` is empty afterwards.
    std::string pop_text();
};

/// The meaning of a status as a word for programs: "invalid", "refused", "unknown", "busy", "timeout" or "unsupported".
std::string_view what_of(unsigned status) noexcept;

/// {"error": its text, "error_id": its id, "error_args": its arguments, "what": what_of(status)}
Response error(unsigned status, const ano::Fault& fault);
/// With the status of its row.
Response error(const ano::Fault& fault);
/// With a text that has no id of its own.
Response error(unsigned status, std::string_view words);

/// 401: a token is missing, or the one sent is not sufficient.
Response needs_token(std::string_view words);

/// 503: the client may repeat the request after a second.
Response try_again(std::string_view words);
Response try_again(const ano::Fault& fault);
/// The header Retry-After for that.
Field retry_after();

/// The error for a request that can't become a WebSocket; status 200 if it can.
Response web_socket_fault(const Request& request);

/// A Response with `later`.
Response later(Later promise);

/// How a response is sent.
struct Sending {
    unsigned version = 11;
    bool keep_alive = true;
    bool chunked = false;    // false: sent with its length, or with a producer until the connection ends
};

/// The status line and the header, with the empty line.
std::string head_of(const Response& response, const Sending& sending);

/// The complete text, head and body, of the last response of a connection.
std::string final_text(const Response& response);

/// `part`, which must not be empty, as a chunk of a chunked body.
std::string chunk(std::string_view part);
inline constexpr std::string_view last_chunk = "0\r\n\r\n";

}    // namespace anogate::http
