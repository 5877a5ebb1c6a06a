// anoctl top: the channels and addresses of the running gateway on a live screen.
#include <anoctl/text/terminal.hpp>
#include <anoctl/text/top_screen.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano/time.hpp>
#include <gateway/frame_record.hpp>
#include <http/asio.hpp>
#include <http/client/client.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>

#include <array>
#include <csignal>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
namespace http = anogate::http;
using anogate::error_code;

constexpr auto refresh = std::chrono::seconds{1};

http::Request get(std::string target) {
    http::Request request;
    request.method = "GET";
    request.target = std::move(target);
    return request;
}

class Top {
public:
    explicit Top(const std::string& socket) : status_{io_, socket}, frames_{io_, socket} {
        keys_.assign(::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC));    // not shared: Asio makes it non-blocking
        signals_.add(SIGQUIT);
        signals_.add(SIGWINCH);
        signals_.add(SIGTSTP);
    }

    /// Runs until the user quits or an error occurs. Returns the error, or empty.
    std::string run() {
        await_signal();
        await_key();
        ask();
        frames_.open(get("/frames?format=binary&direction=in&elsewhere=no"), std::make_unique<Counter>(heard_),
                     [](const http::Outcome&) {});    // if this fails, the rates of addresses are 0
        io_.run();
        screen_.reset();
        status_.cancel();
        frames_.cancel();
        return fault_;
    }

private:
    // Counts frames by their source.
    class Counter final : public http::WebSocketUser {
    public:
        explicit Counter(HeardFrames& heard) : heard_{heard} {}
        void opened(http::WebSocket&) override {}
        void heard(std::string_view message, http::WebSocket::Kind kind) override {
            if (kind == http::WebSocket::Kind::binary)
                while (const auto record = anogate::next_record(message)) ++heard_[record->frame.source()];
        }

    private:
        HeardFrames& heard_;
    };

    void ask() {
        status_.ask(get("/status"), [this](const http::Outcome& outcome) {
            if (!outcome.fault.empty()) return end(outcome.fault);
            if (outcome.answer.status != 200) return end(format_failure(outcome.answer));
            look(nlohmann::json::parse(outcome.answer.body, nullptr, false));
            timer_.expires_after(refresh);
            timer_.async_wait([this](error_code ec) {
                if (!ec) ask();
            });
        });
    }

    void look(nlohmann::json status) {
        const ano::TimePoint now = ano::Clock::now();
        const double seconds = looked_at_ == ano::TimePoint{} ? 0 : std::chrono::duration<double>(now - looked_at_).count();
        view_ = top_view(before_, status, seconds, heard_);
        heard_ = {};
        looked_at_ = now;
        before_ = std::move(status);
        if (!screen_) screen_.emplace();    // not created before the first response
        show();
    }

    void show() {
        if (!screen_) return;
        const Screen::Size size = Screen::size();
        sort(view_, sort_);
        if (!Screen::show(top_screen(view_, sort_, size.width, size.height))) end("the terminal was closed");
    }

    void await_key() {
        keys_.async_read_some(asio::buffer(key_), [this](error_code ec, std::size_t size) {
            if (ec) return end(ec == asio::error::operation_aborted ? "" : "the terminal was closed");
            for (const char key : std::string_view{key_.data(), size}) {
                if (key == 'q' || key == 'Q' || key == '\x03') return end({});
                if (key == 's' || key == 'S') sort_ = next(sort_);
            }
            show();
            await_key();
        });
    }

    void await_signal() {
        signals_.async_wait([this](error_code ec, int signal) {
            if (ec) return;
            if (signal == SIGTSTP) {
                if (screen_) screen_->leave();
                ::raise(SIGSTOP);
                if (screen_) screen_->enter();
            } else if (signal != SIGWINCH) {
                return end({});
            }
            show();
            await_signal();
        });
    }

    void end(std::string fault) {
        if (fault_.empty()) fault_ = std::move(fault);
        io_.stop();
    }

    asio::io_context io_{1};
    asio::steady_timer timer_{io_};
    asio::posix::stream_descriptor keys_{io_};
    asio::signal_set signals_{io_, SIGINT, SIGTERM, SIGHUP};
    std::array<char, 16> key_{};
    http::Client status_, frames_;
    std::optional<Screen> screen_;
    nlohmann::json before_;
    ano::TimePoint looked_at_{};
    HeardFrames heard_{};
    TopView view_;
    TopSort sort_ = TopSort::name;
    std::string fault_;
};

}    // namespace

Run add_top(Options& options) {
    const auto self = std::make_shared<GatewayOptions>();
    GatewayOptions::add(options, *self);
    return [self](Streams&) {
        if (!is_screen()) throw Failure{"top requires a terminal; for a single snapshot: anoctl status"};
        if (const std::string fault = Top{self->socket()}.run(); !fault.empty()) throw Failure{fault};
        return fine;
    };
}

}    // namespace anoctl
