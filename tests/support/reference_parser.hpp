// Finds the frames as the protocol text and the rules of resynchronisation tell it, one sentence after the other, with
// no thought for cost. FrameParser must find the same.
#pragma once
#include <ano/parser.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace support {

class ReferenceParser {
public:
    using Bytes = std::vector<std::uint8_t>;

    explicit ReferenceParser(ano::FrameParser::Options options) : options_{options} {}

    std::vector<Bytes> frames;    // every good frame so far
    std::uint64_t skipped = 0;
    std::uint64_t refused = 0;    // candidates, for whatever reason

    std::uint64_t bytes_in() const { return bytes_.size(); }
    std::size_t waiting() const { return bytes_.size() - at_; }

    void put(const Bytes& bytes, ano::TimePoint now) {
        if (bytes.empty()) return;
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        last_arrival_ = now;
        look();
    }

    void begin_datagram(const Bytes& datagram, ano::TimePoint now) {
        if (waiting() == 0) return;
        const bool old = now - last_arrival_ >= std::chrono::milliseconds{100};
        if (old || what_begins(datagram, 0) == good) finish();
    }

    void finish() {
        while (waiting() > 0) refuse();
    }

    void expire(ano::TimePoint now) {
        while (waiting() > 0) {
            const bool quiet = now - last_arrival_ >= options_.quiet;
            const bool overdue = now >= overdue_at();
            if (!(overdue || (quiet && good_frame_behind()))) return;
            refuse();
        }
    }

private:
    enum Kind { good, refusable, incomplete };

    Kind what_begins(const Bytes& bytes, std::size_t at) const {
        if (at == bytes.size()) return incomplete;
        if (bytes[at] != 0xAB) return refusable;
        const std::size_t there = bytes.size() - at;
        if (there < 6) return incomplete;
        const std::size_t length = length_of(bytes, at);
        if (length > options_.max_data) return refusable;
        if (there < 8 + length) return incomplete;
        unsigned sum = 0;
        unsigned add = 0;
        for (std::size_t i = 0; i < 6 + length; ++i) {
            sum = (sum + bytes[at + i]) % 256;
            add = (add + sum) % 256;
        }
        return bytes[at + 6 + length] == sum && bytes[at + 7 + length] == add ? good : refusable;
    }

    static std::size_t length_of(const Bytes& bytes, std::size_t at) { return bytes[at + 4] + 256u * bytes[at + 5]; }
    std::size_t length_at(std::size_t at) const { return length_of(bytes_, at); }

    // Protocol text, section 4: these have a length of their own.
    static bool has_fixed_length(unsigned id, unsigned first) {
        if (id == 0x34) return first != 100;
        static const std::set<unsigned> fixed{0x20, 0x21, 0x30, 0x31, 0x32, 0x33, 0x35, 0x40,
                                              0x41, 0x51, 0x60, 0x61, 0xC1, 0xE0};
        return id <= 0x0F || fixed.count(id) > 0;
    }

    bool credible() const {
        const unsigned id = bytes_[at_ + 3];
        if (id == 0xB1 || id == 0xB2) return true;
        if (sources_.count(bytes_[at_ + 1]) == 0) return false;
        return !has_fixed_length(id, bytes_[at_ + 6]) || length_at(at_) <= largest_[id];
    }

    // When a header is first looked at it is decided whether its frame counts: its source has been heard, and it and another
    // end before the frame that waits.
    bool two_good_frames_behind() {
        for (std::size_t at = at_ + 1; at + 6 <= bytes_.size(); ++at)
            if (bytes_[at] == 0xAB)
                counts_.emplace(at, sources_.count(bytes_[at + 1]) > 0 && length_at(at) + 10 <= length_at(at_) &&
                                        at + length_at(at) < at_ + length_at(at_));
        const auto good_at = [this](std::size_t at) {
            const auto counts = counts_.find(at);
            return counts != counts_.end() && counts->second && what_begins(bytes_, at) == good;
        };
        for (std::size_t at = at_ + 1; at < bytes_.size(); ++at)
            if (good_at(at) && good_at(at + 8 + length_at(at))) return true;
        return false;
    }

    bool good_frame_behind() const {
        for (std::size_t at = at_ + 1; at < bytes_.size(); ++at)
            if (what_begins(bytes_, at) == good) return true;
        return false;
    }

    // Gives up the first byte and looks on. Of a candidate that shows only now, it is known that it came with the last
    // byte at the latest.
    void refuse() {
        drop();
        look();
    }

    void drop() {
        if (bytes_[at_] == 0xAB) ++refused;
        ++skipped;
        ++at_;
        waits_ = false;
    }

    void look() {
        while (waiting() > 0) {
            switch (what_begins(bytes_, at_)) {
                case good: {
                    const std::size_t size = 8 + length_at(at_);
                    sources_.insert(bytes_[at_ + 1]);
                    largest_[bytes_[at_ + 3]] = std::max(largest_[bytes_[at_ + 3]], length_at(at_));
                    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
                    frames.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(size));
                    at_ += size;
                    waits_ = false;
                    break;
                }
                case refusable: drop(); break;
                case incomplete:
                    if (waiting() > 6 && !sources_.empty() && !credible() && two_good_frames_behind()) {
                        drop();
                        break;
                    }
                    if (!waits_) since_ = last_arrival_;
                    waits_ = true;
                    return;
            }
        }
    }

    ano::TimePoint overdue_at() const {
        using namespace std::chrono_literals;
        if (options_.line_rate == 0) return since_ + 1s;
        const std::int64_t size = waiting() < 6 ? 8 : 8 + static_cast<std::int64_t>(length_at(at_));
        return since_ + 200ms + ano::Duration{std::chrono::seconds{size}} / options_.line_rate;
    }

    ano::FrameParser::Options options_;
    Bytes bytes_;           // all that ever came
    std::size_t at_ = 0;    // what stands before is skipped or part of a good frame
    bool waits_ = false;
    ano::TimePoint since_{};
    ano::TimePoint last_arrival_{};
    std::set<unsigned> sources_;                    // of good frames
    std::array<std::size_t, 256> largest_{};        // LEN of good frames, by id
    std::map<std::size_t, bool> counts_;            // by the place of a header that was looked at
};

}    // namespace support
