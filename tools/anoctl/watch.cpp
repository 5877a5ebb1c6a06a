#include "watch.hpp"

#include "gateway.hpp"

#include <gateway/frame_record.hpp>
#include <http/client/client.hpp>
#include <sys/asio.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
namespace http = anogate::http;
using anogate::FrameRecord;
using Notice = nlohmann::json;

constexpr auto flush_time = std::chrono::milliseconds{250};

// Names for the numbers in records; the gateway sends them in text messages.
class Names {
public:
    void set(const Notice& list) {
        names_.clear();
        if (!list.is_array()) return;
        for (const Notice& name : list) names_.push_back(name.is_string() ? name.get<std::string>() : "");
    }
    std::string of(std::size_t number) const { return number < names_.size() ? names_[number] : ""; }

private:
    std::vector<std::string> names_;
};

class FrameWatcher {
public:
    FrameWatcher(const std::string& socket, FrameReceiver& receiver) : receiver_{receiver}, client_{io_, socket} {}

    std::string run(const std::string& query, std::optional<ano::Duration> time) {
        asio::signal_set signals{io_, SIGINT, SIGTERM};
        asio::steady_timer timer{io_};
        const auto stop = [this](anogate::error_code ec, auto...) {
            if (!ec) io_.stop();
        };
        signals.async_wait(stop);
        if (time) {
            timer.expires_after(*time);
            timer.async_wait(stop);
        }
        tick();
        http::Request request;
        request.method = "GET";
        request.target = "/frames?format=binary" + query;
        client_.open(std::move(request), std::make_unique<User>(*this), [this](http::Outcome outcome) {
            outcome_ = std::move(outcome);
            io_.stop();
        });
        io_.run();
        client_.cancel();
        if (!outcome_) return {};
        if (outcome_->answer.status != 101) {
            if (outcome_->answer.status == 400) throw UsageError{format_failure(outcome_->answer)};
            throw Failure{outcome_->answer.status == 0 ? outcome_->fault : format_failure(outcome_->answer)};
        }
        return outcome_->fault.empty() ? "the gateway stopped" : outcome_->fault;
    }

private:
    class User final : public http::WebSocketUser {
    public:
        explicit User(FrameWatcher& watcher) : watcher_{watcher} {}
        void opened(http::WebSocket&) override {}
        void heard(std::string_view message, http::WebSocket::Kind kind) override {
            if (watcher_.done_) return;
            if (kind == http::WebSocket::Kind::text) watcher_.receive_text(message);
            else watcher_.accept(message);
            if (!watcher_.receiver_.flush()) watcher_.finish();
        }

    private:
        FrameWatcher& watcher_;
    };

    // A text message contains the names for the numbers, or the number of lost frames.
    void receive_text(std::string_view text) {
        const Notice notice = Notice::parse(text, nullptr, false);
        if (!notice.is_object()) return;
        if (notice.contains("lost") && notice["lost"].is_object()) return report_lost(notice, text);
        links_.set(notice.value("links", Notice{}));
        peers_.set(notice.value("channels", Notice{}));
        causes_.set(notice.value("causes", Notice{}));
        if (!notice.contains("decoding")) return;    // older gateways don't send it
        if (const auto decoding = anogate::Decoding::parse(notice["decoding"].dump())) receiver_.use(decoding);
    }

    void report_lost(const Notice& notice, std::string_view text) {
        std::string words;
        std::uint64_t count = 0;
        for (const auto& [name, number] : notice["lost"].items()) {
            if (!number.is_number_unsigned()) continue;
            words += (words.empty() ? "" : ", ") + name + " " + number.dump();
            count += number.get<std::uint64_t>();
        }
        receiver_.miss(count, words, text);
    }

    void accept(std::string_view records) {
        while (const auto record = anogate::next_record(records)) {
            const std::uint64_t microseconds = record->time_ns / 1000;
            anoctl::Passage passage{links_.of(record->link), static_cast<double>(microseconds) / 1e6};
            passage.time_ns = record->time_ns;
            passage.boottime_ns = record->boottime_ns;
            if (record->channel != FrameRecord::no_channel) {
                passage.channel = record->channel;
                passage.peer = peers_.of(record->channel);
            }
            passage.direction = text(record->direction);
            passage.is_elsewhere = record->is_elsewhere;
            if (record->direction == anogate::Direction::dropped) passage.cause = causes_.of(record->cause);
            if (!receiver_.accept(record->frame, passage)) return finish();
        }
    }

    // Flushes pending output even if no more frames arrive.
    void tick() {
        tick_.expires_after(flush_time);
        tick_.async_wait([this](anogate::error_code ec) {
            if (ec || done_) return;
            if (!receiver_.flush()) return finish();
            tick();
        });
    }

    void finish() {
        done_ = true;
        io_.stop();
    }

    FrameReceiver& receiver_;
    Names links_, peers_, causes_;
    bool done_ = false;
    asio::io_context io_{1};
    asio::steady_timer tick_{io_};
    http::Client client_;
    std::optional<http::Outcome> outcome_;
};

class Watched final : public FrameReceiver {
public:
    Watched(const Watching& watching, Streams& streams)
        : watching_{watching}, streams_{streams}, printer_{streams, watching.frames} {}

    bool accept(ano::FrameView frame, const Passage& passage) override {
        printer_.print(frame, passage);
        return ++shown_ != watching_.count;
    }
    void use(const anogate::DecodingPtr& decoding) override { printer_.use(decoding); }
    bool flush() override { return bool{streams_.out.flush()}; }
    void miss(std::uint64_t count, const std::string& names, std::string_view json) override {
        lost_ += count;
        if (watching_.frames.json) {
            streams_.out << json << '\n';
            return;
        }
        streams_.out.flush();
        streams_.err << "anoctl: " << count << " frames not shown, the buffer of the gateway was full: " << names << std::endl;
    }
    void sum_up() {
        streams_.out.flush();
        streams_.err << "anoctl: " << shown_ << (shown_ == 1 ? " frame" : " frames") << " shown";
        if (lost_ > 0) streams_.err << ", " << lost_ << " not shown: the buffer of the gateway was full";
        streams_.err << '\n';
    }

private:
    const Watching& watching_;
    Streams& streams_;
    FramePrinter printer_;
    std::uint64_t shown_ = 0, lost_ = 0;
};

}    // namespace

std::string watch_frames(const std::string& socket, const std::string& query, FrameReceiver& receiver,
                         std::optional<ano::Duration> time) {
    return FrameWatcher{socket, receiver}.run(query, time);
}

int watch(const Watching& watching, Streams& streams) {
    Watched watched{watching, streams};
    const std::string why = watch_frames(watching.socket, watching.query, watched);
    watched.sum_up();
    if (!why.empty()) throw Failure{why};
    return fine;
}

std::string filter_words(const std::string& name, const std::vector<std::string>& words) {
    constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string all;
    for (const std::string& word : words) {
        all += all.empty() ? "&" + name + "=" : ",";
        for (const char c : word) {
            const auto byte = static_cast<unsigned char>(c);
            if (plain.find(c) != plain.npos) all += c;
            else all.append({'%', digits[byte >> 4], digits[byte & 15]});
        }
    }
    return all;
}

}    // namespace anoctl
