#include <http/client/client.hpp>
#include <http/client/connect_fault.hpp>
#include <http/client/response_reader.hpp>
#include <http/open_web_socket.hpp>
#include <http/seconds_text.hpp>
#include <http/stream.hpp>
#include <sys/unique_fd.hpp>

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace anogate::http {
namespace {

using ano::Clock;

constexpr ano::Duration knock_again = std::chrono::milliseconds{20};

// The request as text. It is the only request of its connection.
std::string request_text(const Request& request) {
    std::string text = request.method + " " + request.target + " HTTP/1.1\r\nHost: anogate\r\nConnection: close\r\n";
    for (const Field& field : request.headers) text += field.name + ": " + field.value + "\r\n";
    if (!request.body.empty() && request.header("Content-Type").empty()) text += "Content-Type: application/json\r\n";
    if (!request.body.empty() || request.method != "GET")
        text += "Content-Length: " + std::to_string(request.body.size()) + "\r\n";
    return text + "\r\n" + request.body;
}

/// The time after which a request may be repeated if the gateway had no free place; 0: not at all.
ano::Duration retry_after(const Answer& answer) {
    unsigned wait = 0;
    const std::string_view wait_text = answer.header("Retry-After");
    std::from_chars(wait_text.data(), wait_text.data() + wait_text.size(), wait);
    return answer.status == 503 ? std::chrono::seconds{std::min(wait, 60U)} : ano::Duration{};
}

}    // namespace

class Client::Exchange : public std::enable_shared_from_this<Exchange> {
public:
    Exchange(asio::io_context& io, std::string path, const ClientLimits& limits, Request request, Done done)
        : io_{io},
          path_{std::move(path)},
          limits_{limits},
          request_{std::move(request)},
          done_{std::move(done)},
          deadline_{io},
          pause_{io} {}

    std::function<void(std::string_view)> line;
    std::unique_ptr<WebSocketUser> user;

    void start() {
        expires_at_ = Clock::now() + limits_.patience;
        deadline_.expires_at(expires_at_);
        deadline_.async_wait([self = shared_from_this()](error_code ec) {
            if (!ec)
                self->fail("the gateway at " + self->path_ + " did not answer within " + seconds_text(self->limits_.patience));
        });
        asio::post(io_, [self = shared_from_this()] { self->connect(); });
    }

    void cancel() {
        done_ = {};
        close();
    }

private:
    void connect() {
        if (!done_) return;
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        if (path_.size() >= sizeof address.sun_path)
            return fail(path_ + ": the path of a socket has at most " + std::to_string(sizeof address.sun_path - 1) + " bytes");
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        UniqueFd fd{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
        if (!fd || ::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
            const int error = errno;
            // The backlog of the gateway's socket is full.
            if (error == EAGAIN) return later(knock_again, &Exchange::connect);
            return fail(connect_fault(path_, error, look_at_socket(path_)));
        }
        stream_ = stream_of(Socket{io_, asio::generic::stream_protocol{AF_UNIX, 0}, fd.release()});
        if (user) return join();
        output_ = request_text(request_);
        write();
        read();
    }

    void join() {
        deadline_.cancel();
        web_socket_ = join_web_socket(io_, std::move(stream_), request_, std::move(user), limits_.web_socket,
                                      expires_at_ - Clock::now(),
                                      [self = shared_from_this()](Outcome outcome) { self->finish(std::move(outcome)); });
    }

    // Errors are ignored: a gateway that refuses a request may close before it has read all of it; its response can still be
    // read.
    void write() {
        if (output_.empty()) return;
        stream_->write_some({asio::buffer(output_) + written_}, [self = shared_from_this()](error_code ec, std::size_t size) {
            if (!self->stream_ || ec) return;
            self->written_ += size;
            if (self->written_ < self->output_.size()) self->write();
        });
    }

    void read() {
        stream_->read_some(asio::buffer(room_), [self = shared_from_this()](error_code ec, std::size_t size) {
            if (!self->stream_) return;
            self->input_.append(self->room_.data(), size);
            self->input_.erase(0, self->reader_.put(self->input_));
            if (ec && self->reader_.fault().empty()) self->reader_.end();
            if (ec && !self->reader_.is_done()) return self->ended_early();
            self->receive();
            if (self->stream_) self->read();
        });
    }

    void ended_early() {
        fail(has_head_ ? "the gateway stopped before its response was complete"
                       : "the program at " + path_ + " closed the connection without a response");
    }

    void receive() {
        if (!has_head_ && reader_.has_head()) {
            has_head_ = true;
            answer_.status = reader_.status();
            answer_.headers = reader_.headers();
            if (line && answer_.status == 200) deadline_.cancel();
        }
        if (has_head_ && answer_.header("Server") != "anogate") return fail("the program at " + path_ + " is not a gateway");
        if (has_head_ && !(line && answer_.status == 200 ? receive_lines() : receive_body())) return;
        if (reader_.is_done()) return answered();
        if (reader_.fault().empty()) return;
        fail("the program at " + path_ + (has_head_ ? " sent an invalid response: " : " is not a gateway: ") + reader_.fault());
    }

    bool receive_body() {
        answer_.body += reader_.pop_body();
        if (answer_.body.size() <= limits_.body) return true;
        fail("the response of the gateway is longer than " + std::to_string(limits_.body) + " bytes");
        return false;
    }

    // False: a callback or a line that is too long has ended the exchange.
    bool receive_lines() {
        lines_ += reader_.pop_body();
        std::size_t begin = 0;
        for (std::size_t end = 0; (end = lines_.find('\n', begin)) != std::string::npos; begin = end + 1) {
            line(std::string_view{lines_}.substr(begin, end - begin));
            if (!done_) return false;
        }
        lines_.erase(0, begin);
        if (lines_.size() <= limits_.line) return true;
        fail("a line of the gateway is longer than " + std::to_string(limits_.line) + " bytes");
        return false;
    }

    void answered() {
        const ano::Duration wait = retry_after(answer_);
        if (wait == ano::Duration{} || line || Clock::now() + wait >= expires_at_) return finish({{}, std::move(answer_)});
        stream_->close();
        stream_.reset();
        reader_ = ResponseReader{};
        input_.clear();
        written_ = 0;
        has_head_ = false;
        answer_ = {};
        later(wait, &Exchange::connect);
    }

    void later(ano::Duration wait, void (Exchange::*what)()) {
        pause_.expires_after(wait);
        pause_.async_wait([self = shared_from_this(), what](error_code ec) {
            if (!ec && self->done_) (self.get()->*what)();
        });
    }

    void fail(std::string why) { finish({std::move(why), {}}); }

    void finish(Outcome outcome) {
        if (!done_) return;
        const Done done = std::move(done_);
        cancel();
        done(std::move(outcome));
    }

    void close() {
        deadline_.cancel();
        pause_.cancel();
        if (const auto socket = std::exchange(web_socket_, nullptr)) socket->end();
        if (stream_) stream_->close();
        stream_.reset();
    }

    asio::io_context& io_;
    const std::string path_;
    const ClientLimits limits_;
    const Request request_;
    Done done_;    // empty: the exchange has ended
    asio::steady_timer deadline_, pause_;
    ano::TimePoint expires_at_{};
    std::unique_ptr<Stream> stream_;
    std::shared_ptr<OpenWebSocket> web_socket_;
    std::string output_;
    std::size_t written_ = 0;
    std::array<char, 16 * 1024> room_;
    std::string input_;    // received but not parsed yet
    ResponseReader reader_;
    bool has_head_ = false;
    Answer answer_;
    std::string lines_;    // the last, incomplete line of a stream
};

Client::Client(asio::io_context& io, std::string path, const ClientLimits& limits)
    : io_{io}, path_{std::move(path)}, limits_{limits} {}

Client::~Client() { cancel(); }

void Client::cancel() {
    if (const auto exchange = std::exchange(exchange_, nullptr)) exchange->cancel();
}

void Client::ask(Request request, Done done) {
    cancel();
    exchange_ = std::make_shared<Exchange>(io_, path_, limits_, std::move(request), std::move(done));
    exchange_->start();
}

void Client::stream(Request request, std::function<void(std::string_view line)> line, Done done) {
    cancel();
    exchange_ = std::make_shared<Exchange>(io_, path_, limits_, std::move(request), std::move(done));
    exchange_->line = std::move(line);
    exchange_->start();
}

void Client::open(Request request, std::unique_ptr<WebSocketUser> user, Done done) {
    cancel();
    exchange_ = std::make_shared<Exchange>(io_, path_, limits_, std::move(request), std::move(done));
    exchange_->user = std::move(user);
    exchange_->start();
}

Outcome ask(const std::string& path, Request request, const ClientLimits& limits) {
    asio::io_context io{1};
    Outcome outcome;
    Client client{io, path, limits};
    client.ask(std::move(request), [&](Outcome came) { outcome = std::move(came); });
    io.run();
    return outcome;
}

}    // namespace anogate::http
