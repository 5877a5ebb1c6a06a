// A client that floods a TLS port of this computer with key updates.
#pragma once
#include <sys/unique_fd.hpp>

#include <netinet/in.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <cstdint>
#include <memory>

namespace support {

/// Sends TLS messages without data until the connection is closed, at most `most`. Returns their number; -1: no connection.
inline int flood_with_key_updates(std::uint16_t port, int most) {
    using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;
    const Context context{SSL_CTX_new(TLS_client_method()), SSL_CTX_free};
    const std::unique_ptr<SSL, decltype(&SSL_free)> ssl{SSL_new(context.get()), SSL_free};
    const anogate::UniqueFd fd{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) return -1;
    SSL_set_fd(ssl.get(), fd.get());
    if (SSL_connect(ssl.get()) != 1) return -1;
    for (int sent = 0; sent < most; ++sent)
        if (SSL_key_update(ssl.get(), SSL_KEY_UPDATE_NOT_REQUESTED) != 1 || SSL_do_handshake(ssl.get()) != 1) return sent;
    return most;
}

}    // namespace support
