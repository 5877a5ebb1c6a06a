// A page that is looked at, without a browser: it asks the gateway what Charts asks, as often, on as many connections.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>

namespace bench {

/// Takes all frames that come from 0x30 (see Steady) as Charts does, and asks for the rest as src/web/src/live/gateway.ts.
class PageReader {
public:
    /// `port`: of 127.0.0.1, where the gateway serves the page; `token`: what a browser shows it, empty: none is needed.
    PageReader(std::uint16_t port, const std::string& token);
    ~PageReader();
    PageReader(const PageReader&) = delete;
    PageReader& operator=(const PageReader&) = delete;

private:
    using Time = std::chrono::steady_clock::time_point;
    void take_frames();
    void ask_for_more();
    void ask(std::string_view path);

    std::string headers_;
    int frames_;      // the WebSocket
    int requests_;    // the connection that is kept
    std::atomic<Time> heard_at_{};
    std::atomic<bool> stop_{false};
    std::thread listens_, asks_;
};

}    // namespace bench
