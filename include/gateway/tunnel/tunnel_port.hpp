// The interface of the tunnel for the Forwarder.
#pragma once
#include <ano/frame.hpp>
#include <gateway/channel.hpp>

namespace anogate {

class TunnelPort {
public:
    /// Whether `frame` is a tunnel frame for us.
    virtual bool takes(ano::FrameView frame) const noexcept = 0;
    /// Sends the content of a tunnel frame, which takes() accepts and which was admitted, as a datagram. Each inner frame must
    /// pass Forwarder::passes_into_tunnel().
    virtual void carry(Channel& from, ano::FrameView frame) = 0;
    /// Counts a tunnel frame from inside a tunnel frame that was to be sent by the tunnel again.
    virtual void refuse_nested() noexcept = 0;

protected:
    ~TunnelPort() = default;
};

}    // namespace anogate
