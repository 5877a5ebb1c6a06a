// Messages both ways over a connection that began as an HTTP request (RFC 6455).
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace anogate::http {

struct WebSocketLimits {
    std::size_t message = 64 * 1024;                   // bytes of one that comes; a longer one ends the connection (1009)
    std::size_t queue = 1024 * 1024;                   // bytes that wait to be sent
    ano::Duration idle = std::chrono::seconds{30};     // without a word, not even a pong: ends. Half of it: is pinged
    ano::Duration stuck = std::chrono::seconds{30};    // takes nothing of what waits: ends
};

/// The way to the client. Valid as long as its user lives.
class WebSocket {
public:
    enum class Kind : std::uint8_t { text, binary };
    /// One message may wait for many clients: it is not copied.
    using Message = std::shared_ptr<const std::string>;

    virtual ~WebSocket() = default;
    /// Sends it behind those that wait. False: there is no room, or it is closing; the message is dropped, and to be counted by who
    /// sends. A text must be UTF-8.
    virtual bool send(Message message, Kind kind) = 0;
    /// Bytes that wait to be sent.
    virtual std::size_t waiting() const noexcept = 0;
    /// How often bytes came. When it has not changed through a whole turn of the loop, nothing waits to be heard.
    virtual std::uint64_t reads() const noexcept = 0;
    /// Tells the client that it ends, and why; what waits is dropped. Nothing comes any more.
    virtual void close(std::uint16_t code, std::string_view reason) = 0;
};

/// Who speaks with the client. It is destroyed when the connection has ended, or the server stops.
class WebSocketUser {
public:
    virtual ~WebSocketUser() = default;
    /// What it speaks, of the subprotocols that the client offered; empty: none is told.
    virtual std::string_view subprotocol() const { return {}; }
    /// First.
    virtual void opened(WebSocket& socket) = 0;
    virtual void heard(std::string_view message, WebSocket::Kind kind) = 0;
    /// All that waited is sent.
    virtual void sent_all() {}
    /// When the server ends, it has something to say first, and then closes; else it is cut off.
    virtual bool has_last_words() const { return false; }
};

}    // namespace anogate::http
