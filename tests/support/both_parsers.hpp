// FrameParser and ReferenceParser side by side: both get the same calls, and the first difference is reported.
#pragma once
#include <support/reference_parser.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace support {

class BothParsers {
public:
    using Bytes = ReferenceParser::Bytes;

    explicit BothParsers(ano::FrameParser::Options options) : parser_{options}, reference_{options} {}

    ano::TimePoint now{};
    /// The first difference; empty while there is none.
    std::string difference;

    const std::vector<Bytes>& frames() const { return reference_.frames; }
    const ano::FrameParser& parser() const { return parser_; }

    void put(std::span<const std::uint8_t> bytes) { feed(bytes); }
    void feed_datagram(std::span<const std::uint8_t> datagram) {
        reference_.begin_datagram({datagram.begin(), datagram.end()}, now);
        parser_.begin_datagram(datagram, now);
        feed(datagram);
    }
    void expire() {
        reference_.expire(now);
        // Each call that returns true gives up at least one byte.
        for (std::size_t i = parser_.waiting(); parser_.expire(now); --i) {
            if (i == 0) return report("expire() has no end");
            drain();
        }
        if (const auto due = parser_.deadline(); due && *due <= now) report("deadline() is past and expire() had nothing to do");
        compare();
    }
    void finish() {
        reference_.finish();
        parser_.finish();
        drain();
        compare();
        if (parser_.waiting() != 0 || parser_.deadline()) report("something waits behind the end");
    }

private:
    void feed(std::span<const std::uint8_t> bytes) {
        drain();
        while (!bytes.empty()) {
            const auto room = parser_.prepare();
            if (room.empty()) return report("no room");
            const std::size_t n = std::min(room.size(), bytes.size());
            std::copy_n(bytes.data(), n, room.data());
            parser_.commit(n, now);
            reference_.put({bytes.data(), bytes.data() + n},
                           now);    // in the same pieces: the result may depend on the times of the bytes
            bytes = bytes.subspan(n);
            drain();
        }
        compare();
    }

    void drain() {
        while (const auto frame = parser_.next()) {
            good_bytes_ += frame->bytes().size();
            if (found_ >= reference_.frames.size() ||
                !std::equal(frame->bytes().begin(), frame->bytes().end(), reference_.frames[found_].begin(),
                            reference_.frames[found_].end()))
                report("another frame than the reference has");
            ++found_;
            conserve();
        }
        conserve();
    }

    void conserve() {
        const auto& c = parser_.counters();
        if (c.bytes_in != good_bytes_ + c.skipped_bytes + parser_.waiting()) report("bytes_in is not good + skipped + waiting");
    }

    void compare() {
        const auto& c = parser_.counters();
        check("frames", found_, reference_.frames.size());
        check("frames_in", c.frames_in, reference_.frames.size());
        check("bytes_in", c.bytes_in, reference_.bytes_in());
        check("skipped_bytes", c.skipped_bytes, reference_.skipped);
        check("waiting", parser_.waiting(), reference_.waiting());
        check("bad_check + bad_length + expired", c.bad_check + c.bad_length + c.expired, reference_.refused);
        if (parser_.deadline().has_value() != (reference_.waiting() > 0))
            report("deadline() exists exactly while a candidate waits");
    }
    void check(const char* what, std::uint64_t got, std::uint64_t expected) {
        if (got != expected)
            report(std::string{what} + ": " + std::to_string(got) + ", by the reference " + std::to_string(expected));
    }
    void report(std::string what) {
        if (difference.empty()) difference = std::move(what);
    }

    ano::FrameParser parser_;
    ReferenceParser reference_;
    std::size_t found_ = 0;
    std::uint64_t good_bytes_ = 0;
};

}    // namespace support
