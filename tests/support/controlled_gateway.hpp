// A gateway in the test's loop with its control interface, and clients of this interface in the same loop.
#pragma once
#include "running_gateway.hpp"
#include "temp_dir.hpp"

#include <control/raw_streams.hpp>
#include <control/routes.hpp>
#include <control/watch_session.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <http/client/client.hpp>
#include <http/server.hpp>
#include <http/task_pool.hpp>
#include <runtime/gateway_devices.hpp>
#include <watch/frame_watch.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace support {

class ControlledGateway {
public:
    explicit ControlledGateway(anogate::Settings settings, const anogate::http::ServerLimits& limits = {})
        : gateway{loop, std::move(settings)}, server{loop.io, limits} {
        anogate::add_routes(server.routes(), {gateway.gateway(), devices.service(), frames, foxglove, raw, disk});
        EXPECT_EQ(server.start(path).error, "");
    }
    explicit ControlledGateway(std::vector<std::string> links) : ControlledGateway{settings_of_texts(std::move(links))} {}
    ~ControlledGateway() {
        server.stop();
        loop.turn();
    }

    anogate::http::Answer ask(std::string method, std::string target, std::string body = {}) {
        anogate::http::Request request;
        request.method = std::move(method);
        request.target = std::move(target);
        request.body = std::move(body);
        if (!request.body.empty()) request.headers.push_back({"Content-Type", "application/json"});
        anogate::http::Client client{loop.io, path};
        std::optional<anogate::http::Outcome> outcome;
        client.ask(std::move(request), [&](anogate::http::Outcome came) { outcome = std::move(came); });
        EXPECT_TRUE(gateway.until([&] { return outcome.has_value(); }));
        return outcome ? outcome->answer : anogate::http::Answer{};
    }

    TempDir dir;
    std::string path = dir / "control.sock";
    Loop loop;
    RunningGateway gateway;
    anogate::GatewayDevices devices{gateway.gateway()};
    anogate::FrameWatch watch{gateway.gateway()};
    anogate::FrameStreams frames{gateway.gateway(), watch};
    anogate::FoxgloveStreams foxglove{gateway.gateway(), watch, devices.service()};
    anogate::RawStreams raw{gateway.gateway()};
    anogate::TaskPool disk{loop.io};
    anogate::http::Server server;
};

/// A client of a WebSocket that stores the received messages.
class MessageClient {
public:
    MessageClient(ControlledGateway& gateway, std::string target, std::vector<anogate::http::Field> headers = {})
        : client_{gateway.loop.io, gateway.path} {
        anogate::http::Request request;
        request.method = "GET";
        request.target = std::move(target);
        request.headers = std::move(headers);
        client_.open(std::move(request), std::make_unique<User>(state_),
                     [this](anogate::http::Outcome came) { ended = std::move(came); });
    }
    bool is_open() const { return state_.socket != nullptr; }
    void send(const Bytes& bytes) { send({bytes.begin(), bytes.end()}, anogate::http::WebSocket::Kind::binary); }
    void send(std::string words, anogate::http::WebSocket::Kind kind) {
        ASSERT_NE(state_.socket, nullptr);
        EXPECT_TRUE(state_.socket->send(std::make_shared<const std::string>(std::move(words)), kind));
    }
    void leave() { client_.cancel(); }

    /// The received messages, in their order.
    const std::vector<std::string>& texts() const { return state_.texts; }
    const std::vector<std::string>& messages() const { return state_.binary; }
    /// The bytes of all binary messages.
    Bytes bytes() const {
        Bytes all;
        for (const std::string& message : state_.binary) all.insert(all.end(), message.begin(), message.end());
        return all;
    }

    std::optional<anogate::http::Outcome> ended;

private:
    struct State {
        anogate::http::WebSocket* socket = nullptr;
        std::vector<std::string> texts, binary;
    };
    class User final : public anogate::http::WebSocketUser {
    public:
        explicit User(State& state) : state_{state} {}
        ~User() override { state_.socket = nullptr; }
        void opened(anogate::http::WebSocket& socket) override { state_.socket = &socket; }
        void heard(std::string_view message, anogate::http::WebSocket::Kind kind) override {
            (kind == anogate::http::WebSocket::Kind::text ? state_.texts : state_.binary).emplace_back(message);
        }

    private:
        State& state_;
    };

    State state_;
    anogate::http::Client client_;
};

}    // namespace support
