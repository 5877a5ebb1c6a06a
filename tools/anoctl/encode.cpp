// anoctl encode NAME FIELD=VALUE...: encodes values to a frame.
#include <anoctl/text/frame_printer.hpp>
#include "anoctl.hpp"
#include "given_frame.hpp"
#include "json_file.hpp"

#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/syntax_fault.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;

constexpr std::size_t max_line = 1 << 20;    // several times the text of the largest frame

/// The lines of standard input, each available as soon as it is complete.
class Lines {
public:
    explicit Lines(int fd) : fd_{fd} {}

    /// Reads the next line. False: end of input.
    bool next(std::string& line) {
        std::size_t end = 0;
        while ((end = text_.find('\n', seen_)) == std::string::npos) {
            text_.erase(0, begin_);
            begin_ = 0;
            seen_ = text_.size();
            if (seen_ > max_line) throw UsageError{"line " + std::to_string(number_ + 1) + ": longer than 1 MiB"};
            if (!read()) return last(line);
        }
        ++number_;
        line.assign(text_, begin_, end - begin_);
        begin_ = seen_ = end + 1;
        return true;
    }
    std::size_t number() const { return number_; }
    /// Whether the next line was already received.
    bool one_waits() const { return text_.find('\n', seen_) != std::string::npos; }

private:
    bool read() {
        char buffer[16384];
        ssize_t n = 0;
        do n = ::read(fd_, buffer, sizeof buffer);
        while (n < 0 && errno == EINTR);
        if (n < 0) throw Failure{std::string{"standard input: "} + std::strerror(errno)};
        text_.append(buffer, static_cast<std::size_t>(n));
        return n > 0;
    }
    bool last(std::string& line) {
        line = std::exchange(text_, {});
        seen_ = 0;
        if (!line.empty()) ++number_;
        return !line.empty();
    }

    int fd_;
    std::string text_;
    std::size_t begin_ = 0;    // of the next line
    std::size_t seen_ = 0;     // no line end before this offset
    std::size_t number_ = 0;
};

struct Encode {
    GivenFrame given;
    bool raw = false;
    FrameOptions frames;

    int run(Streams& streams) const {
        const FlexibleLayouts layouts = frames.layouts();
        const JsonOptions options = frames.json_options(layouts);
        if (given.name == "-") return encode_lines(streams, options);
        write(streams, given.bytes(options));
        return fine;
    }

private:
    // The input is the output of `decode --json`: one object per line.
    int encode_lines(Streams& streams, const JsonOptions& options) const {
        if (!given.fields.empty() || given.data)
            throw UsageError{"- reads frames from standard input and cannot be combined with FIELD=VALUE or --data"};
        Lines lines{streams.in};
        for (std::string line; streams.out && lines.next(line);) {
            if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
            const std::string where = "line " + std::to_string(lines.number());
            const Json json = json_in_text(line, where);
            if (json.is_object() && json.contains("fault")) continue;    // bytes that `decode` could not read as a frame
            write(streams, frame_bytes(json, options, where + ": ", given.v7));
            if (!lines.one_waits()) streams.out.flush();
        }
        return fine;
    }

    void write(Streams& streams, const std::vector<std::uint8_t>& bytes) const {
        if (raw) {
            for (const std::uint8_t byte : bytes) streams.out.put(static_cast<char>(byte));
        } else if (frames.json) {
            streams.out << Json{{"hex", hex(bytes)}}.dump() << '\n';
        } else {
            streams.out << spaced_hex(bytes) << '\n';
        }
    }
};

}    // namespace

Run add_encode(Options& options) {
    const auto self = std::make_shared<Encode>();
    GivenFrame::add(options, self->given, "Message, by name or id; - reads JSON frames from standard input, one per line");
    options.push_back({"--raw", &self->raw, "", "Write bytes instead of hex digits", false, {"--json"}});
    options.push_back(
        {"--v7", &self->given.v7, "", "Encode a frame of protocol version 7, which has no source address", false, {"--from"}});
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
