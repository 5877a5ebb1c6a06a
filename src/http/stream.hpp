// Bytes both ways, over whatever: what a session speaks through.
#pragma once
#include <http/asio.hpp>
#include <http/door.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

namespace anogate::http {

class Stream {
public:
    using Done = std::function<void(error_code, std::size_t)>;
    using Parts = std::array<asio::const_buffer, 3>;    // empty ones are passed over

    virtual ~Stream() = default;
    /// One read and one write at a time. `done` comes from the loop, never at once, also when the stream is gone meanwhile.
    virtual void read_some(asio::mutable_buffer into, Done done) = 0;
    virtual void write_some(const Parts& from, Done done) = 0;
    /// What is under way ends with an error.
    virtual void cancel() = 0;
    /// Nothing more is written: the client reads what was, and then the end.
    virtual void end_output() = 0;
    virtual void close() = 0;
    /// Who is at the other end of a Unix socket; unknown_user elsewhere.
    virtual std::uint32_t user() const = 0;
    virtual const Door& door() const = 0;
};

/// Of a connected socket, Unix or TCP.
using Socket = asio::generic::stream_protocol::socket;
std::unique_ptr<Stream> stream_of(Socket socket, Door door = {});

}    // namespace anogate::http
