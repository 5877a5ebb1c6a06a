// Streams of frames to watchers, by WebSocket or as an endless response with lines.
#pragma once
#include <http/response.hpp>
#include <watch/frame_watch.hpp>

#include <memory>

namespace anogate {

class Gateway;

/// Answers GET /frames. Must exist as long as the loop of the gateway runs.
class FrameStreams {
public:
    explicit FrameStreams(const Gateway& gateway, FrameWatch& watch);
    http::Response answer(const http::Request& request);

private:
    const Gateway& gateway_;
    FrameWatch& watch_;
};

}    // namespace anogate
