// Whether something was received on a socket.
#pragma once
#include <sys/socket.h>

namespace anogate {

/// True if bytes were received that are not read yet. Ask before a connection is closed because its client was silent.
inline bool has_unread(int socket) noexcept {
    char byte;
    return ::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

}    // namespace anogate
