// A connection that has become a WebSocket.
#pragma once
#include <http/answer.hpp>
#include <http/request.hpp>
#include <http/stream.hpp>
#include <http/web_socket.hpp>

#include <functional>
#include <memory>
#include <string>

namespace anogate::http {

class OpenWebSocket : public WebSocket {
public:
    /// At once; its user is gone then.
    virtual void end() = 0;
    /// Its user is not to be cut off.
    virtual bool has_last_words() const = 0;
    /// Something waits to be sent, and since then nothing was taken.
    virtual bool is_stalled_since(ano::TimePoint time) const = 0;
};

/// `request` has no web_socket_fault(); `early` is what came behind it. It lives as long as the connection, and `place` with it.
std::shared_ptr<OpenWebSocket> open_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::string early, std::unique_ptr<WebSocketUser> user,
                                               const WebSocketLimits& limits, std::shared_ptr<void> place);

/// The client's side: asks for one by the target and the headers of `request`, which are all but those of the handshake. `ended` is
/// called once, unless end() came before, when the user is gone: with the status 101 when it was open, else with what was answered
/// instead, or with none where nothing was within `patience`.
std::shared_ptr<OpenWebSocket> join_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::unique_ptr<WebSocketUser> user, const WebSocketLimits& limits,
                                               ano::Duration patience, std::function<void(Outcome)> ended);

}    // namespace anogate::http
