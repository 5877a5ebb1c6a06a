// The interface through which outboxes report the result for waiting frames.
#pragma once
#include <ano/frame.hpp>
#include <gateway/counters.hpp>
#include <gateway/ids.hpp>

namespace anogate {

/// Called once for each queued frame: it was sent, or dropped. The frame is valid during the call.
class OutboxWatch {
public:
    /// The whole frame was sent on `channel`.
    virtual void left(ChannelId channel, ano::FrameView frame) noexcept = 0;
    virtual void dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept = 0;

protected:
    ~OutboxWatch() = default;
};

}    // namespace anogate
