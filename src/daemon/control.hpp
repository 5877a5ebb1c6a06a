// The control interface: HTTP with JSON over a Unix socket.
#pragma once
#include <link/asio.hpp>

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace anogate {

class Control {
public:
    /// Answers a GET with a JSON text.
    using Answer = std::function<std::string()>;

    /// Of a POST: the HTTP status and a JSON text.
    struct Reply {
        unsigned status = 200;
        std::string body;
    };
    using Action = std::function<Reply(const std::string& body)>;

    explicit Control(asio::io_context& io) : acceptor_{io}, pause_{io} {}
    ~Control() { stop(); }

    /// Before start(): what GET `path` answers.
    void get(std::string path, Answer answer) { answers_[std::move(path)] = std::move(answer); }

    /// Before start(): what POST `path` does.
    void post(std::string path, Action action) { actions_[std::move(path)] = std::move(action); }

    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the socket: it may be free later
    };
    /// Listens at `path`; a folder of our own is made when missing, a socket that a dead process left is replaced. The group
    /// `anogate` may use it; without such a group only our own user (the log says so). After an error it may be tried again.
    Outcome start(const std::string& path);
    /// Closes everything at once and removes the socket.
    void stop();

private:
    class Session;
    void accept();

    asio::local::stream_protocol::acceptor acceptor_;
    asio::steady_timer pause_;
    std::map<std::string, Answer> answers_;
    std::map<std::string, Action> actions_;
    std::map<std::uint64_t, std::weak_ptr<Session>> sessions_;
    std::uint64_t next_session_ = 0;
    std::string path_;
};

}  // namespace anogate
