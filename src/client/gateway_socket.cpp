#include <client/gateway_socket.hpp>
#include <http/socket_path.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <utility>

namespace anogate {
namespace {

constexpr unsigned switching_protocols = 101;

}    // namespace

class GatewaySocket::User final : public http::WebSocketUser {
public:
    explicit User(GatewaySocket& owner) : owner_{owner} {}
    ~User() override { owner_.socket_ = nullptr; }

    void opened(http::WebSocket& socket) override {
        owner_.socket_ = &socket;
        owner_.backoff_.came_up(ano::Clock::now());
        owner_.reported_ = false;
        owner_.events_.opened();
    }
    void heard(std::string_view message, http::WebSocket::Kind kind) override {
        if (!owner_.stopped_) owner_.events_.received(message, kind);
    }

private:
    GatewaySocket& owner_;
};

GatewaySocket::GatewaySocket(asio::io_context& io, std::string control, std::string target, Events events)
    : io_{io}, control_{std::move(control)}, target_{std::move(target)}, events_{std::move(events)}, retry_{io} {}

void GatewaySocket::start() {
    stopped_ = false;
    open();
}

void GatewaySocket::stop() {
    stopped_ = true;
    retry_.cancel();
    client_.reset();
}

bool GatewaySocket::send(std::string message) {
    return socket_ != nullptr &&
           socket_->send(std::make_shared<const std::string>(std::move(message)), http::WebSocket::Kind::binary);
}

void GatewaySocket::open() {
    http::Request request;
    request.method = "GET";
    request.target = target_;
    client_ = std::make_unique<http::Client>(io_, gateway_socket_path(control_));
    client_->open(std::move(request), std::make_unique<User>(*this), [this](const http::Outcome& outcome) { ended(outcome); });
}

void GatewaySocket::ended(const http::Outcome& outcome) {
    if (stopped_) return;
    retry_.expires_at(backoff_.retry_at(ano::Clock::now()));
    retry_.async_wait([this](error_code ec) {
        if (!ec && !stopped_) open();
    });
    if (std::exchange(reported_, true)) return;
    events_.closed(fault_of(outcome));
}

std::string gateway_socket_path(const std::string& control) { return http::socket_to_ask(control, http::this_runner()); }

std::string fault_of(const http::Outcome& outcome) {
    if (outcome.answer.status == switching_protocols) return outcome.fault.empty() ? "the gateway stopped" : outcome.fault;
    if (outcome.answer.status == 0) return outcome.fault;
    const auto json = nlohmann::json::parse(outcome.answer.body, nullptr, false);
    if (json.is_object() && json.contains("error") && json["error"].is_string()) return json["error"].get<std::string>();
    return "the gateway returned HTTP status " + std::to_string(outcome.answer.status);
}

}    // namespace anogate
