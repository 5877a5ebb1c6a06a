// The tunnel as the Forwarder sees it.
#pragma once
#include <ano/frame.hpp>
#include <gateway/channel.hpp>

namespace anogate {

class TunnelPort {
public:
    /// A tunnel frame to us.
    virtual bool takes(ano::FrameView frame) const noexcept = 0;
    /// One that takes() is true for came by `from` and was admitted: what is inside leaves as a datagram. Each frame inside
    /// has to pass Forwarder::passes_into_tunnel().
    virtual void carry(Channel& from, ano::FrameView frame) = 0;
    /// A tunnel frame out of a tunnel frame was to leave by the tunnel again.
    virtual void refuse_nested() noexcept = 0;

protected:
    ~TunnelPort() = default;
};

}    // namespace anogate
