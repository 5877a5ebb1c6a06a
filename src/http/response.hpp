// What a request is answered with: a text, a stream of parts, or a WebSocket.
#pragma once
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

/// Is given a function that it calls once, from the loop, with the response; who has gone meanwhile is not told. It must not say `later`
/// or `patient` again.
using Later = std::function<void(std::function<void(Response)> say)>;

struct Response {
    unsigned status = 200;
    std::string body;
    std::shared_ptr<const std::string> shared{};    // behind `body`: a text that may be the answer to many, not copied for each
    std::string type = "application/json";
    std::vector<Field> headers;                   // more of them
    std::unique_ptr<Producer> producer;           // makes the body, in place of `body`
    std::optional<std::uint64_t> length{};        // of what the producer makes, bytes; one that ends before ends the connection
    std::unique_ptr<WebSocketUser> web_socket;    // the connection becomes a WebSocket; for requests that is_web_socket() only
    Later later;                                  // it comes later, in the place of all this; within SessionLimits::patience
    bool patient = false;                         // `later` may take as long as it takes
    std::shared_ptr<void> needed{};               // of a patient one: destroyed when it is answered, or its client is gone

    std::size_t size() const noexcept { return body.size() + (shared ? shared->size() : 0); }
    /// All of its body; `body` is empty behind it.
    std::string take_text();
};

/// In a word for programs, what an answer of this status says: "invalid", "refused", "unknown", "busy", "timeout" or "unsupported".
std::string_view what_of(unsigned status) noexcept;

/// {"error": words, "what": what_of(status)}
Response error(unsigned status, std::string_view words);

/// 401: a token is needed, or another one.
Response needs_token(std::string_view words);

/// 503: it may be asked again in a second.
Response try_again(std::string_view words);
/// The header that says so.
Field retry_after();

/// Why a WebSocket can't be made of this request, as the answer to it; its status is 200 when it can.
Response web_socket_fault(const Request& request);

/// One that is not known yet.
Response later(Later promise);

/// How a response is sent.
struct Sending {
    unsigned version = 11;
    bool keep_alive = true;
    bool chunked = false;    // else its length is told, or, with a producer, its end is that of the connection
};

/// The status line and the header, with the empty line.
std::string head_of(const Response& response, const Sending& sending);

/// The whole of a response that is the last one of its connection.
std::string last_words(const Response& response);

/// A part of a chunked body; not empty.
std::string chunk(std::string_view part);
inline constexpr std::string_view last_chunk = "0\r\n\r\n";

}    // namespace anogate::http
