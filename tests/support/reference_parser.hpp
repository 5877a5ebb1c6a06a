// Finds the frames exactly by the protocol text and the rules of resynchronisation; simple and slow. FrameParser must find the
// same frames.
#pragma once
#include <ano/image_length.hpp>
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

    std::vector<Bytes> frames;    // all valid frames so far
    std::uint64_t skipped = 0;
    std::uint64_t refused = 0;    // candidates refused for any reason

    std::uint64_t bytes_in() const { return bytes_.size(); }
    std::size_t waiting() const { return bytes_.size() - at_; }

    void put(const Bytes& bytes, ano::TimePoint now) {
        if (bytes.empty()) return;
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        last_arrival_ = now;
        none_at_end_ = false;
        look();
    }

    void begin_datagram(const Bytes& datagram, ano::TimePoint now) {
        if (waiting() == 0) return;
        const bool old = now - last_arrival_ >= (pauses() ? options_.frame_gap : std::chrono::milliseconds{100});
        if (old || what_begins(datagram, 0) == good) finish();
    }

    void finish() { discard_before(bytes_.size()); }

    void expire(ano::TimePoint now) {
        while (waiting() > 0) {
            const bool quiet = now - last_arrival_ >= (pauses() ? options_.frame_gap : options_.quiet);
            std::size_t behind = quiet ? good_frame_behind(at_ + 1) : 0;
            if (behind == 0 && may_be_between_frames(now)) {
                behind = good_frames_to_the_end();
                none_at_end_ = behind == 0;
                looked_at_ = now;
            }
            if (behind != 0) {
                discard_before(behind);
            } else if (now >= overdue_at(at_, since_)) {
                // The arrival time of this candidate is unknown: at the latest that of the last byte.
                std::size_t next = at_ + 1;
                while (quiet && next < bytes_.size() && (bytes_[next] != 0xAB || now >= overdue_at(next, last_arrival_))) ++next;
                discard_before(next);
            } else {
                return;
            }
        }
    }

private:
    enum Kind { good, refusable, incomplete };

    // At the end of a pause, or even without one if the candidate takes longer than the line needs.
    bool may_be_between_frames(ano::TimePoint now) const {
        if (none_at_end_ || options_.frame_gap <= options_.quiet) return false;
        return now >= std::min(last_arrival_, std::max(overdue_without_pauses_at(at_, since_), looked_at_)) + options_.quiet;
    }

    bool pauses() const { return options_.frame_gap > ano::Duration{}; }

    // For an image above max_data: the rows of pixels after its 17 bytes of flag, color, width, height and val.
    static bool are_rows(const Bytes& bytes, std::size_t at) {
        const std::size_t width = bytes[at + 9] + 256u * bytes[at + 10], height = bytes[at + 11] + 256u * bytes[at + 12];
        const std::size_t pixels = length_of(bytes, at) - 17;
        if (bytes[at + 8] > 6) return false;
        for (const std::size_t row : {bytes[at + 8] == 0 ? width : width / 8, bytes[at + 8] == 0 ? width : (width + 7) / 8})
            for (std::size_t rows = 1; row > 0 && rows <= height && rows * row <= pixels; ++rows)
                if (rows * row == pixels) return true;
        return false;
    }

    Kind what_begins(const Bytes& bytes, std::size_t at) const {
        if (at == bytes.size()) return incomplete;
        if (bytes[at] != 0xAB) return refusable;
        const std::size_t there = bytes.size() - at;
        if (there < 6) return incomplete;
        const std::size_t length = length_of(bytes, at);
        if (length > options_.max_data) {
            const std::size_t most = options_.max_data < 4096 ? options_.max_data
                                                              : std::max<std::size_t>(options_.max_data, 20'000);
            if (bytes[at + 3] != 0xB0 || length > most) return refusable;
            if (there < 23) return incomplete;
            if (!are_rows(bytes, at)) return refusable;
        }
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

    // Protocol text, section 4: these have a fixed length.
    static bool has_fixed_length(unsigned id, unsigned first) {
        if (id == 0x34) return first != 100;
        static const std::set<unsigned> fixed{0x20, 0x21, 0x30, 0x31, 0x32, 0x33, 0x35, 0x40, 0x41, 0x51, 0x60, 0x61, 0xC1, 0xE0};
        return id <= 0x0F || fixed.count(id) > 0;
    }

    bool credible() const {
        const unsigned id = bytes_[at_ + 3];
        if (id == 0xB1 || id == 0xB2) return true;
        if (sources_.count(bytes_[at_ + 1]) == 0) return false;
        return !has_fixed_length(id, bytes_[at_ + 6]) || length_at(at_) <= max_size_[id];
    }

    // A look takes 32 bytes of credit, which valid frames add; the credit is at most 65536.
    bool can_look() const { return credit_ >= 32; }

    // The first look at a header decides whether its frame counts: it does if its source is known, and it and another frame end
    // before the frame that waits.
    bool two_good_frames_behind() {
        const std::size_t max_length = std::min(length_at(at_), options_.max_data);
        const std::size_t end = std::min(bytes_.size(), at_ + 8 + options_.max_data);
        for (std::size_t at = at_ + 1; at + 6 <= end; ++at) {
            if (bytes_[at] != 0xAB || counts_.count(at) > 0) continue;
            if (!can_look()) break;
            credit_ -= 32;
            counts_[at] = sources_.count(bytes_[at + 1]) > 0 && length_at(at) + 10 <= max_length &&
                          at + length_at(at) < at_ + max_length;
        }
        const auto good_at = [this](std::size_t at) {
            const auto counts = counts_.find(at);
            return counts != counts_.end() && counts->second && what_begins(bytes_, at) == good;
        };
        for (std::size_t at = at_ + 1; at < end; ++at)
            if (good_at(at) && good_at(at + 8 + length_at(at))) return true;
        return false;
    }

    // 0: there is none.
    std::size_t good_frame_behind(std::size_t at) const {
        for (; at < bytes_.size(); ++at)
            if (what_begins(bytes_, at) == good) return at;
        return 0;
    }
    // Where frames begin of which the last one ends with the last byte; 0: there are none.
    std::size_t good_frames_to_the_end() const {
        const std::size_t first = good_frame_behind(at_ + 1);
        for (std::size_t next = first; next != 0; next = good_frame_behind(next + 8 + length_at(next)))
            if (next + 8 + length_at(next) == bytes_.size()) return first;
        return 0;
    }

    // Candidates that begin before `place` stop waiting.
    void discard_before(std::size_t place) {
        discarded_ = place;
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
                credit_ = std::min<std::size_t>(credit_ + size, 65536);
                max_size_[bytes_[at_ + 3]] = std::max(max_size_[bytes_[at_ + 3]], length_at(at_));
                const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
                frames.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(size));
                at_ += size;
                waits_ = false;
                break;
            }
            case refusable: drop(); break;
            case incomplete:
                if (at_ < discarded_) {
                    drop();
                    break;
                }
                // Giving up the candidate takes a look as well.
                if (waiting() > 8 && !sources_.empty() && !credible() && can_look() && two_good_frames_behind() && can_look()) {
                    credit_ -= 32;
                    drop();
                    break;
                }
                if (!waits_) since_ = last_arrival_;
                waits_ = true;
                return;
            }
        }
    }

    ano::TimePoint overdue_without_pauses_at(std::size_t at, ano::TimePoint since) const {
        using namespace std::chrono_literals;
        std::size_t length = bytes_.size() - at < 6 ? 0 : length_at(at);
        if (length > options_.max_data && bytes_.size() - at < 23) length = options_.max_data;
        const auto takes = [&](std::uint32_t rate) { return ano::Duration{std::chrono::seconds{8 + length}} / rate; };
        ano::TimePoint overdue = since + 1s;
        if (options_.line_rate != 0) overdue = since + 200ms + takes(options_.line_rate);
        else if (length > 4096) overdue += takes(11'520);
        return overdue;
    }
    ano::TimePoint overdue_at(std::size_t at, ano::TimePoint since) const {
        const ano::TimePoint overdue = overdue_without_pauses_at(at, since);
        return pauses() ? std::max(overdue, last_arrival_ + options_.frame_gap) : overdue;
    }

    ano::FrameParser::Options options_;
    Bytes bytes_;                  // all received bytes
    std::size_t at_ = 0;           // the bytes before are skipped or part of a valid frame
    std::size_t discarded_ = 0;    // candidates that begin before this do not wait for their rest
    bool waits_ = false;
    ano::TimePoint since_{};
    ano::TimePoint last_arrival_{};
    bool none_at_end_ = false;                   // no frame ends with the last byte
    ano::TimePoint looked_at_{};                 // for such a frame
    std::set<unsigned> sources_;                 // of valid frames
    std::array<std::size_t, 256> max_size_{};    // largest LEN of valid frames, by id
    std::size_t credit_ = 65536;
    std::map<std::size_t, bool> counts_;    // by the position of a header that was looked at
};

}    // namespace support
