// v7::Parser beside a reference that looks at all bytes again each time. Both get the same bytes.
#pragma once
#include <ano/v7.hpp>
#include <support/bytes.hpp>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace support {

/// Every good frame of `bytes`, from left to right; none begins inside another.
inline std::vector<Bytes> v7_frames_in(std::span<const std::uint8_t> bytes) {
    std::vector<Bytes> frames;
    while (!bytes.empty()) {
        const auto frame = ano::v7::frame_at(bytes);
        if (frame) frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
        bytes = bytes.subspan(frame ? frame->bytes().size() : 1);
    }
    return frames;
}

class BothV7Parsers {
public:
    ano::v7::Parser parser;
    ano::TimePoint now{};
    std::vector<Bytes> frames;

    void put(std::span<const std::uint8_t> bytes, std::size_t at_once = SIZE_MAX) {
        all_.insert(all_.end(), bytes.begin(), bytes.end());
        while (!bytes.empty()) {
            const auto room = parser.prepare();
            const std::size_t n = std::min({room.size(), bytes.size(), at_once});
            if (n == 0) {
                fault_ = "no room";
                return;
            }
            std::copy_n(bytes.data(), n, room.data());
            parser.commit(n, now);
            bytes = bytes.subspan(n);
            drain();
        }
    }
    void expire() {
        while (parser.expire(now)) drain();
        if (const auto due = parser.deadline(); due && *due <= now) fault_ = "deadline() is past and expire() had nothing to do";
    }
    void finish() {
        parser.finish();
        drain();
        if (parser.waiting() != 0 || parser.deadline()) fault_ = "something waits behind the end";
    }
    /// The first difference from the reference, after finish(); empty: none.
    std::string difference() const {
        if (!fault_.empty()) return fault_;
        if (frames != v7_frames_in(all_)) return "the frames differ from those of the reference";
        return {};
    }

private:
    void drain() {
        while (const auto frame = parser.next()) frames.emplace_back(frame->bytes().begin(), frame->bytes().end());
        std::uint64_t good = 0;
        for (const Bytes& frame : frames) good += frame.size();
        const auto& c = parser.counters();
        if (c.bytes_in != good + c.skipped_bytes + parser.waiting()) fault_ = "a byte is not counted";
        if (c.frames_in != frames.size()) fault_ = "a frame is not counted";
    }

    Bytes all_;
    std::string fault_;
};

}    // namespace support
