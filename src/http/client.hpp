// The other side of the door: asks a gateway by its Unix socket.
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
    /// Until the answer is whole; of a stream and a WebSocket, until it begins.
    ano::Duration patience = std::chrono::seconds{10};
    std::size_t body = 64 * 1024 * 1024;    // bytes of an answer
    std::size_t line = 1024 * 1024;         // bytes of one line of a stream
    WebSocketLimits web_socket{.message = 4 * 1024 * 1024};
};

/// One exchange at a time, each by a connection of its own; what begins one while another is under way ends that one, without a word.
/// It works when its loop runs, and calls from the loop only, never at once. Calls may destroy it.
class Client {
public:
    using Done = std::function<void(Outcome)>;

    /// `path` of the gateway's socket.
    Client(asio::io_context& io, std::string path, const ClientLimits& limits = {});
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    /// Nothing is called any more.
    ~Client();

    /// The answer whole, whatever its status. A gateway that has no place for us now is asked again within our patience.
    void ask(Request request, Done done);
    /// An answer that never ends: `line` has one at a time, without its end. `done` has the body of an answer that is not 200.
    void stream(Request request, std::function<void(std::string_view line)> line, Done done);
    /// A WebSocket. `done` has the status 101 when it was open, else what was answered instead. The user is gone then.
    void open(Request request, std::unique_ptr<WebSocketUser> user, Done done);
    /// Without a word to anybody here; the gateway sees the end of the connection.
    void cancel();

private:
    class Exchange;
    asio::io_context& io_;
    std::string path_;
    ClientLimits limits_;
    std::shared_ptr<Exchange> exchange_;
};

/// The same in a loop of its own: returns when there is an outcome.
Outcome ask(const std::string& path, Request request, const ClientLimits& limits = {});

}    // namespace anogate::http
