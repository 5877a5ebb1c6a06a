#include <link/asio.hpp>

#include <daemon/control.hpp>
#include <link/errors.hpp>
#include <link/own_folder.hpp>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <spdlog/spdlog.h>

#include <fcntl.h>
#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

namespace anogate {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace fs = std::filesystem;
using Local = asio::local::stream_protocol;

constexpr std::size_t most_sessions = 32;
constexpr std::size_t most_header = 8 * 1024;
constexpr std::size_t most_body = 64 * 1024;
constexpr auto patience = std::chrono::seconds{30};

// The socket is not ours to replace, unless it is known that nobody listens there: a refusal for any other reason (of another
// type, no permission, out of descriptors) says nothing about that.
bool is_alive(const std::string& path) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    const int result = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    const bool dead = result != 0 && errno == ECONNREFUSED;
    if (fd >= 0) ::close(fd);
    return !dead;
}

/// In a folder of his own, as $XDG_RUNTIME_DIR is, nobody else was to come in.
bool is_private(const fs::path& folder) {
    struct stat info {};
    return ::stat(folder.c_str(), &info) == 0 && (info.st_mode & 0011) == 0;
}

void let_group_in(const std::string& path) {
    const group* group = ::getgrnam("anogate");
    if (group && ::chown(path.c_str(), uid_t(-1), group->gr_gid) == 0) {
        ::chmod(path.c_str(), 0660);
    } else {
        ::chmod(path.c_str(), 0600);
        if (is_private(fs::path{path}.parent_path())) return;
        spdlog::info("{}: only this user may use it, for there is no group `anogate` we are in", path);
    }
}

}  // namespace

// One connection, from its first request to its last.
class Control::Session : public std::enable_shared_from_this<Session> {
public:
    Session(Control& control, Local::socket socket) : control_{control}, stream_{std::move(socket)} {}

    void close() {
        error_code ignored;
        stream_.socket().close(ignored);
    }

    void read() {
        request_.emplace();
        request_->header_limit(most_header);
        request_->body_limit(most_body);
        stream_.expires_after(patience);
        http::async_read(stream_, buffer_, *request_, [self = shared_from_this()](error_code ec, std::size_t) {
            if (!ec) self->write();
        });
    }

private:
    void write() {
        response_ = answer(request_->get());
        stream_.expires_after(patience);
        http::async_write(stream_, response_, [self = shared_from_this()](error_code ec, std::size_t) {
            if (ec) return;
            if (self->response_.keep_alive()) return self->read();
            self->stream_.socket().shutdown(Local::socket::shutdown_send, ec);
        });
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
    beast::basic_stream<Local> stream_;
    beast::flat_buffer buffer_;
    std::optional<http::request_parser<http::string_body>> request_;
    http::response<http::string_body> response_;
};

Control::Outcome Control::start(const std::string& path) {
    if (path.size() >= sizeof sockaddr_un{}.sun_path)
        return {path + ": the path of a socket has at most " + std::to_string(sizeof sockaddr_un{}.sun_path - 1) + " bytes"};
    std::error_code ignored;
    if (std::string error = make_folder_of(path); !error.empty()) return {std::move(error)};
    if (fs::is_socket(fs::symlink_status(path, ignored))) {
        if (is_alive(path)) return {path + ": another program is using it (give this one another by --control)", true};
        fs::remove(path, ignored);
    } else if (fs::exists(fs::symlink_status(path, ignored))) {
        return {path + ": exists and is no socket (give another path by --control)"};
    }
    error_code ec;
    acceptor_.open(Local{}, ec);
    // bind() gives the file this mode: nobody gets in before let_group_in(). The umask would be that of every thread.
    if (!ec && ::fchmod(acceptor_.native_handle(), 0600) != 0) ec.assign(errno, boost::system::system_category());
    if (!ec) acceptor_.bind(Local::endpoint{path}, ec);
    if (!ec) acceptor_.listen(16, ec);
    if (ec) {
        error_code ignored_too;
        acceptor_.close(ignored_too);
        return {error_text(path, ec.value()) + " (give another path by --control, or --control none)"};
    }
    path_ = path;
    let_group_in(path);
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
        std::erase_if(sessions_, [](const auto& s) { return s.second.expired(); });
        if (sessions_.size() < most_sessions) {    // one more than that is closed at once
            auto session = std::make_shared<Session>(*this, std::move(socket));
            sessions_[next_session_++] = session;
            session->read();
        }
        accept();
    });
}

void Control::stop() {
    if (!acceptor_.is_open()) return;
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    for (auto& [number, session] : sessions_)
        if (const auto alive = session.lock()) alive->close();
    sessions_.clear();
    std::error_code gone;
    fs::remove(path_, gone);
}

}  // namespace anogate
