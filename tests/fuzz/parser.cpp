// The parser compared with the reference, controlled by text:
//
//   first line   max_data and, after a space, the line rate
//   AB 01        bytes, in upper case
//   AB*300       the last byte, 300 times in total
//   (DCFE01 00)  a valid frame: source, destination, id, data; it may be inside the data of another
//   line end     the bytes of the line are read together; as a datagram if the line begins with >
//   ~50          50 ms pass
//   ?            expire()
//   !            finish()
//   #            the rest of the line is a comment
//
// Anything else is ignored.
#include <support/both_parsers.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace {

using support::BothParsers;
using Bytes = BothParsers::Bytes;

// The reference takes cubic time.
constexpr std::size_t max_bytes = 20000;
constexpr std::ptrdiff_t max_heads = 150;

class Script {
public:
    explicit Script(std::string_view text) : text_{text} {}

    void run() {
        const std::size_t max_data = number(ano::max_len);
        skip(" ");
        const auto line_rate = static_cast<std::uint32_t>(number(1'000'000));
        BothParsers both{{.max_data = max_data, .line_rate = line_rate}};
        while (!text_.empty() && within_bounds()) {
            step(both);
            if (both.difference.empty()) continue;
            std::fprintf(stderr, "%s\n", both.difference.c_str());
            std::abort();
        }
    }

private:
    void step(BothParsers& both) {
        const char c = text_.front();
        if (hex(c) >= 0) return byte();
        text_.remove_prefix(1);
        switch (c) {
        case '\n':
            datagram_ ? both.feed_datagram(line_) : both.put(line_);
            line_.clear();
            open_.clear();
            datagram_ = false;
            break;
        case '>': datagram_ = true; break;
        case '*': repeat(number(10'000)); break;
        case '(':
            open_.push_back(line_.size());
            line_.push_back(ano::head);
            break;
        case ')': close(); break;
        case '~': both.now += std::chrono::milliseconds{number(2000)}; break;
        case '?': both.expire(); break;
        case '!': both.finish(); break;
        case '#': text_.remove_prefix(std::min(text_.find('\n'), text_.size())); break;
        default: break;
        }
    }

    void byte() {
        int value = 0;
        for (int i = 0; i < 2 && !text_.empty() && hex(text_.front()) >= 0; ++i, text_.remove_prefix(1))
            value = 16 * value + hex(text_.front());
        line_.push_back(static_cast<std::uint8_t>(value));
    }

    void repeat(std::size_t n) {
        if (!line_.empty() && n > 0) line_.insert(line_.end(), n - 1, line_.back());
    }

    // Makes a frame of the bytes after the last open bracket.
    void close() {
        if (open_.empty()) return;
        const std::size_t begin = open_.back();
        open_.pop_back();
        line_.resize(std::max(line_.size(), begin + 4));
        const std::size_t length = line_.size() - begin - 4;
        if (length > ano::max_len) return;
        const std::uint8_t len[]{static_cast<std::uint8_t>(length), static_cast<std::uint8_t>(length >> 8)};
        line_.insert(line_.begin() + static_cast<std::ptrdiff_t>(begin) + 4, std::begin(len), std::end(len));
        line_.resize(line_.size() + 2);
        ano::seal(std::span{line_}.subspan(begin));
    }

    bool within_bounds() {
        if (text_.front() == '\n') {
            bytes_ += line_.size();
            heads_ += std::count(line_.begin(), line_.end(), ano::head);
        }
        return bytes_ + line_.size() <= max_bytes && heads_ <= max_heads;
    }

    std::size_t number(std::size_t most) {
        std::size_t n = 0;
        for (; !text_.empty() && text_.front() >= '0' && text_.front() <= '9'; text_.remove_prefix(1))
            n = std::min(most, 10 * n + static_cast<std::size_t>(text_.front() - '0'));
        return n;
    }
    void skip(std::string_view what) {
        if (text_.starts_with(what)) text_.remove_prefix(what.size());
    }
    static int hex(char c) {
        if (c >= '0' && c <= '9') return c - '0';
        return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    }

    std::string_view text_;
    Bytes line_;
    std::vector<std::size_t> open_;
    bool datagram_ = false;
    std::size_t bytes_ = 0;
    std::ptrdiff_t heads_ = 0;
};

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Script{{reinterpret_cast<const char*>(data), size}}.run();
    return 0;
}
