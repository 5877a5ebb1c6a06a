#include <devices/line_stream.hpp>
#include <http/producer.hpp>
#include <http/web_socket.hpp>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>

namespace anogate {
namespace {

constexpr std::string_view ndjson = "application/x-ndjson";
constexpr std::size_t part_size = std::size_t{16} * 1024;    // bytes between two turns of the loop

}    // namespace

/// A place among the clients, held while it is open.
class LineClient {
public:
    explicit LineClient(LineClients& clients) : clients_{clients} { clients_.wakes_.push_back(&wake); }
    ~LineClient() { std::erase(clients_.wakes_, &wake); }
    LineClient(const LineClient&) = delete;
    LineClient& operator=(const LineClient&) = delete;

    std::function<void()> wake = [] {};

private:
    LineClients& clients_;
};

namespace {

class LineProducer final : public http::Producer {
public:
    LineProducer(LineClients& clients, NextLine next) : client_{clients}, next_{std::move(next)} {}

    void start(std::function<void()> wake) override { client_.wake = std::move(wake); }
    Next next(std::string& into) override {
        while (into.size() < part_size) {
            const std::string line = next_();
            if (line.empty()) return Next::later;
            into.append(line).append("\n");
        }
        return Next::part;
    }

private:
    LineClient client_;
    NextLine next_;
};

class LineSocket final : public http::WebSocketUser {
public:
    LineSocket(LineClients& clients, NextLine next) : client_{clients}, next_{std::move(next)} {
        client_.wake = [this] {
            if (socket_ != nullptr && socket_->waiting() == 0) socket_->attempt([this] { send(); });
        };
    }
    void opened(http::WebSocket& socket) override {
        socket_ = &socket;
        send();
    }
    void heard(std::string_view, http::WebSocket::Kind) override {}    // the client only receives
    void sent_all() override { send(); }

private:
    void send() {
        while (socket_->waiting() < part_size) {
            std::string line = next_();
            if (line.empty()) return;
            if (!socket_->send(std::make_shared<const std::string>(std::move(line)), http::WebSocket::Kind::text)) return;
        }
    }

    LineClient client_;
    NextLine next_;
    http::WebSocket* socket_ = nullptr;    // nullptr: not open yet
};

}    // namespace

// A client may disconnect while others are woken.
void LineClients::wake() const {
    const auto all = wakes_;
    for (const auto* one : all)
        if (std::find(wakes_.begin(), wakes_.end(), one) != wakes_.end()) (*one)();
}

bool requests_lines(const http::Request& request) {
    return http::is_web_socket(request) || request.header("Accept").find(ndjson) != std::string_view::npos;
}

http::Response line_stream(LineClients& clients, NextLine next, const http::Request& request) {
    http::Response response;
    if (http::is_web_socket(request)) {
        response.web_socket = std::make_unique<LineSocket>(clients, std::move(next));
        return response;
    }
    response.type = ndjson;
    response.producer = std::make_unique<LineProducer>(clients, std::move(next));
    return response;
}

}    // namespace anogate
