#include <config/link_kind.hpp>
#include <control/watch_session.hpp>
#include <http/producer.hpp>
#include <http/web_socket.hpp>
#include <record/sender_encodings.hpp>
#include <runtime/gateway.hpp>
#include <watch/record_json.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t part_size = 16 * 1024;    // bytes of JSON made between two turns of the loop

// Creates lines of JSON only when the watcher reads them, so that unread frames cost no time.
class JsonLines {
public:
    explicit JsonLines(WatchQueue& queue) : queue_{queue} {}

    /// The next line; empty: none is waiting.
    std::string next() {
        while (true) {
            if (const auto record = next_record(rest_)) return line_of(*record);
            auto item = queue_.next(Clock::now());
            if (!item) return {};
            if (auto* lost = std::get_if<LostFrames>(&*item)) return lost_json(*lost);
            if (auto* tables = std::get_if<WatchQueue::Tables>(&*item)) tables_ = std::move(*tables);
            else batch_ = std::move(std::get<WatchQueue::Batch>(*item));
            rest_ = batch_ ? std::string_view{*batch_} : std::string_view{};
        }
    }

private:
    std::string line_of(const FrameRecord& record) {
        const std::string_view link = record.link < tables_->links.size() ? std::string_view{tables_->links[record.link]} : "";
        const bool is_received = record.direction == Direction::in;
        return record_json(record, *tables_, tables_->decoding->layouts(),
                           encodings_.of(record.frame, link, is_received, tables_->decoding.get()));
    }

    WatchQueue& queue_;
    SenderEncodings encodings_;
    WatchQueue::Tables tables_;
    WatchQueue::Batch batch_;
    std::string_view rest_;    // the unread part of the batch
};

// A watcher by WebSocket. It gets the next item when it has read everything before.
class WatchSocket : public http::WebSocketUser, protected Watcher {
public:
    WatchSocket(FrameWatch& watch, FrameFilterSettings settings) : watch_{watch}, settings_{std::move(settings)} {}
    ~WatchSocket() override {
        if (socket_) watch_.remove(*this);
    }
    void opened(http::WebSocket& socket) override {
        socket_ = &socket;
        watch_.add(*this, settings_);
    }
    void heard(std::string_view, http::WebSocket::Kind) override {}    // messages of the client are ignored
    void sent_all() override { send_next_part(); }

protected:
    /// Sends the next item. False: none is waiting.
    virtual bool send_next(http::WebSocket& socket) = 0;

private:
    void more() override {
        if (socket_->waiting() == 0) socket_->attempt([this] { send_next_part(); });
    }
    void send_next_part() {
        while (socket_->waiting() < part_size && send_next(*socket_)) {}
    }

    FrameWatch& watch_;
    FrameFilterSettings settings_;
    http::WebSocket* socket_ = nullptr;    // nullptr: not open
};

using Kind = http::WebSocket::Kind;

class BinaryWatchSocket final : public WatchSocket {
    using WatchSocket::WatchSocket;

    bool send_next(http::WebSocket& socket) override {
        auto item = queue.next(Clock::now());
        if (!item) return false;
        if (auto* batch = std::get_if<WatchQueue::Batch>(&*item)) return socket.send(std::move(*batch), Kind::binary);
        const auto* lost = std::get_if<LostFrames>(&*item);
        const std::string& text = lost ? lost_json(*lost) : std::get<WatchQueue::Tables>(*item)->text;
        return socket.send(std::make_shared<const std::string>(text), Kind::text);
    }
};

class JsonWatchSocket final : public WatchSocket {
public:
    JsonWatchSocket(FrameWatch& watch, FrameFilterSettings settings) : WatchSocket{watch, std::move(settings)}, lines_{queue} {}

private:
    bool send_next(http::WebSocket& socket) override {
        std::string line = lines_.next();
        return !line.empty() && socket.send(std::make_shared<const std::string>(std::move(line)), Kind::text);
    }

    JsonLines lines_;
};

// A watcher by an endless response with lines.
class WatchLines final : public http::Producer, private Watcher {
public:
    WatchLines(FrameWatch& watch, FrameFilterSettings settings) : watch_{watch}, settings_{std::move(settings)}, lines_{queue} {}
    ~WatchLines() override {
        if (wake_) watch_.remove(*this);
    }
    void start(std::function<void()> wake) override {
        wake_ = std::move(wake);
        watch_.add(*this, settings_);
    }
    Next next(std::string& into) override {
        while (into.size() < part_size) {
            const std::string line = lines_.next();
            if (line.empty()) return Next::later;
            into.append(line).append("\n");
        }
        return Next::part;
    }

private:
    void more() override { wake_(); }

    FrameWatch& watch_;
    FrameFilterSettings settings_;
    JsonLines lines_;
    std::function<void()> wake_;
};

}    // namespace

FrameStreams::FrameStreams(const Gateway& gateway, FrameWatch& watch) : gateway_{gateway}, watch_{watch} {}

http::Response FrameStreams::answer(const http::Request& request) {
    std::vector<std::string_view> links{"control"};    // it may be created later
    for (const LinkState& state : gateway_.links()) links.push_back(state.link->name());
    auto parsed = parse_frame_query(request.query, links);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return http::error(400, *wrong);
    FrameQuery& query = std::get<FrameQuery>(parsed);
    http::Response response;
    if (!http::is_web_socket(request)) {
        if (query.format == FrameFormat::binary) return http::error(400, "format=binary needs a WebSocket; lines are JSON");
        response.type = "application/x-ndjson";
        response.producer = std::make_unique<WatchLines>(watch_, std::move(query.filter));
    } else if (query.format == FrameFormat::binary) {
        response.web_socket = std::make_unique<BinaryWatchSocket>(watch_, std::move(query.filter));
    } else {
        response.web_socket = std::make_unique<JsonWatchSocket>(watch_, std::move(query.filter));
    }
    return response;
}

}    // namespace anogate
