#include <client/gateway_requests.hpp>
#include <client/gateway_socket.hpp>

#include <utility>

namespace anogate {

GatewayRequests::GatewayRequests(asio::io_context& io, std::string control, std::string program)
    : io_{io}, control_{std::move(control)}, program_{std::move(program)} {}

bool GatewayRequests::ask(std::string method, std::string target, std::string body, ano::Duration patience, Done done) {
    if (waiting_.size() == max_waiting) return false;
    Waiting waiting{{}, patience, std::move(done)};
    waiting.request.method = std::move(method);
    waiting.request.target = std::move(target);
    waiting.request.headers.push_back({"User-Agent", program_});
    waiting.request.body = std::move(body);
    waiting_.push_back(std::move(waiting));
    run();
    return true;
}

void GatewayRequests::run() {
    for (auto& client : clients_) {
        if (waiting_.empty()) return;
        if (client) continue;
        Waiting next = std::move(waiting_.front());
        waiting_.pop_front();
        client = std::make_unique<http::Client>(io_, gateway_socket_path(control_),
                                                http::ClientLimits{.patience = next.patience});
        client->ask(std::move(next.request), [this, &client, done = std::move(next.done)](const http::Outcome& outcome) {
            const Done call = done;    // this function is destroyed with its client
            client.reset();
            call(outcome);
            run();
        });
    }
}

}    // namespace anogate
