#include <http/request.hpp>
#include <http/stream.hpp>
#include <sys/unread.hpp>

#include <poll.h>
#include <sys/socket.h>

#include <utility>

namespace anogate::http {
namespace {

class SocketStream final : public Stream {
public:
    SocketStream(Socket socket, ConnectionInfo connection_info)
        : socket_{std::move(socket)}, connection_info_{std::move(connection_info)} {
        ucred who{};
        socklen_t size = sizeof who;
        if (connection_info_.is_network || ::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_PEERCRED, &who, &size) != 0)
            return;
        user_ = who.uid;
        connection_info_.process = who.pid;
    }

    bool has_more() const override { return has_unread(const_cast<Socket&>(socket_).native_handle()); }
    void read_some(asio::mutable_buffer into, Done done) override { socket_.async_read_some(into, std::move(done)); }
    void write_some(const Parts& from, Done done) override { socket_.async_write_some(from, std::move(done)); }
    void cancel() override {
        error_code ignored;
        socket_.cancel(ignored);
    }
    void end_output() override {
        error_code ignored;
        socket_.shutdown(Socket::shutdown_send, ignored);
    }
    void close() override {
        error_code ignored;
        socket_.close(ignored);
    }
    std::uint32_t user() const override { return user_; }
    const ConnectionInfo& connection_info() const override { return connection_info_; }

private:
    Socket socket_;
    ConnectionInfo connection_info_;
    std::uint32_t user_ = unknown_user;
};

}    // namespace

std::unique_ptr<Stream> stream_of(Socket socket, ConnectionInfo connection_info) {
    return std::make_unique<SocketStream>(std::move(socket), std::move(connection_info));
}

bool is_gone(Socket& socket, bool is_encrypted) noexcept {
    pollfd look{socket.native_handle(), POLLRDHUP, 0};
    if (::poll(&look, 1, 0) != 1) return false;
    return is_encrypted || (look.revents & (POLLHUP | POLLERR)) != 0 || !has_unread(look.fd);
}

}    // namespace anogate::http
