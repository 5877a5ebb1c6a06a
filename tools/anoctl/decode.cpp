// anoctl decode [HEX|FILE|-]: decodes bytes to frames.
#include <anoctl/device/file_text.hpp>
#include <anoctl/recording/gap.hpp>
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/hex_text.hpp>
#include "anoctl.hpp"

#include <ano/hex.hpp>
#include <ano/parser.hpp>
#include <ano/v7.hpp>

#include <nlohmann/json.hpp>
#include <record/recording_writer.hpp>

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;
using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t max_kept = 1 << 20;    // bytes not reported yet; of a longer gap, only the length is reported

std::string to_string(Checks checks) { return spaced_hex(std::array{checks.sum, checks.add}); }

/// What differs between the versions of the protocol.
struct InV8 {
    using Parser = FrameParser;
    static Parser parser() {
        FrameParser::Options options;
        options.max_data = max_len;
        return Parser{options};
    }
    static Reading read(FrameView frame, const FlexibleLayouts& layouts) { return ano::read(frame, &layouts); }
    static std::vector<GapPart> parts_of(Bytes gap) { return anoctl::parts_of(gap); }
    static const char* other_version(const ParserCounters& now, const ParserCounters& before, Bytes) {
        return now.v7_frames > before.v7_frames ? "contains frames of protocol version 7 (0xAA), use --v7" : nullptr;
    }
};
struct InV7 {
    using Parser = v7::FrameParser;
    static Parser parser() { return Parser{{}}; }
    static Reading read(v7::FrameView frame, const FlexibleLayouts& layouts) { return v7::read(frame, &layouts); }
    static std::vector<GapPart> parts_of(Bytes gap) {
        return has_v8_frame(gap) ? std::vector<GapPart>{} : anoctl::parts_of(gap, v7_frame_size);
    }
    static const char* other_version(const v7::ParserCounters&, const v7::ParserCounters&, Bytes gap) {
        return has_v8_frame(gap) ? "contains frames of protocol version 8 (0xAB), decode it without --v7" : nullptr;
    }
    static bool has_v8_frame(Bytes gap) {
        for (; !gap.empty(); gap = gap.subspan(1))
            if (frame_at(gap)) return true;
        return false;
    }
};

/// Prints frames while their bytes arrive, and the bytes between frames.
template <class Version>
class Decoder {
public:
    Decoder(Streams& streams, const FrameOptions& options)
        : streams_{streams}, json_{options.json}, printer_{streams, options}, parser_{Version::parser()} {}

    void write_in(Bytes bytes) {
        while (!bytes.empty()) {
            const auto room = parser_.prepare();
            const std::size_t n = std::min(room.size(), bytes.size());
            std::copy_n(bytes.begin(), n, room.begin());
            parser_.commit(n, Clock::now());
            keep(bytes.first(n));
            bytes = bytes.subspan(n);
            show();
        }
    }
    /// Reads bytes or hex text as they arrive, until the end of the input or until the output can no longer be written.
    void read_all(int fd, const std::string& name) {
        std::vector<std::uint8_t> buffer(65536);
        BytesOrText input;
        const auto look = [&] {
            if (input.bad_line() == 0) return;
            finish();
            throw Failure{name + ": line " + std::to_string(input.bad_line()) +
                          ": the input started as hex digits, but this line contains other characters"};
        };
        while (streams_.out) {
            if (!wait_for_input(fd)) continue;
            const ssize_t n = ::read(fd, buffer.data(), buffer.size());
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) throw Failure{name + ": " + std::strerror(errno)};
            write_in(n == 0 ? input.finish() : input.read({buffer.data(), static_cast<std::size_t>(n)}));
            streams_.out.flush();
            look();
            if (input.raw_line() != 0) no_hex_ = name + ": line " + std::to_string(input.raw_line());
            if (n == 0) return;
        }
    }
    /// To be called at the end of the input. Returns the exit status.
    int finish() {
        parser_.finish();
        show();
        const std::uint64_t end = parser_.counters().bytes_in;
        gap_until(end);
        if (parser_.counters().frames_in == 0 && end == 0) complain() << "no bytes\n";
        if (parser_.counters().frames_in == 0 && !no_hex_.empty())
            complain() << no_hex_
                       << " is not hex text (two digits per byte, optionally separated by spaces or commas), so the input was "
                          "read as raw bytes\n";
        return damaged_ || parser_.counters().frames_in == 0 ? failed : fine;
    }

private:
    // False: no bytes arrived, but an unfinished frame that delayed later frames was given up.
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
            const Reading reading = Version::read(*frame, printer_.layouts());
            if (const std::string why = undecoded(reading); !why.empty())
                complain() << "offset " << reported_to_ << ": " << why << '\n';
            if (reading.readable() == Readable::too_short) damaged_ = true;
            good_ += frame->bytes().size();
            reported_to_ += frame->bytes().size();
        }
    }
    void gap_until(std::uint64_t end) {
        if (end > reported_to_) {
            damaged_ = true;
            const std::vector<GapPart> parts = kept_at_ <= reported_to_ ? Version::parts_of(kept(reported_to_, end))
                                                                        : std::vector<GapPart>{};
            for (const GapPart& part : parts) {
                const std::uint64_t behind = reported_to_ + part.bytes.size();
                if (part.right) print_wrong_checksum(part);
                else print_gap(behind, parts.size() > 1);
                reported_to_ = behind;
            }
            if (parts.empty()) print_gap(end, false);
        }
        reported_to_ = end;
        before_ = parser_.counters();
    }
    void print_gap(std::uint64_t end, bool beside_frames) {
        begin_complaint(end - reported_to_) << " outside any frame: " << cause(end, beside_frames) << '\n';
    }
    void print_wrong_checksum(const GapPart& part) {
        const Checks wrong{part.bytes[part.bytes.size() - 2], part.bytes[part.bytes.size() - 1]};
        begin_complaint(part.bytes.size()) << " outside any frame: wrong checksum " << to_string(wrong) << ", expected "
                                           << to_string(*part.right) << '\n';
        if (!json_) return;
        streams_.out << Json{{"fault", "check"},
                             {"offset", reported_to_},
                             {"hex", hex(part.bytes)},
                             {"check", hex(part.bytes.last(2))},
                             {"right_check", hex(std::array{part.right->sum, part.right->add})}}
                            .dump()
                     << '\n';
    }
    std::ostream& begin_complaint(std::uint64_t bytes) {
        return complain() << "offset " << reported_to_ << ": " << bytes << (bytes == 1 ? " byte" : " bytes");
    }
    /// The reason why bytes are not a frame. `beside_frames`: wrong check bytes were reported already.
    const char* cause(std::uint64_t end, bool beside_frames) const {
        const auto& now = parser_.counters();
        const Bytes gap = kept_at_ <= reported_to_ ? kept(reported_to_, end) : Bytes{};
        if (const char* const other = Version::other_version(now, before_, gap)) return other;
        if (now.bad_check > before_.bad_check && !beside_frames) return "wrong checksum";
        if (now.expired > before_.expired) return "truncated frame";
        return "no frame starts here";
    }
    void keep(Bytes bytes) {
        const std::uint64_t old = reported_to_ > kept_at_ ? reported_to_ - kept_at_ : 0;
        if (kept_.size() > max_kept) drop(kept_.size());
        else if (old > kept_.size() / 2) drop(old);
        kept_.insert(kept_.end(), bytes.begin(), bytes.end());
    }
    void drop(std::uint64_t bytes) {
        kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(bytes));
        kept_at_ += bytes;
    }
    Bytes kept(std::uint64_t from, std::uint64_t to) const {
        return Bytes{kept_}.subspan(static_cast<std::size_t>(from - kept_at_), static_cast<std::size_t>(to - from));
    }
    std::ostream& complain() {
        streams_.out.flush();
        return streams_.err << "anoctl: ";
    }

    Streams& streams_;
    bool json_;
    FramePrinter printer_;
    typename Version::Parser parser_;
    std::uint64_t reported_to_ = 0;    // offset up to which everything was reported
    std::uint64_t good_ = 0;           // bytes of valid frames
    std::decay_t<decltype(std::declval<typename Version::Parser>().counters())> before_;    // counters at the last gap
    bool damaged_ = false;
    std::vector<std::uint8_t> kept_;    // bytes from offset kept_at_ on, including those not reported yet
    std::uint64_t kept_at_ = 0;
    std::string no_hex_;    // the place where text was read as raw bytes
};

struct Decode {
    std::vector<std::string> input;
    bool v7 = false;
    FrameOptions frames;

    int run(Streams& streams) const { return v7 ? run_in<InV7>(streams) : run_in<InV8>(streams); }

private:
    template <class Version>
    int run_in(Streams& streams) const {
        Decoder<Version> decoder{streams, frames};
        std::string joined;
        for (const std::string& word : input) joined += word + " ";
        const bool from_stdin = input.empty() || (input.size() == 1 && input[0] == "-");
        if (from_stdin) {
            if (input.empty() && streams.in_is_terminal)
                throw UsageError{"missing input: give hex digits, a file, or - for standard input"};
            decoder.read_all(streams.in, "standard input");
        } else if (const auto bytes = from_hex_text(joined)) {
            decoder.write_in(*bytes);
        } else {
            read_file(decoder);
        }
        return decoder.finish();
    }

    template <class Version>
    void read_file(Decoder<Version>& decoder) const {
        const std::string& path = input[0];
        const int fd = input.size() == 1 ? open_input(path) : -1;
        if (fd < 0) throw UsageError{complaint()};
        const std::unique_ptr<const int, void (*)(const int*)> closer{&fd, [](const int* p) { close(*p); }};
        if (anogate::recording_format_of(path))
            throw UsageError{path + ": is a recording: see anoctl info " + path + ", or anoctl convert " + path + " FILE.csv"};
        decoder.read_all(fd, path);
    }
    /// `c` is the first character of `word` that is not allowed in hex text.
    static std::string neither(const std::string& word, char c) {
        const bool separates = std::string_view{":-;_"}.find(c) != std::string_view::npos;
        if (separates && word.find_first_not_of("0123456789abcdefABCDEF:-;_") == word.npos)
            return std::string{": bytes are not separated by '"} + c + "': write spaces, commas or nothing between them";
        return " is neither hex digits (two per byte) nor a file";
    }
    std::string complaint() const {
        std::size_t digits = 0;
        for (const std::string& word : input) {
            char last = 0;
            for (const char c : word) {
                if (std::isxdigit(static_cast<unsigned char>(c))) ++digits;
                else if ((c == 'x' || c == 'X') && last == '0') --digits;    // the 0 of 0x
                else if (!std::isspace(static_cast<unsigned char>(c)) && c != ',')
                    return input.size() > 1 || errno == ENOENT ? in_quotes(word) + neither(word, c)
                                                               : in_quotes(word) + ": " + std::strerror(errno);
                last = c;
            }
        }
        return digits % 2 == 1 ? "odd number of hex digits (" + std::to_string(digits) + "): a byte is two"
                               : "the two hex digits of a byte must not be separated";
    }
};

}    // namespace

Run add_decode(Options& options) {
    const auto self = std::make_shared<Decode>();
    options.push_back({"input", &self->input, "[HEX|FILE|-]",
                       "Hex digits (0x before them or not), a file, or - for standard input. A file and standard input hold "
                       "bytes, or hex digits as text and nothing else"});
    options.push_back({"--v7", &self->v7, "", "Decode frames of protocol version 7"});
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
