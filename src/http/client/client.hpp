// An HTTP client for the Unix socket of a gateway.
#pragma once
#include <ano/time.hpp>
#include <http/answer.hpp>
#include <http/asio.hpp>
#include <http/request.hpp>
#include <http/web_socket.hpp>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace anogate::http {

struct ClientLimits {
    /// Time limit until the response is complete; for a stream and a WebSocket, until it begins.
    ano::Duration patience = std::chrono::seconds{10};
    std::size_t body = 64 * 1024 * 1024;    // bytes of a response
    std::size_t line = 1024 * 1024;         // bytes of one line of a stream
    WebSocketLimits web_socket{.message = 4 * 1024 * 1024};
};

/// One exchange at a time, each over its own connection. Starting one cancels the previous one without a callback. Callbacks are
/// called from the loop, never from within the call that started the exchange, and may destroy the client.
class Client {
public:
    using Done = std::function<void(Outcome)>;

    /// `path`: the gateway's socket.
    Client(asio::io_context& io, std::string path, const ClientLimits& limits = {});
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    /// Cancels the exchange; no callback is called afterwards.
    ~Client();

    /// `done` gets the complete response, whatever its status. If the gateway has no free place, the request is repeated within
    /// ClientLimits::patience.
    void ask(Request request, Done done);
    /// For an endless response: calls `line` for each line, without its line end. `done` gets the body if the status is not 200.
    void stream(Request request, std::function<void(std::string_view line)> line, Done done);
    /// Opens a WebSocket. `done` gets the status 101 if it was open, otherwise the response. `user` is destroyed first.
    void open(Request request, std::unique_ptr<WebSocketUser> user, Done done);
    /// Closes the connection; no callback is called afterwards.
    void cancel();

private:
    class Exchange;
    asio::io_context& io_;
    std::string path_;
    ClientLimits limits_;
    std::shared_ptr<Exchange> exchange_;
};

/// Client::ask() in a loop of its own; blocks until there is an outcome.
Outcome ask(const std::string& path, Request request, const ClientLimits& limits = {});

}    // namespace anogate::http
