// The control interface: HTTP with JSON over a Unix socket.
#pragma once
#include <daemon/socket_file.hpp>
#include <link/asio.hpp>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// Its clients take turns with the gateway's loop: one request of one of them, whoever asks longest, then what came in meanwhile.
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

    using Outcome = SocketFile::Outcome;
    /// Listens at `path`; a folder of our own is made when missing, a socket that a dead process left is replaced. The group
    /// `anogate` may use it; without such a group only our own user (the log says so). After an error it may be tried again.
    Outcome start(const std::string& path);
    /// Closes everything at once and removes the socket. The loop may still hold what will not run: it must not run after us.
    void stop();

private:
    class Farewell;
    class Session;
    void accept();
    void admit(asio::local::stream_protocol::socket socket);
    bool make_place(std::uint32_t user);
    void refuse(asio::local::stream_protocol::socket socket);
    void await_turn(std::shared_ptr<Session> session);
    void give_turn();

    asio::local::stream_protocol::acceptor acceptor_;
    asio::steady_timer pause_;
    SocketFile file_;
    std::map<std::string, Answer> answers_;
    std::map<std::string, Action> actions_;
    std::vector<std::weak_ptr<Session>> sessions_;
    std::deque<std::shared_ptr<Session>> waiting_;    // each with a whole request
    bool turn_given_ = false;
    std::deque<std::weak_ptr<Farewell>> leaving_;
};

}    // namespace anogate
