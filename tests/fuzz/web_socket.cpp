// The bytes that a client sends on a WebSocket: it ends in order, and the received messages do not depend on how the bytes were
// split.
#include <sys/asio.hpp>

#include <http/open_web_socket.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace {

using namespace anogate::http;
namespace asio = anogate::asio;
using anogate::error_code;

void require(bool holds) {
    if (!holds) std::abort();
}

constexpr std::size_t longest = 1024;

struct Heard {
    std::string all;
    bool gone = false;
};

// Delivers the bytes piece by piece, then the end; accepts all output.
class Given final : public Stream {
public:
    Given(asio::io_context& io, std::string_view bytes, std::size_t step) : io_{io}, bytes_{bytes}, step_{step} {}

    void read_some(asio::mutable_buffer into, Done done) override {
        const std::size_t size = closed_ ? 0 : std::min({into.size(), bytes_.size(), step_});
        if (size > 0) std::memcpy(into.data(), bytes_.data(), size);
        bytes_.remove_prefix(size);
        asio::post(io_, [done = std::move(done), size] { done(size == 0 ? asio::error::eof : error_code{}, size); });
    }
    void write_some(const Parts& from, Done done) override {
        std::size_t size = 0;
        for (const asio::const_buffer& part : from) size += part.size();
        asio::post(io_, [done = std::move(done), size] { done({}, size); });
    }
    void cancel() override {}
    void end_output() override {}
    void close() override { closed_ = true; }
    std::uint32_t user() const override { return unknown_user; }
    const ConnectionInfo& connection_info() const override { return door_; }

private:
    asio::io_context& io_;
    std::string_view bytes_;
    std::size_t step_;
    bool closed_ = false;
    ConnectionInfo door_;
};

// Sends every message back.
class Listener final : public WebSocketUser {
public:
    explicit Listener(Heard& heard) : heard_{heard} {}
    ~Listener() override { heard_.gone = true; }
    void opened(WebSocket& socket) override { socket_ = &socket; }
    void heard(std::string_view message, WebSocket::Kind kind) override {
        require(message.size() <= longest);
        heard_.all.append(kind == WebSocket::Kind::text ? "t" : "b").append(std::to_string(message.size())).append(message);
        socket_->send(std::make_shared<const std::string>(message), kind);
    }

private:
    Heard& heard_;
    WebSocket* socket_ = nullptr;
};

std::string heard(std::string_view bytes, std::size_t step) {
    asio::io_context io{1};
    Request request;
    request.method = "GET";
    request.target = "/link";
    request.headers = {{"Host", "x"},
                       {"Connection", "Upgrade"},
                       {"Upgrade", "websocket"},
                       {"Sec-WebSocket-Version", "13"},
                       {"Sec-WebSocket-Key", "MDEyMzQ1Njc4OWFiY2RlZg=="}};
    Heard result;
    {
        const auto socket = open_web_socket(io, std::make_unique<Given>(io, bytes, step), request, {},
                                            std::make_unique<Listener>(result), {.message = longest, .queue = 4096}, nullptr);
    }
    for (int turns = 0; !result.gone; ++turns) {
        require(turns < 1'000'000);
        require(io.run_one() > 0);
    }
    return result.all;
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes{reinterpret_cast<const char*>(data), size};
    const std::string whole = heard(bytes, std::max<std::size_t>(size, 1));
    for (const std::size_t step : {1u, 7u}) require(heard(bytes, step) == whole);
    return 0;
}
