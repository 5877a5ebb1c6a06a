#include "page_reader.hpp"

#include "traffic_ends.hpp"

#include <support/http.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

// As in live/liveness.ts and live/gateway.ts.
constexpr auto beat = 100ms;
constexpr auto ask_every = 400ms;
constexpr auto ask_at_least_every = 3000ms;    // by the page Charts
constexpr auto status_every = ask_at_least_every - beat;
constexpr auto devices_every = 2000ms;

std::string headers(std::uint16_t port, const std::string& token) {
    const std::string own = "127.0.0.1:" + std::to_string(port);
    std::string all =
        " HTTP/1.1\r\nHost: " + own +
        "\r\nPragma: no-cache\r\nCache-Control: no-cache\r\n"
        "sec-ch-ua-platform: \"Linux\"\r\nUser-Agent: Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 (KHTML, like "
        "Gecko) Chrome/140.0.0.0 Safari/537.36\r\nAccept: application/json\r\n"
        "sec-ch-ua: \"Chromium\";v=\"140\", \"Not=A?Brand\";v=\"24\"\r\nsec-ch-ua-mobile: ?0\r\n"
        "Sec-Fetch-Site: same-origin\r\nSec-Fetch-Mode: cors\r\nSec-Fetch-Dest: empty\r\nReferer: http://" +
        own + "/\r\nAccept-Encoding: gzip, deflate, br, zstd\r\nAccept-Language: en-US,en;q=0.9\r\n";
    if (!token.empty()) all += "Cookie: anogate-" + std::to_string(port) + "=" + token + "\r\n";
    return all;
}

void send(int fd, const std::string& words) {
    must(fd >= 0 && ::send(fd, words.data(), words.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(words.size()), "a request");
}

}    // namespace

PageReader::PageReader(std::uint16_t port, const std::string& token)
    : headers_{headers(port, token)}, frames_{support::connect_tcp(port)}, requests_{support::connect_tcp(port)} {
    send(frames_, "GET /frames?format=binary&batch=100ms&from=48&id=241&direction=in" + headers_ +
                      "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                      "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n");
    std::array<char, 12> status{};
    must(::recv(frames_, status.data(), status.size(), MSG_WAITALL) == static_cast<ssize_t>(status.size()) &&
             std::string{status.data(), status.size()} == "HTTP/1.1 101",
         "a WebSocket");
    listens_ = std::thread{[this] { read_frames(); }};
    asks_ = std::thread{[this] { ask_for_more(); }};
}

PageReader::~PageReader() {
    stop_ = true;
    ::shutdown(frames_, SHUT_RDWR);
    asks_.join();
    listens_.join();
    ::close(requests_);
    ::close(frames_);
}

void PageReader::read_frames() {
    std::vector<char> room(1 << 20);
    while (!stop_ && ::read(frames_, room.data(), room.size()) > 0) heard_at_ = steady_clock::now();
}

void PageReader::ask_for_more() {
    Time asked_at{}, status_at{}, devices_at{};
    for (Time now = steady_clock::now(); !stop_; std::this_thread::sleep_until(now += beat)) {
        const bool is_silent = now - std::max(asked_at, heard_at_.load()) >= ask_every;
        if (!is_silent && now - asked_at < ask_at_least_every) continue;
        asked_at = now;
        const bool wants_status = now - status_at >= status_every;
        ask(wants_status ? "/status" : "/jobs");
        if (!wants_status) continue;
        status_at = now;
        if (now - devices_at < devices_every) continue;
        devices_at = now;
        ask("/devices");
    }
}

void PageReader::ask(std::string_view path) {
    send(requests_, "GET " + std::string{path} + headers_ + "Connection: keep-alive\r\n\r\n");
    std::string answer;
    std::size_t size = std::string::npos;
    std::array<char, 64 * 1024> room;
    while (answer.size() < size) {
        const ssize_t count = ::read(requests_, room.data(), room.size());
        must(count > 0, "an answer");
        answer.append(room.data(), static_cast<std::size_t>(count));
        const auto end = answer.find("\r\n\r\n");
        constexpr std::string_view length = "Content-Length: ";
        if (end != std::string::npos) size = end + 4 + std::stoul(answer.substr(answer.find(length) + length.size()));
    }
    heard_at_ = steady_clock::now();
}

}    // namespace bench
