// The frames of a running gateway (GET /frames), with the names of their links.
#pragma once
#include <client/gateway_socket.hpp>
#include <gateway/frame_record.hpp>
#include <record/decoding.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct StreamedFrame {
    std::string_view link;
    const FrameRecord& record;
};

class FrameStream {
public:
    struct Events {
        /// The frame is valid during the call.
        std::function<void(const StreamedFrame&)> frame = [](auto&) {};
        /// Called before the first frame, and whenever the layouts or links of the gateway change. Never nullptr.
        std::function<void(const DecodingPtr&)> decoding = [](auto&) {};
        /// The gateway dropped this number of frames because they were not received fast enough.
        std::function<void(std::uint64_t count)> lost = [](auto) {};
        std::function<void()> opened = [] {};
        std::function<void(const std::string& why)> closed = [](auto&) {};
    };

    /// `filters` of the query: "&direction=in".
    FrameStream(asio::io_context& io, std::string control, const std::string& filters, Events events);

    void start() { socket_.start(); }
    void stop() { socket_.stop(); }
    bool is_open() const noexcept { return socket_.is_open(); }

private:
    void receive(std::string_view message, http::WebSocket::Kind kind);
    void receive_text(std::string_view text);

    Events events_;
    std::vector<std::string> links_;
    GatewaySocket socket_;
};

}    // namespace anogate
