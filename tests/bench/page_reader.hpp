// An open page without a browser: it sends the requests of Charts to the gateway, at the same rate, on as many connections.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>

namespace bench {

/// Receives all frames from 0x30 (see Steady) like Charts, and requests the rest like src/web/src/live/gateway.ts.
class PageReader {
public:
    /// `port`: on 127.0.0.1, where the gateway serves the page; `token`: the one that a browser sends; empty: none is needed.
    PageReader(std::uint16_t port, const std::string& token);
    ~PageReader();
    PageReader(const PageReader&) = delete;
    PageReader& operator=(const PageReader&) = delete;

private:
    using Time = std::chrono::steady_clock::time_point;
    void read_frames();
    void ask_for_more();
    void ask(std::string_view path);

    std::string headers_;
    int frames_;      // the WebSocket
    int requests_;    // the persistent connection
    std::atomic<Time> heard_at_{};
    std::atomic<bool> stop_{false};
    std::thread listens_, asks_;
};

}    // namespace bench
