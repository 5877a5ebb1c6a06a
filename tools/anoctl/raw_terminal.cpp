// anoctl terminal LINK: shows the raw bytes of a link of the gateway in both directions, and sends typed lines.
#include <anoctl/recording/v7_capture.hpp>
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/raw_text.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"
#include "say.hpp"

#include <ano/hex.hpp>
#include <ano_json/escapes.hpp>
#include <http/client/client.hpp>
#include <sys/asio.hpp>
#include <sys/thread_signals.hpp>
#include <sys/unique_fd.hpp>

#include <nlohmann/json.hpp>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <ostream>
#include <thread>
#include <utility>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
namespace http = anogate::http;

/// Reads lines in a thread, because a descriptor shared with the shell must not be made non-blocking, and may be a file.
class Lines {
public:
    /// From `io`, `accept` is called for each line, without its line end, and `end` at the end of the input.
    Lines(asio::io_context& io, int fd, std::function<void(std::string)> accept, std::function<void()> end)
        : io_{io},
          fd_{fd},
          accept_{std::move(accept)},
          end_{std::move(end)},
          stop_{::eventfd(0, EFD_CLOEXEC)},
          thread_{anogate::begin_thread([this] { read(); })} {}
    ~Lines() {
        ::eventfd_write(stop_.get(), 1);
        thread_.join();
    }
    Lines(const Lines&) = delete;
    Lines& operator=(const Lines&) = delete;

private:
    void read() {
        std::string line;
        std::array<char, 4096> bytes;
        for (;;) {
            pollfd fds[] = {{fd_, POLLIN, 0}, {stop_.get(), POLLIN, 0}};
            if (::poll(fds, 2, -1) < 0 && errno != EINTR) break;
            if (fds[1].revents != 0) return;
            if (fds[0].revents == 0) continue;
            const ssize_t n = ::read(fd_, bytes.data(), bytes.size());
            if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
            if (n <= 0) break;
            for (const char c : std::string_view{bytes.data(), static_cast<std::size_t>(n)}) {
                if (c != '\n') {
                    line += c;
                    continue;
                }
                if (line.ends_with('\r')) line.pop_back();    // of a file from Windows
                asio::post(io_, [this, whole = std::exchange(line, {})]() mutable { accept_(std::move(whole)); });
            }
        }
        asio::post(io_, [this, whole = std::move(line)]() mutable {
            if (!whole.empty()) accept_(std::move(whole));
            end_();
        });
    }

    asio::io_context& io_;
    int fd_;
    std::function<void(std::string)> accept_;
    std::function<void()> end_;
    anogate::UniqueFd stop_;
    std::thread thread_;
};

constexpr auto time_for_answers = std::chrono::milliseconds{500};    // time after the end of the input

struct TerminalOptions {
    std::string link;
    bool hex = false, exclusive = false, json = false;
    bool v7 = false;                          // shows frames of protocol version 7 instead of text
    std::string pcapng;                       // writes them to this file instead; "-": standard output
    bool force = false;                       // may overwrite it
    std::optional<ano::Encoding> encoding;    // std::nullopt: the encoding of the link
    std::string line_end = "\r\n";
    GatewayOptions gateway;
};

FrameOptions printing(const TerminalOptions& options) {
    FrameOptions frames;
    frames.json = options.json;
    frames.encoding = options.encoding;
    return frames;
}

class RawTerminal {
public:
    RawTerminal(const TerminalOptions& options, Streams& streams)
        : options_{options},
          streams_{streams},
          text_{{options.hex, options.encoding.value_or(ano::Encoding::utf8)}},
          printer_{streams, printing(options)} {
        if (!options.pcapng.empty()) capture_.emplace(options.pcapng, options.force, options.link, streams);
    }

    int run() {
        asio::signal_set signals{io_, SIGINT, SIGTERM};
        signals.async_wait([this](anogate::error_code ec, int) {
            if (!ec) io_.stop();
        });
        http::Client client{io_, options_.gateway.socket()};
        http::Request request;
        request.method = "GET";
        request.target = "/links/" + percent_encoded(options_.link) + "/raw" + (options_.exclusive ? "?exclusive" : "");
        std::optional<http::Outcome> outcome;
        client.open(std::move(request), std::make_unique<User>(*this), [&](http::Outcome came) {
            outcome = std::move(came);
            io_.stop();
        });
        io_.run();
        lines_.reset();
        client.cancel();
        show_unfinished();
        streams_.out.flush();
        if (capture_ && !capture_->fault().empty()) throw Failure{options_.pcapng + ": cannot write: " + capture_->fault()};
        if (!outcome) return fine;
        if (outcome->answer.status != 101)
            throw Failure{outcome->answer.status == 0 ? outcome->fault : format_failure(outcome->answer)};
        throw Failure{outcome->fault.empty() ? "the gateway stopped" : outcome->fault};
    }

private:
    class User final : public http::WebSocketUser {
    public:
        explicit User(RawTerminal& terminal) : terminal_{terminal} {}
        ~User() override { terminal_.socket_ = nullptr; }
        void opened(http::WebSocket& socket) override { terminal_.socket_ = &socket; }
        void heard(std::string_view message, http::WebSocket::Kind kind) override {
            if (kind == http::WebSocket::Kind::text) terminal_.receive_text(message);
            else terminal_.accept(message);
            terminal_.show_later();
            if (!terminal_.streams_.out.flush()) terminal_.io_.stop();
        }

    private:
        RawTerminal& terminal_;
    };

    void receive_text(std::string_view message) {
        const auto notice = nlohmann::json::parse(message, nullptr, false);
        if (!notice.is_object()) return;
        if (notice.contains("link")) return begin(notice);
        if (notice.contains("lost")) {
            const auto& lost = notice["lost"];
            return print_note(streams_,
                              plural(lost.value("received", std::size_t{0}) + lost.value("sent", std::size_t{0}), "byte") +
                                  " not shown: this terminal reads too slowly");
        }
        if (notice.contains("error") && notice["error"].is_string())
            print_note(streams_, without_controls(notice["error"].get<std::string>()));
    }
    void begin(const nlohmann::json& about) {
        if (!options_.encoding && about.value("encoding", "") == "gbk") encoding_ = ano::Encoding::gbk;
        else encoding_ = options_.encoding.value_or(ano::Encoding::utf8);
        text_ = RawText{{options_.hex, encoding_}};
        const bool may_send = about.value("may_send", false);
        const bool sends = may_send && !options_.v7 && !capture_;
        std::string words = options_.link + ": " +
                            (capture_      ? "writes the V7 frames to " + options_.pcapng
                             : options_.v7 ? std::string{"shows the V7 frames"}
                             : sends       ? std::string{"press Enter to send a line"}
                                           : std::string{"read only"});
        if (options_.exclusive) words += "; no frames are forwarded to it meanwhile";
        if (streams_.in_is_terminal) words += "; Ctrl-C exits";
        print_note(streams_, words);
        if (sends && !lines_)
            lines_ = std::make_unique<Lines>(
                io_, streams_.in, [this](const std::string& line) { send(line); }, [this] { end_soon(); });
    }
    // After the end of the input: waits until all lines are sent, and for an answer, for time_for_answers.
    void end_soon() {
        if (streams_.in_is_terminal) return io_.stop();
        last_lines_.expires_after(time_for_answers);
        last_lines_.async_wait([this](anogate::error_code ec) {
            if (ec) return;
            if (socket_ && socket_->waiting() > 0) return end_soon();
            io_.stop();
        });
    }
    void accept(std::string_view message) {
        constexpr std::size_t head = 9;
        if (message.size() < head) return;
        std::uint64_t ns = 0;
        for (std::size_t i = 8; i > 0; --i) ns = ns << 8 | static_cast<std::uint8_t>(message[i]);
        const double time = seconds_of(ns);
        const char direction = message[0];
        message.remove_prefix(head);
        if (options_.v7 || capture_)
            return show_v7(direction == '<' ? anogate::Direction::in : anogate::Direction::out, ns, message);
        if (!options_.json) return show(text_.add(direction, time, message, ano::Clock::now()));
        const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(message.data()), message.size()};
        streams_.out << ano::json_text(nlohmann::ordered_json{{"time", time},
                                                              {"direction", direction == '<' ? "in" : "out"},
                                                              {"bytes", ano::hex(bytes)},
                                                              {"text", ano::to_utf8(bytes, encoding_)}})
                     << '\n';
    }
    // Rounded to microseconds.
    static double seconds_of(std::uint64_t ns) {
        const std::uint64_t us = ns / 1000;
        return static_cast<double>(us) / 1e6;
    }
    void show_v7(anogate::Direction direction, std::uint64_t ns, std::string_view bytes) {
        ano::v7::FrameParser& parser = direction == anogate::Direction::in ? received_ : sent_;
        while (!bytes.empty()) {
            const auto room = parser.prepare();
            const std::size_t n = std::min(room.size(), bytes.size());
            std::copy_n(bytes.begin(), n, room.begin());
            parser.commit(n, ano::Clock::now());
            bytes.remove_prefix(n);
            while (const auto frame = parser.next()) {
                if (capture_) capture_->add(*frame, direction, ns);
                else
                    printer_.print(
                        *frame,
                        {.link = options_.link, .time = seconds_of(ns), .direction = std::string{anogate::text(direction)}});
            }
        }
        if (capture_ && !capture_->fault().empty()) io_.stop();
    }
    static constexpr std::size_t max_line = http::WebSocketLimits{}.message;    // a longer message would end the connection

    void send(const std::string& line) {
        if (!socket_) return;
        std::string bytes;
        if (options_.hex) {
            const auto read = ano::from_hex(line);
            if (!read) return print_note(streams_, "not sent: " + ano::in_quotes(line) + " is not hex digits");
            bytes.assign(read->begin(), read->end());
        } else {
            const auto written = ano::from_utf8(line, encoding_);
            if (!written)
                return print_note(streams_,
                                  "not sent: " + ano::in_quotes(line) + " cannot be represented in the encoding of the link");
            bytes = *written + options_.line_end;
        }
        if (bytes.size() > max_line)
            return print_note(streams_, "not sent: a line of " + std::to_string(bytes.size()) + " bytes is longer than " +
                                            std::to_string(max_line));
        if (!socket_->send(std::make_shared<const std::string>(std::move(bytes)), http::WebSocket::Kind::binary))
            print_note(streams_, "not sent: the gateway has not yet accepted earlier data");
    }

    void show(const std::vector<std::string>& lines) {
        for (const std::string& line : lines) streams_.out << line << '\n';
    }
    void show_unfinished() { show(text_.expire(ano::TimePoint::max())); }
    void show_later() {
        const auto due = text_.due();
        if (!due) return;
        unfinished_.expires_at(*due);
        unfinished_.async_wait([this](anogate::error_code ec) {
            if (ec) return;
            show(text_.expire(ano::Clock::now()));
            if (!streams_.out.flush()) io_.stop();
            show_later();
        });
    }

    const TerminalOptions& options_;
    Streams& streams_;
    RawText text_;
    ano::v7::FrameParser received_{{}}, sent_{{}};
    FramePrinter printer_;
    std::optional<V7Capture> capture_;
    ano::Encoding encoding_ = ano::Encoding::utf8;
    asio::io_context io_{1};
    asio::steady_timer unfinished_{io_};
    asio::steady_timer last_lines_{io_};
    http::WebSocket* socket_ = nullptr;
    std::unique_ptr<Lines> lines_;
};

std::string read_line_end(const std::string& word, std::string& end) {
    constexpr std::pair<std::string_view, std::string_view> ends[] = {{"crlf", "\r\n"}, {"lf", "\n"}, {"cr", "\r"}, {"none", ""}};
    for (const auto& [name, bytes] : ends)
        if (word == name) return end = bytes, std::string{};
    return ano::in_quotes(word) + " is not crlf, lf, cr or none";
}

}    // namespace

Run add_terminal(Options& options) {
    const auto self = std::make_shared<TerminalOptions>();
    options.push_back(
        {"link", &self->link, "LINK", "Name of a serial, hid, pty, udp, tcp or sim link of the running gateway", true});
    options.push_back({"--hex", &self->hex, "", "Show hex digits, and send lines of hex digits"});
    options.push_back(
        {"--v7", &self->v7, "", "Show the frames of protocol version 7 in the bytes, and nothing else", false, {"--hex"}});
    options.push_back({"--pcapng",
                       &self->pcapng,
                       "FILE",
                       "Write the frames of protocol version 7 to this file, for Wireshark; -: standard output",
                       false,
                       {"--hex", "--json"}});
    options.push_back({"--force", &self->force, "", "Overwrite an existing file"});
    options.push_back({"--encoding", Option::Read{[self](const std::string& word) -> std::string {
                           if (word != "utf8" && word != "gbk") return ano::in_quotes(word) + " is not utf8 or gbk";
                           self->encoding = word == "gbk" ? ano::Encoding::gbk : ano::Encoding::utf8;
                           return {};
                       }},
                       "utf8|gbk", "Text encoding, both ways (default: that of the link)"});
    options.push_back({"--end", Option::Read{[self](const std::string& word) { return read_line_end(word, self->line_end); }},
                       "crlf|lf|cr|none", "Line ending to send after each line (default: crlf)"});
    options.push_back({"--exclusive", &self->exclusive, "", "Forward no frames to the link meanwhile (counted as denied_out)"});
    options.push_back({"--json", &self->json, "", "Print one JSON object for each read or write"});
    GatewayOptions::add(options, self->gateway);
    return [self](Streams& streams) { return RawTerminal{*self, streams}.run(); };
}

}    // namespace anoctl
