// A connection that has become a WebSocket.
#pragma once
#include <http/request.hpp>
#include <http/stream.hpp>
#include <http/web_socket.hpp>

#include <memory>
#include <string>

namespace anogate::http {

class OpenWebSocket : public WebSocket {
public:
    /// At once; its user is gone then.
    virtual void end() = 0;
    /// Something waits to be sent, and since then nothing was taken.
    virtual bool is_stalled_since(ano::TimePoint time) const = 0;
};

/// `request` has no web_socket_fault(); `early` is what came behind it. It lives as long as the connection, and `place` with it.
std::shared_ptr<OpenWebSocket> open_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::string early, std::unique_ptr<WebSocketUser> user,
                                               const WebSocketLimits& limits, std::shared_ptr<void> place);

}    // namespace anogate::http
