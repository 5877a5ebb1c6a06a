// Finds the frames of V7 exactly by the rules in the header of v7::FrameParser; simple and slow. The parser must find the same.
#pragma once
#include <ano/v7.hpp>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace support {

class V7ReferenceParser {
public:
    using Bytes = std::vector<std::uint8_t>;

    explicit V7ReferenceParser(ano::v7::FrameParser::Options options) : options_{options} {}

    std::vector<Bytes> frames;
    std::uint64_t skipped = 0;
    std::uint64_t refused = 0;

    std::uint64_t bytes_in() const { return bytes_.size(); }
    std::size_t waiting() const { return bytes_.size() - at_; }

    void put(std::span<const std::uint8_t> bytes, ano::TimePoint now) {
        if (bytes.empty()) return;
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        last_arrival_ = now;
        look(0);
    }
    void begin_datagram(std::span<const std::uint8_t> datagram, ano::TimePoint now) {
        if (waiting() == 0) return;
        const bool old = now - last_arrival_ >= std::max<ano::Duration>(options_.quiet, std::chrono::milliseconds{100});
        if (old || is_good({datagram.begin(), datagram.end()}, 0)) finish();
    }
    void finish() { look(bytes_.size()); }
    void expire(ano::TimePoint now) {
        const auto silence = now - last_arrival_;
        for (std::size_t at = at_ + 1; silence >= options_.quiet && at < bytes_.size(); ++at) {
            if (!is_good(bytes_, at)) continue;
            look(at);
            at = at_;
        }
        if (silence >= std::max<ano::Duration>(options_.quiet, std::chrono::milliseconds{200})) finish();
    }

private:
    static bool is_good(const Bytes& bytes, std::size_t at, std::size_t max_data) {
        if (bytes.size() < at + 6 || bytes[at] != 0xAA) return false;
        const std::size_t length = bytes[at + 3];
        if (length > max_data || bytes.size() < at + 6 + length) return false;
        unsigned sum = 0;
        unsigned add = 0;
        for (std::size_t i = at; i < at + 4 + length; ++i) {
            sum = (sum + bytes[i]) % 256;
            add = (add + sum) % 256;
        }
        return bytes[at + 4 + length] == sum && bytes[at + 5 + length] == add;
    }
    bool is_good(const Bytes& bytes, std::size_t at) const { return is_good(bytes, at, options_.max_data); }
    bool may_become_good(std::size_t at) const {
        if (bytes_[at] != 0xAA) return false;
        if (bytes_.size() < at + 4) return true;
        return bytes_[at + 3] <= options_.max_data && bytes_.size() < at + 6 + bytes_[at + 3];
    }

    // Candidates before `given_up` that reach beyond it do not wait for their rest.
    void look(std::size_t given_up) {
        while (at_ < bytes_.size()) {
            const bool complete = is_good(bytes_, at_);
            if (complete && (at_ >= given_up || at_ + 6 + bytes_[at_ + 3] <= given_up)) {
                const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
                frames.emplace_back(begin, begin + 6 + bytes_[at_ + 3]);
                at_ += frames.back().size();
            } else if (at_ >= given_up && may_become_good(at_)) {
                return;
            } else {
                refused += bytes_[at_] == 0xAA;
                ++skipped;
                ++at_;
            }
        }
    }

    ano::v7::FrameParser::Options options_;
    Bytes bytes_;
    std::size_t at_ = 0;
    ano::TimePoint last_arrival_{};
};

/// v7::FrameParser and the reference side by side: both get the same calls, and the first difference is reported.
class BothV7Parsers {
public:
    using Bytes = V7ReferenceParser::Bytes;

    explicit BothV7Parsers(ano::v7::FrameParser::Options options) : parser_{options}, reference_{options} {}

    ano::TimePoint now{};
    std::string difference;    // empty while there is none

    const std::vector<Bytes>& frames() const { return reference_.frames; }
    const ano::v7::ParserCounters& counters() const { return parser_.counters(); }

    void put(std::span<const std::uint8_t> bytes) {
        drain();
        while (!bytes.empty()) {
            const auto room = parser_.prepare();
            if (room.size() < 4096) return report("less than 4096 bytes of room");
            const std::size_t n = std::min(room.size(), bytes.size());
            std::copy_n(bytes.data(), n, room.data());
            parser_.commit(n, now);
            reference_.put(bytes.first(n), now);
            bytes = bytes.subspan(n);
            drain();
        }
        compare();
    }
    void feed_datagram(std::span<const std::uint8_t> datagram) {
        reference_.begin_datagram(datagram, now);
        parser_.begin_datagram(datagram, now);
        put(datagram);
    }
    void expire() {
        reference_.expire(now);
        for (std::size_t i = parser_.waiting(); parser_.expire(now); --i) {
            if (i == 0) return report("expire() never returns false");
            drain();
        }
        if (const auto due = parser_.deadline(); due && *due <= now) report("deadline() is past and expire() did nothing");
        compare();
    }
    void finish() {
        reference_.finish();
        parser_.finish();
        drain();
        compare();
        if (parser_.waiting() != 0 || parser_.deadline()) report("bytes wait behind the end");
    }

private:
    void drain() {
        while (const auto frame = parser_.next()) {
            good_bytes_ += frame->bytes().size();
            if (found_ >= reference_.frames.size() ||
                !std::equal(frame->bytes().begin(), frame->bytes().end(), reference_.frames[found_].begin(),
                            reference_.frames[found_].end()))
                report("another frame than that of the reference");
            ++found_;
        }
        const auto& c = parser_.counters();
        if (c.bytes_in != good_bytes_ + c.skipped_bytes + parser_.waiting()) report("bytes_in is not good + skipped + waiting");
    }
    void compare() {
        const auto& c = parser_.counters();
        check("frames_in", c.frames_in, reference_.frames.size());
        check("bytes_in", c.bytes_in, reference_.bytes_in());
        check("skipped_bytes", c.skipped_bytes, reference_.skipped);
        check("waiting", parser_.waiting(), reference_.waiting());
        check("bad_check + bad_length + expired", c.bad_check + c.bad_length + c.expired, reference_.refused);
        if (parser_.deadline().has_value() != (reference_.waiting() > 0))
            report("deadline() exists exactly while a candidate waits");
    }
    void check(const char* name, std::uint64_t got, std::uint64_t expected) {
        if (got != expected) report(std::string{name} + ": " + std::to_string(got) + ", reference " + std::to_string(expected));
    }
    void report(std::string what) {
        if (difference.empty()) difference = std::move(what);
    }

    ano::v7::FrameParser parser_;
    V7ReferenceParser reference_;
    std::size_t found_ = 0;
    std::uint64_t good_bytes_ = 0;
};

}    // namespace support
