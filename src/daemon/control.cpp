#include <link/asio.hpp>

#include <daemon/control.hpp>
#include <daemon/control_places.hpp>
#include <daemon/rooms.hpp>
#include <link/own_folder.hpp>

#include <spdlog/spdlog.h>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <optional>

namespace anogate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using Local = asio::local::stream_protocol;

constexpr std::size_t max_sessions = 32;
constexpr std::size_t max_header = 8 * 1024;
constexpr std::size_t max_body = 64 * 1024;
constexpr std::size_t read_size = 4 * 1024;
constexpr auto patience = std::chrono::seconds{30};
constexpr auto stalled_after = std::chrono::seconds{1};
constexpr std::size_t max_leaving = 32;
constexpr std::size_t enough_memory = 384 * 1024;    // for one request with its answer: without it, they are not begun
constexpr auto moment = std::chrono::seconds{1};
constexpr std::string_view no_place =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nRetry-After: 1\r\nConnection: close\r\n\r\n"
    "{\"error\": \"all places are taken by those who ask just now\"}\n";

using ano::Clock;

/// In a folder of his own, as $XDG_RUNTIME_DIR is, nobody else was to come in.
bool is_private(const fs::path& folder) {
    struct stat info {};
    return ::stat(folder.c_str(), &info) == 0 && (info.st_mode & 0011) == 0;
}

std::uint32_t user_of(Local::socket& socket) {
    ucred who{};
    socklen_t size = sizeof who;
    return ::getsockopt(socket.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 ? who.uid : uid_t(-1);
}

}    // namespace

// The end of a connection whose client is told why. What it still says is heard for a moment and forgotten: were the socket closed
// before that is read, the client would learn of the end of the connection alone.
class Control::Farewell : public std::enable_shared_from_this<Farewell> {
public:
    explicit Farewell(Local::socket socket) : stream_{std::move(socket)} {}

    void close() {
        error_code ignored;
        stream_.socket().close(ignored);
    }
    void say(std::string_view words) {
        error_code ignored;
        ::send(stream_.socket().native_handle(), words.data(), words.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        stream_.socket().shutdown(Local::socket::shutdown_send, ignored);
        stream_.expires_after(moment);
        hear();
    }

private:
    void hear() {
        stream_.async_read_some(asio::buffer(room_), [self = shared_from_this()](error_code ec, std::size_t size) {
            self->heard_ += size;
            if (!ec && self->heard_ < max_header + max_body) self->hear();
        });
    }

    beast::basic_stream<Local> stream_;
    std::array<char, 1024> room_;
    std::size_t heard_ = 0;
};

// One connection, from its first request to its last.
class Control::Session : public std::enable_shared_from_this<Session> {
public:
    Session(Control& control, Local::socket socket) : control_{control}, user_{user_of(socket)}, stream_{std::move(socket)} {}

    void close() {
        error_code ignored;
        stream_.socket().close(ignored);
    }

    Visitor visitor(ano::TimePoint now) const {
        const bool stalled = !awaits_turn_ && now - since_ >= stalled_after;
        return {user_, stalled ? Asking::nothing : asking_, since_};
    }

    /// Its place is another's now. Who is not in the middle of an answer, and may be about to read one, is told.
    void leave() {
        if (asking_ == Asking::nothing || (asking_ == Asking::whole && !awaits_turn_)) return close();
        control_.refuse(stream_.release_socket());
    }

    /// Waits for the next request, of which some may be here.
    void start() {
        request_.emplace();
        request_->header_limit(max_header);
        request_->body_limit(max_body);
        request_->eager(true);
        stream_.expires_after(patience);
        since_ = Clock::now();
        if (buffer_.size() == 0) return read();
        asking_ = Asking::half;
        hear();
    }

    /// Its turn: the request is answered.
    void write() {
        if (!stream_.socket().is_open()) return;
        if (!memory_is_left(enough_memory)) return close();
        response_ = answer(request_->get());
        stream_.expires_after(patience);
        since_ = Clock::now();
        awaits_turn_ = false;
        http::async_write(stream_, response_, [self = shared_from_this()](error_code ec, std::size_t) {
            if (ec) return;
            self->asking_ = Asking::nothing;
            if (self->response_.keep_alive()) return self->start();
            self->stream_.socket().shutdown(Local::socket::shutdown_send, ec);
        });
    }

private:
    void read() {
        stream_.async_read_some(buffer_.prepare(read_size), [self = shared_from_this()](error_code ec, std::size_t size) {
            if (ec) return;
            self->buffer_.commit(size);
            self->since_ = Clock::now();
            self->asking_ = Asking::half;
            self->hear();
        });
    }

    void hear() {
        if (!memory_is_left(enough_memory)) return close();
        error_code ec;
        buffer_.consume(request_->put(buffer_.data(), ec));
        if (ec && ec != http::error::need_more) return;
        if (!request_->is_done()) return read();
        asking_ = Asking::whole;
        awaits_turn_ = true;
        control_.await_turn(shared_from_this());
    }

    http::response<http::string_body> answer(const http::request<http::string_body>& request) const {
        http::response<http::string_body> response{http::status::ok, request.version()};
        const std::string target{request.target().data(), request.target().size()};
        const std::string path = target.substr(0, target.find('?'));
        const auto found = control_.answers_.find(path);
        const auto action = control_.actions_.find(path);
        const bool head = request.method() == http::verb::head;
        if (found != control_.answers_.end() && (head || request.method() == http::verb::get)) {
            response.body() = found->second();
        } else if (action != control_.actions_.end() && request.method() == http::verb::post) {
            Reply reply = action->second(request.body());
            response.result(reply.status);
            response.body() = std::move(reply.body);
        } else if (found == control_.answers_.end() && action == control_.actions_.end()) {
            response.result(http::status::not_found);
            response.body() = "{\"error\": \"there is nothing at this path; try /status\"}\n";
        } else {
            const std::string allowed = found != control_.answers_.end() ? "GET, HEAD" : "POST";
            response.result(http::status::method_not_allowed);
            response.set(http::field::allow, allowed);
            response.body() = "{\"error\": \"this path answers " + allowed + " only\"}\n";
        }
        response.set(http::field::content_type, "application/json");
        response.set(http::field::server, "anogate");
        response.keep_alive(request.keep_alive());
        response.prepare_payload();
        if (head) response.body().clear();    // told how long it would be, and not given it
        return response;
    }

    Control& control_;
    std::uint32_t user_;
    Asking asking_ = Asking::unheard;
    bool awaits_turn_ = false;    // with a whole request
    ano::TimePoint since_;        // it came, or came on
    beast::basic_stream<Local> stream_;
    beast::flat_buffer buffer_;
    std::optional<http::request_parser<http::string_body>> request_;
    http::response<http::string_body> response_;
};

Control::Outcome Control::start(const std::string& path) {
    error_code ec;
    acceptor_.open(Local{}, ec);
    Outcome outcome = ec ? Outcome{path + ": " + ec.message()} : file_.listen(acceptor_.native_handle(), path);
    if (!outcome.error.empty()) {
        acceptor_.close(ec);
        return outcome;
    }
    const group* group = ::getgrnam("anogate");
    if ((!group || !file_.let_in(group->gr_gid)) && !is_private(folder_of(path)))
        spdlog::info("{}: only this user may use it, for there is no group `anogate` we are in", path);
    accept();
    return {};
}

void Control::accept() {
    acceptor_.async_accept([this](error_code ec, Local::socket socket) {
        if (!acceptor_.is_open()) return;
        if (ec) {    // out of descriptors, mostly: some may come free
            pause_.expires_after(std::chrono::seconds{1});
            pause_.async_wait([this](error_code stopped) {
                if (!stopped && acceptor_.is_open()) accept();
            });
            return;
        }
        admit(std::move(socket));
        accept();
    });
}

void Control::admit(Local::socket socket) {
    if (!memory_is_left(enough_memory)) return;
    if (!make_place(user_of(socket))) return refuse(std::move(socket));
    auto session = std::make_shared<Session>(*this, std::move(socket));
    sessions_.push_back(session);
    session->start();
}

bool Control::make_place(std::uint32_t user) {
    std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
    if (sessions_.size() < max_sessions) return true;
    std::vector<Visitor> visitors;
    for (const auto& session : sessions_) visitors.push_back(session.lock()->visitor(Clock::now()));
    const auto place = gives_way(visitors, user, user == 0 || user == ::geteuid());
    if (!place) return false;
    const auto leaves = sessions_[*place].lock();
    sessions_.erase(sessions_.begin() + static_cast<std::ptrdiff_t>(*place));
    std::erase(waiting_, leaves);
    leaves->leave();
    return true;
}

void Control::refuse(Local::socket socket) {
    std::erase_if(leaving_, [](const auto& farewell) { return farewell.expired(); });
    if (leaving_.size() == max_leaving) {
        leaving_.front().lock()->close();
        leaving_.pop_front();
    }
    const auto farewell = std::make_shared<Farewell>(std::move(socket));
    leaving_.push_back(farewell);
    farewell->say(no_place);
}

void Control::await_turn(std::shared_ptr<Session> session) {
    waiting_.push_back(std::move(session));
    if (!turn_given_) give_turn();
}

// Between the two posts the loop asks the system what else is to be done, and behind the second that stands before us.
void Control::give_turn() {
    turn_given_ = true;
    asio::post(acceptor_.get_executor(), [this] {
        asio::post(acceptor_.get_executor(), [this] {
            turn_given_ = false;
            if (waiting_.empty()) return;
            const auto session = std::move(waiting_.front());
            waiting_.pop_front();
            session->write();
            if (!waiting_.empty()) give_turn();
        });
    });
}

void Control::stop() {
    if (!acceptor_.is_open()) return;
    file_.remove();    // first: who finds it must find somebody
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    waiting_.clear();
    for (const auto& session : sessions_)
        if (const auto alive = session.lock()) alive->close();
    sessions_.clear();
    for (const auto& farewell : leaving_)
        if (const auto alive = farewell.lock()) alive->close();
    leaving_.clear();
}

}    // namespace anogate
