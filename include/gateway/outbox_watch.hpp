// Who is told what becomes of the frames that wait in outboxes.
#pragma once
#include <ano/frame.hpp>
#include <gateway/counters.hpp>
#include <gateway/ids.hpp>

namespace anogate {

/// Told of every frame that was queued, once: it left, or was dropped. The frame is valid during the call.
class OutboxWatch {
public:
    /// The whole of it left by `channel`.
    virtual void left(ChannelId channel, ano::FrameView frame) noexcept = 0;
    virtual void dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept = 0;

protected:
    ~OutboxWatch() = default;
};

}    // namespace anogate
