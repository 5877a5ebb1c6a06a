#include <link/tcp/tcp_session.hpp>
#include <link/tcp/tcp_socket.hpp>

#include <cerrno>

namespace anogate {

ssize_t TcpSession::write_some(std::span<const iovec> pieces) {
    std::size_t bytes = not_sent(fd());
    if (bytes >= max_not_sent) {
        errno = EAGAIN;
        return -1;
    }
    std::size_t count = 0;
    while (count < pieces.size() && (count == 0 || bytes + pieces[count].iov_len <= max_not_sent)) bytes += pieces[count++].iov_len;
    return StreamSession::write_some(pieces.first(count));
}

}    // namespace anogate
