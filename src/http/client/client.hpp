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
    /// Limit until the answer is complete; for a stream and a WebSocket, until it begins.
    ano::Duration patience = std::chrono::seconds{10};
    std::size_t body = 64 * 1024 * 1024;    // bytes of an answer
    std::size_t line = 1024 * 1024;         // bytes of one line of a stream
    WebSocketLimits web_socket{.message = 4 * 1024 * 1024};
};

/// One exchange at a time, each by its own connection. Beginning one cancels the one before without calling back. Callbacks come from
/// the loop, never from within the call that began the exchange, and may destroy the client.
class Client {
public:
    using Done = std::function<void(Outcome)>;

    /// `path`: the gateway's socket.
    Client(asio::io_context& io, std::string path, const ClientLimits& limits = {});
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    /// Cancels; no callback comes afterwards.
    ~Client();

    /// `done` gets the complete answer, whatever its status. A gateway without a free place is asked again within ClientLimits::patience.
    void ask(Request request, Done done);
    /// For an endless answer: calls `line` for each line, without its line end. `done` gets the body if the status is not 200.
    void stream(Request request, std::function<void(std::string_view line)> line, Done done);
    /// A WebSocket. `done` gets the status 101 if it was open, otherwise the answer. `user` is destroyed before.
    void open(Request request, std::unique_ptr<WebSocketUser> user, Done done);
    /// Closes the connection; no callback comes afterwards.
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
