// A WebSocket of a running gateway that is opened again whenever it ends.
#pragma once
#include <gateway/backoff.hpp>
#include <http/client/client.hpp>
#include <http/web_socket.hpp>
#include <sys/asio.hpp>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace anogate {

class GatewaySocket {
public:
    struct Events {
        std::function<void()> opened = [] {};
        std::function<void(std::string_view message, http::WebSocket::Kind kind)> received = [](auto, auto) {};
        /// Called once when the connection ends, or when the first of several attempts failed. `why`: one clause.
        std::function<void(const std::string& why)> closed = [](auto&) {};
    };

    /// `control`: the path of the gateway's socket; empty: it is searched in the usual places for each attempt. `target`: the path
    /// and the query of the request.
    GatewaySocket(asio::io_context& io, std::string control, std::string target, Events events);
    GatewaySocket(const GatewaySocket&) = delete;
    GatewaySocket& operator=(const GatewaySocket&) = delete;

    void start();
    /// No event is reported afterwards.
    void stop();

    bool is_open() const noexcept { return socket_ != nullptr; }
    /// False: the connection is not open or accepts no more; the message is dropped.
    bool send(std::string message);

private:
    class User;
    void open();
    void ended(const http::Outcome& outcome);

    asio::io_context& io_;
    std::string control_, target_;
    Events events_;
    asio::steady_timer retry_;
    Backoff backoff_;
    bool stopped_ = true;
    bool reported_ = false;    // that it is closed
    http::WebSocket* socket_ = nullptr;
    std::unique_ptr<http::Client> client_;    // of the present attempt
};

/// The path of the gateway's socket: `control`, or the one found in the usual places.
std::string gateway_socket_path(const std::string& control);

/// The reason for a response that is not the expected one: its "error", or its status.
std::string fault_of(const http::Outcome& outcome);

}    // namespace anogate
