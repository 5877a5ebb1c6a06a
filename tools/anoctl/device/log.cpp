// anoctl log: the log messages of devices (0xA0, 0xA1).
#include <anoctl/anoctl.hpp>
#include <anoctl/frame_printer.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/say.hpp>
#include <anoctl/table.hpp>
#include "frames_of.hpp"

#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/text.hpp>

#include <algorithm>
#include <iterator>
#include <memory>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

// The ANSI escape sequence for a colour of the table; the default colour for others.
const char* escape_of(std::uint8_t color) {
    constexpr const char* escapes[]{"", "\x1b[31m", "\x1b[32m", "\x1b[34m"};
    return color < std::size(escapes) ? escapes[color] : "";
}

class LogPrinter final : public FrameTaker {
public:
    LogPrinter(Streams& streams, const FrameOptions& options)
        : streams_{streams},
          as_json_{streams, options},
          json_{options.json},
          encoding_{options.encoding.value_or(ano::Encoding::automatic)} {}

    bool take(ano::FrameView frame, const Passage& passage) override {
        if (json_) as_json_.print(frame, passage);
        else if (const auto log = ano::as<"log">(frame)) print(frame, passage, log->get<"color">(), text_of(log->bytes<"str">()));
        else if (const auto value = ano::as<"log_value">(frame))
            print(frame, passage, 0, ano::number_text(ano::widened(value->get<"val">())) + " " + text_of(value->bytes<"str">()));
        return true;
    }
    bool flush() override { return bool{streams_.out.flush()}; }
    void miss(std::uint64_t count, const std::string&, std::string_view json) override {
        if (json_) streams_.out << json << '\n';
        else
            tell(streams_, plural(count, "line") + (count == 1 ? " is" : " are") + " not shown, the gateway had no room for " +
                               (count == 1 ? "it" : "them"));
    }

private:
    // The text as received, without the NUL and line ends that some devices append.
    std::string text_of(std::span<const std::uint8_t> bytes) const {
        std::string text = ano::to_utf8(bytes, encoding_);
        text.resize(std::min(text.find('\0'), text.size()));
        while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
        return without_controls(text);
    }
    void print(ano::FrameView frame, const Passage& passage, std::uint8_t color, const std::string& text) {
        const auto in_color = [&](const char* escape, const std::string& words) {
            return streams_.color && *escape != '\0' ? escape + words + "\x1b[0m" : words;
        };
        std::string who = ano::hex_byte(frame.source());
        if (streams_.terminal) who += " " + std::string{ano::address::who(frame.source())};
        streams_.out << in_color("\x1b[2m", clock_text(passage.time)) << ' ' << who << (streams_.terminal ? "  " : " ")
                     << in_color(escape_of(color), text) << '\n';
    }

    Streams& streams_;
    FramePrinter as_json_;
    const bool json_;
    const ano::Encoding encoding_;
};

struct Log {
    FramesOf from;
    FrameOptions frames;

    int run(Streams& streams) const {
        FrameOptions options = frames;
        if (!from.link.empty() && !options.encoding && link_settings_of(from.link).text_encoding() == anogate::TextEncoding::gbk)
            options.encoding = ano::Encoding::gbk;
        LogPrinter printer{streams, options};
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
    options.push_back({"--json", &self->frames.json, "", "One JSON object a line"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
