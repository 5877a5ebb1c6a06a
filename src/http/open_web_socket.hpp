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
    /// Closes the connection at once and destroys the user.
    virtual void end() = 0;
    /// WebSocketUser::closes_itself().
    virtual bool closes_itself() const = 0;
    /// True if data wait to be sent and the client has accepted none since `time`.
    virtual bool is_stalled_since(ano::TimePoint time) const = 0;
    /// Passes the waiting message to the user.
    virtual void run_turn() = 0;
};

/// The server's side. `request` must have no web_socket_fault(); `early`: bytes that were received after it. The result lives as
/// long as the connection and holds `place`. `wait_for_turn` is called for each message; the user receives the message in
/// run_turn(), and no further one is read before. Without `wait_for_turn` the user receives each message at once.
std::shared_ptr<OpenWebSocket> open_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::string early, std::unique_ptr<WebSocketUser> user,
                                               const WebSocketLimits& limits, std::shared_ptr<void> place,
                                               std::function<void()> wait_for_turn = {});

/// The client's side. `request` has the target and the headers without those of the handshake. `ended` is called once after the
/// user is destroyed, unless end() was called first: with the status 101 if the WebSocket was open, otherwise with the response,
/// or with none if none was received within `patience`.
std::shared_ptr<OpenWebSocket> join_web_socket(asio::io_context& io, std::unique_ptr<Stream> stream, const Request& request,
                                               std::unique_ptr<WebSocketUser> user, const WebSocketLimits& limits,
                                               ano::Duration patience, std::function<void(Outcome)> ended);

}    // namespace anogate::http
