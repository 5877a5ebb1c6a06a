// The interface by which outboxes report what happens to waiting frames.
#pragma once
#include <ano/frame.hpp>
#include <gateway/counters.hpp>
#include <gateway/ids.hpp>

namespace anogate {

/// Called once for every frame that was queued: it left, or was dropped. The frame is valid during the call.
class OutboxWatch {
public:
    /// The whole frame left by `channel`.
    virtual void left(ChannelId channel, ano::FrameView frame) noexcept = 0;
    virtual void dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept = 0;

protected:
    ~OutboxWatch() = default;
};

}    // namespace anogate
