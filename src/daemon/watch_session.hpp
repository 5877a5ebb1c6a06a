// Those who watch the frames, by a WebSocket or by lines that never end.
#pragma once
#include <ano/flexible.hpp>
#include <daemon/frame_watch.hpp>
#include <http/response.hpp>

#include <memory>

namespace anogate {

class Gateway;

/// What GET /frames is answered with; of the gateway that they are the frames of, for as long as its loop runs.
class FrameStreams {
public:
    explicit FrameStreams(const Gateway& gateway, FrameWatch& watch);
    http::Response answer(const http::Request& request);

private:
    const Gateway& gateway_;
    FrameWatch& watch_;
    ano::FlexibleLayouts flexible_;
};

}    // namespace anogate
