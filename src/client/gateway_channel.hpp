// A channel of a running gateway (GET /link): frames that this program sends and receives like a device.
#pragma once
#include <ano/frame.hpp>
#include <ano/reading.hpp>
#include <client/gateway_socket.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace anogate {

class GatewayChannel {
public:
    struct Events {
        std::function<void()> opened = [] {};
        /// The frame is valid during the call.
        std::function<void(ano::FrameView frame)> frame = [](auto) {};
        std::function<void(const std::string& why)> closed = [](auto&) {};
    };

    /// `name` is shown by the gateway; letters, digits and '-'.
    GatewayChannel(asio::io_context& io, std::string control, const std::string& name, Events events);

    void start() { socket_.start(); }
    void stop() { socket_.stop(); }
    bool is_open() const noexcept { return socket_.is_open(); }

    /// False: the frame is dropped and counted, because the channel is not open or the gateway does not accept more.
    bool send(ano::Bytes frame);
    std::uint64_t dropped() const noexcept { return dropped_; }

private:
    Events events_;
    std::uint64_t dropped_ = 0;
    GatewaySocket socket_;
};

}    // namespace anogate
