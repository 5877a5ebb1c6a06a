// anoctl log: log messages of devices (0xA0, 0xA1).
#include <anoctl/anoctl.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "frames_of.hpp"

#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/text.hpp>
#include <config/values.hpp>
#include <gateway/frame_record.hpp>
#include <record/sender_encodings.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

// The ANSI escape sequence of a colour in the message table; empty (default colour) for others.
const char* escape_of(std::uint8_t color) {
    constexpr const char* escapes[]{"", "\x1b[31m", "\x1b[32m", "\x1b[34m"};
    return color < std::size(escapes) ? escapes[color] : "";
}

class LogPrinter final : public FrameReceiver {
public:
    LogPrinter(Streams& streams, const FrameOptions& options)
        : streams_{streams}, as_json_{streams, options}, json_{options.json}, given_{options.encoding} {}

    bool accept(ano::FrameView frame, const Passage& passage) override {
        const bool is_received = passage.direction == text(anogate::Direction::in);
        encoding_ = given_.value_or(encodings_.of(frame, passage.link, is_received, decoding_.get()));
        if (json_) as_json_.print(frame, passage);
        else if (const auto log = ano::as<"log">(frame))
            print(frame.source(), passage.time, log->get<"color">(), decode_text(log->bytes<"str">()));
        else if (const auto value = ano::as<"log_value">(frame))
            print(frame.source(), passage.time, 0,
                  ano::number_text(ano::widened(value->get<"val">())) + " " + decode_text(value->bytes<"str">()));
        return true;
    }
    /// `line`: a stored line of the gateway, as in its response.
    void print_kept(const ano::Json& line) {
        const double time = number_at(line, "time");
        const std::string value = text_at(line, "value"), address = text_at(line, "device");
        if (json_) {
            ano::Json fields{{"str", line.value("text", "")}};
            if (value.empty()) fields["color"] = number_at(line, "color");
            else fields["val"] = line.value("value", ano::Json{});
            const ano::Json shown{{"from", address},
                                  {"name", value.empty() ? "log" : "log_value"},
                                  {"fields", std::move(fields)},
                                  {"time", time},
                                  {"link", text_at(line, "link")},
                                  {"kept", true}};
            streams_.out << ano::json_text(shown) << '\n';
            return;
        }
        std::string text = text_at(line, "text");
        const auto called = ano::address_called(address);
        const auto* const from = std::get_if<std::uint8_t>(&called);
        print(from != nullptr ? *from : std::uint8_t{0}, time, static_cast<std::uint8_t>(number_at(line, "color")),
              value.empty() ? text : value + " " + text);
    }
    void use(const anogate::DecodingPtr& decoding) override {
        decoding_ = decoding;
        as_json_.use(decoding);
    }
    bool flush() override { return bool{streams_.out.flush()}; }
    void miss(std::uint64_t count, const std::string&, std::string_view json) override {
        if (json_) streams_.out << json << '\n';
        else print_note(streams_, plural(count, "line") + " not shown: the buffer of the gateway was full");
    }

private:
    // The received text, without the NUL and line ends that some devices append.
    std::string decode_text(std::span<const std::uint8_t> bytes) const {
        const std::string_view whole{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        std::string text = ano::display_text(whole.substr(0, whole.find('\0')), encoding_);
        while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
        return without_controls(text);
    }
    void print(std::uint8_t from, double time, std::uint8_t color, const std::string& text) {
        const auto in_color = [&](const char* escape, const std::string& words) {
            return streams_.color && *escape != '\0' ? escape + words + "\x1b[0m" : words;
        };
        std::string who = ano::hex_byte(from);
        if (streams_.terminal) who += " " + std::string{ano::address::who(from)};
        streams_.out << in_color("\x1b[2m", clock_text(time)) << ' ' << who << (streams_.terminal ? "  " : " ")
                     << in_color(escape_of(color), text) << '\n';
    }

    Streams& streams_;
    FramePrinter as_json_;
    const bool json_;
    const std::optional<ano::Encoding> given_;
    anogate::DecodingPtr decoding_;
    anogate::SenderEncodings encodings_;
    ano::Encoding encoding_ = ano::Encoding::utf8;    // of the frame being printed
};

struct Log {
    FramesOf from;
    FrameOptions frames;
    std::string since;
    bool no_follow = false;

    // Prints the lines since `since` from the gateway, which stores the last lines of each device.
    void print_kept(LogPrinter& printer) const {
        const auto back = anogate::parse_duration(since);
        if (!back) throw UsageError{"--since: " + ano::in_quotes(since) + " is not a time such as 90s, 10m or 2h"};
        if (!from.link.empty()) throw UsageError{"--since cannot be combined with --link: only a gateway stores log lines"};
        const double now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
        const double begin = now - std::chrono::duration<double>(*back).count();
        std::vector<ano::Json> lines;
        for (const std::string& device : from.devices.empty() ? std::vector<std::string>{"0xFF"} : from.devices) {
            const ano::Json answer = parse_answer(
                from.gateway.ask("GET", "/devices/" + percent_encoded(device) + "/log?since=" + std::to_string(begin)));
            for (const ano::Json& line : at(answer, "lines")) lines.push_back(line);
        }
        std::stable_sort(lines.begin(), lines.end(),
                         [](const ano::Json& a, const ano::Json& b) { return number_at(a, "n") < number_at(b, "n"); });
        for (const ano::Json& line : lines) printer.print_kept(line);
        printer.flush();
    }

    int run(Streams& streams) const {
        FrameOptions options = frames;
        if (!options.encoding && !from.link.empty())
            if (const auto of_link = link_settings_of(from.link).encoding)
                options.encoding = *of_link == anogate::TextEncoding::gbk ? ano::Encoding::gbk : ano::Encoding::utf8;
        LogPrinter printer{streams, options};
        if (no_follow && since.empty()) throw UsageError{"--no-follow requires --since"};
        if (!since.empty()) print_kept(printer);
        if (no_follow) return fine;
        const std::string why = from.each({"log", "log_value"}, printer, streams, "log");
        if (!why.empty()) throw Failure{why};
        return fine;
    }
};

}    // namespace

Run add_log(Options& options) {
    const auto self = std::make_shared<Log>();
    FramesOf::add(options, self->from);
    FrameOptions::add_encoding(options, self->frames);
    options.push_back({"--since", &self->since, "TIME",
                       "First show the lines of the last TIME (such as 10m) stored by the gateway: up to 500 per device"});
    options.push_back({"--no-follow", &self->no_follow, "", "Exit after the stored lines"});
    options.push_back({"--json", &self->frames.json, "", "Print one JSON object per line"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
