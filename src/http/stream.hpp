// A bidirectional connection of any kind.
#pragma once
#include <http/asio.hpp>
#include <http/listeners/connection_info.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

namespace anogate::http {

class Stream {
public:
    using Done = std::function<void(error_code, std::size_t)>;
    using Parts = std::array<asio::const_buffer, 3>;    // empty ones are skipped

    virtual ~Stream() = default;
    /// True if the client has ended its output; some of it may be unread.
    virtual bool has_left() const { return false; }
    /// True if the client has sent something that was not read yet, as far as that is known.
    virtual bool has_more() const { return false; }
    /// One read and one write at a time. `done` is called from the loop, never from within the call, even if the stream is destroyed
    /// meanwhile.
    virtual void read_some(asio::mutable_buffer into, Done done) = 0;
    virtual void write_some(const Parts& from, Done done) = 0;
    /// Ends the current operations with an error.
    virtual void cancel() = 0;
    /// Ends the output: the client receives the written data, then the end of the stream.
    virtual void end_output() = 0;
    virtual void close() = 0;
    /// The user at the other end of a Unix socket; unknown_user for other connections.
    virtual std::uint32_t user() const = 0;
    virtual const ConnectionInfo& connection_info() const = 0;
};

/// A connected socket, Unix or TCP.
using Socket = asio::generic::stream_protocol::socket;
std::unique_ptr<Stream> stream_of(Socket socket, ConnectionInfo connection_info = {});

/// True if the client has closed the connection and left no request. A TLS client that has closed its half counts as gone in any
/// case.
bool is_gone(Socket& socket, bool is_encrypted = false) noexcept;

}    // namespace anogate::http
