// A TCP connection as a stream of frames.
#pragma once
#include <link/stream_session.hpp>

namespace anogate {

class TcpSession : public StreamSession {
public:
    using StreamSession::StreamSession;

protected:
    /// Keeps what the kernel has not sent below about 2 KiB, so that urgent frames pass in our queue. The socket option for that
    /// (TCP_NOTSENT_LOWAT) delays only the event that it can be written: a write beyond it is still taken.
    ssize_t write_some(std::span<const iovec> pieces) override;
};

}    // namespace anogate
