// A WebSocket (RFC 6455).
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <string_view>

namespace anogate::http {

struct WebSocketLimits {
    std::size_t message = 64 * 1024;    // maximum bytes of a received message; a longer one ends the connection (1009)
    std::size_t queue = 1024 * 1024;    // maximum bytes that wait to be sent
    ano::Duration idle = std::chrono::seconds{30};     // ends after this time without any data or pong; pings after half of it
    ano::Duration stuck = std::chrono::seconds{30};    // ends if data wait and the client accepts none for this time
};

/// Sends messages to the client. Valid as long as its user lives.
class WebSocket {
public:
    enum class Kind : std::uint8_t { text, binary };
    /// Shared, so that a message for many clients is not copied.
    using Message = std::shared_ptr<const std::string>;

    virtual ~WebSocket() = default;
    /// Sends the message after those that wait. False: the queue is full, or the WebSocket is closing; the message is dropped,
    /// and the caller should count it. A text must be UTF-8.
    virtual bool send(Message message, Kind kind) = 0;
    /// Bytes that wait to be sent.
    virtual std::size_t waiting() const noexcept = 0;
    /// Number of reads so far. If it has not changed during a whole turn of the loop, no received data is waiting.
    virtual std::uint64_t reads() const noexcept = 0;
    /// Sends a close frame with code and reason; drops waiting messages. heard() is not called any more.
    virtual void close(std::uint16_t code, std::string_view reason) = 0;

    /// Calls `function`, which makes and sends messages, from outside of the user's functions. If memory is short for that, only
    /// the connection ends, as abandon() does it.
    template <class Function>
    void attempt(Function function) {
        try {
            function();
        } catch (const std::bad_alloc&) {
            abandon();
        }
    }

protected:
    /// Ends the connection as soon as the loop runs: the user may be running now.
    virtual void abandon() noexcept = 0;
};

/// The code that uses a WebSocket. Destroyed when the connection has ended or the server stops. If one of its functions throws
/// std::bad_alloc, the connection ends.
class WebSocketUser {
public:
    virtual ~WebSocketUser() = default;
    /// The subprotocol chosen from those that the client offered; empty: none.
    virtual std::string_view subprotocol() const { return {}; }
    /// The connection ends after this time without any data or pong from the client. `usual`: WebSocketLimits::idle.
    virtual ano::Duration idle(ano::Duration usual) const { return usual; }
    /// Called first.
    virtual void opened(WebSocket& socket) = 0;
    virtual void heard(std::string_view message, WebSocket::Kind kind) = 0;
    /// Called when all waiting messages were sent.
    virtual void sent_all() {}
    /// True: when the server stops, the user sends a last message and then closes the WebSocket itself. False: it is
    /// disconnected.
    virtual bool closes_itself() const { return false; }
};

}    // namespace anogate::http
