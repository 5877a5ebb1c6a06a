// anoctl decode [HEX|FILE|-]: bytes to frames.
#include "anoctl.hpp"
#include "frame_printer.hpp"
#include "hex_text.hpp"

#include <ano/parser.hpp>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;
using Bytes = std::span<const std::uint8_t>;

/// Shows frames as their bytes come in, and what stands between them.
class Decoder {
public:
    Decoder(Streams& streams, const FrameOptions& options)
        : streams_{streams}, printer_{streams, options}, parser_{[] {
              FrameParser::Options o;
              o.max_data = largest_data;
              return o;
          }()} {}

    void put_in(Bytes bytes) {
        while (!bytes.empty()) {
            const auto room = parser_.prepare();
            const std::size_t n = std::min(room.size(), bytes.size());
            std::copy_n(bytes.begin(), n, room.begin());
            parser_.commit(n, Clock::now());
            bytes = bytes.subspan(n);
            show();
        }
    }
    /// Bytes, or hex text, as they come, until there are no more or nobody takes what is shown.
    void read_all(int fd, const std::string& name) {
        std::vector<std::uint8_t> buffer(65536);
        BytesOrText input;
        const auto look = [&] {
            if (input.bad_line() == 0) return;
            finish();
            throw Failure{name + ": line " + std::to_string(input.bad_line()) +
                          ": it began as hex digits and goes on as something else"};
        };
        while (streams_.out) {
            if (!wait_for_input(fd)) continue;
            const ssize_t n = ::read(fd, buffer.data(), buffer.size());
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) throw Failure{name + ": " + std::strerror(errno)};
            put_in(n == 0 ? input.finish() : input.read({buffer.data(), static_cast<std::size_t>(n)}));
            streams_.out.flush();
            look();
            if (input.raw_line() != 0) no_hex_ = name + ": line " + std::to_string(input.raw_line());
            if (n == 0) return;
        }
    }
    /// The end of the input. Returns what to exit with.
    int finish() {
        parser_.finish();
        show();
        const std::uint64_t end = parser_.counters().bytes_in;
        gap_until(end);
        if (parser_.counters().frames_in == 0 && end == 0) complain() << "no bytes\n";
        if (parser_.counters().frames_in == 0 && !no_hex_.empty())
            complain() << no_hex_ << " is no hex text (a byte is two digits; spaces and commas may stand between), so all was read as raw bytes\n";
        return damaged_ || parser_.counters().frames_in == 0 ? failed : fine;
    }

private:
    // False: nothing came, but a candidate that held frames back was given up.
    bool wait_for_input(int fd) {
        const auto deadline = parser_.deadline();
        if (!deadline) return true;
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline - Clock::now()).count();
        pollfd input{fd, POLLIN, 0};
        if (poll(&input, 1, static_cast<int>(std::max<std::int64_t>(left, 0))) != 0) return true;
        if (parser_.expire(Clock::now())) show();
        streams_.out.flush();
        return false;
    }
    void show() {
        while (const auto frame = parser_.next()) {
            gap_until(good_ + parser_.counters().skipped_bytes);
            printer_.print(*frame);
            if (const std::string wrong = malformation(*frame, printer_.layouts()); !wrong.empty()) {
                complain() << "offset " << told_ << ": " << wrong << '\n';
                damaged_ = true;
            }
            good_ += frame->bytes().size();
            told_ += frame->bytes().size();
        }
    }
    void gap_until(std::uint64_t end) {
        const ParserCounters& now = parser_.counters();
        if (end > told_) {
            const std::uint64_t bytes = end - told_;
            complain() << "offset " << told_ << ": " << bytes << (bytes == 1 ? " byte" : " bytes")
                       << " of no frame: " << cause(now) << '\n';
            damaged_ = true;
        }
        told_ = end;
        before_ = now;
    }
    const char* cause(const ParserCounters& now) const {
        if (now.v7_frames > before_.v7_frames) return "frames of protocol version 7 (0xAA) among them";
        if (now.bad_check > before_.bad_check) return "the check bytes do not hold";
        if (now.expired > before_.expired) return "a frame that is cut short";
        return "no frame begins there";
    }
    std::ostream& complain() {
        streams_.out.flush();
        return streams_.err << "anoctl: ";
    }

    Streams& streams_;
    FramePrinter printer_;
    FrameParser parser_;
    std::uint64_t told_ = 0;    // everything before this offset was told
    std::uint64_t good_ = 0;    // bytes of good frames
    ParserCounters before_;     // at the last gap
    bool damaged_ = false;
    std::string no_hex_;        // where text was read as bytes
};

struct Decode {
    std::vector<std::string> input;
    FrameOptions frames;

    int run(Streams& streams) const {
        Decoder decoder{streams, frames};
        std::string joined;
        for (const std::string& word : input) joined += word + " ";
        const bool from_stdin = input.empty() || (input.size() == 1 && input[0] == "-");
        if (from_stdin) {
            if (input.empty() && streams.in_is_terminal)
                throw UsageError{"give hex digits, a file, or - for standard input"};
            decoder.read_all(streams.in, "standard input");
        } else if (const auto bytes = from_hex_text(joined)) {
            decoder.put_in(*bytes);
        } else {
            read_file(decoder);
        }
        return decoder.finish();
    }

private:
    void read_file(Decoder& decoder) const {
        const std::string& path = input[0];
        const int fd = input.size() == 1 ? open(path.c_str(), O_RDONLY | O_CLOEXEC) : -1;
        if (fd < 0) throw UsageError{complaint()};
        const std::unique_ptr<const int, void (*)(const int*)> closer{&fd, [](const int* p) { close(*p); }};
        decoder.read_all(fd, path);
    }
    /// `c` is the first of `word` that can't stand in hex text.
    static std::string neither(const std::string& word, char c) {
        const bool separates = std::string_view{":-;_"}.find(c) != std::string_view::npos;
        if (separates && word.find_first_not_of("0123456789abcdefABCDEF:-;_") == word.npos)
            return std::string{": bytes are not separated by '"} + c + "': write spaces, commas or nothing between them";
        return " is neither hex digits nor a file (a byte is two digits)";
    }
    std::string complaint() const {
        std::size_t digits = 0;
        for (const std::string& word : input) {
            char last = 0;
            for (const char c : word) {
                if (std::isxdigit(static_cast<unsigned char>(c)))
                    ++digits;
                else if ((c == 'x' || c == 'X') && last == '0')
                    --digits;    // the 0 of 0x
                else if (!std::isspace(static_cast<unsigned char>(c)) && c != ',')
                    return input.size() > 1 || errno == ENOENT ? in_quotes(word) + neither(word, c)
                                                               : in_quotes(word) + ": " + std::strerror(errno);
                last = c;
            }
        }
        return digits % 2 == 1 ? "odd number of hex digits (" + std::to_string(digits) + "): a byte is two"
                               : "hex digits of one byte stand apart: a byte is two together";
    }
};

}    // namespace

Run add_decode(CLI::App& options) {
    const auto self = std::make_shared<Decode>();
    options
        .add_option("input", self->input,
                    "Hex digits (0x before them or not), a file, or - for standard input. A file and standard input hold "
                    "bytes, or hex digits as text and nothing else")
        ->option_text("[HEX|FILE|-]");
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
