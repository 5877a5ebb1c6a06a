#include <ano/v7.hpp>

#include <algorithm>
#include <cassert>
#include <cstring>

namespace ano::v7 {
namespace {

using namespace std::chrono_literals;

constexpr Duration datagram_patience = 100ms;

}    // namespace

Parser::Parser(Options options) : options_{options} { sums_.begin(0); }

std::span<std::uint8_t> Parser::prepare() noexcept {
    if (pos_ > 0 && (pos_ == end_ || pos_ >= capacity / 2)) {
        std::memmove(buffer_.get(), buffer_.get() + pos_, end_ - pos_);
        end_ -= pos_;
        barrier_ -= std::min(barrier_, pos_);
        pos_ = sums_until_ = 0;    // at most one frame is summed again
        sums_.begin(0);
    }
    return {buffer_.get() + end_, capacity - end_};
}

void Parser::commit(std::size_t n, TimePoint now) noexcept {
    assert(n <= capacity - end_);
    if (n == 0) return;
    end_ += n;
    counters_.bytes_in += n;
    last_arrival_ = now;
    none_behind_ = false;
}

std::optional<FrameView> Parser::next() noexcept {
    std::size_t at = find_head(pos_);
    Verdict verdict = Verdict::incomplete;
    for (; at < end_; at = find_head(at + 1)) {
        const bool no_rest = at < barrier_;
        verdict = judge(at, no_rest ? barrier_ : end_);
        if (verdict == Verdict::good || (verdict == Verdict::incomplete && !no_rest)) break;
        ++(verdict == Verdict::bad ? counters_.bad_check : counters_.expired);
    }
    counters_.skipped_bytes += at - pos_;
    pos_ = at;
    if (at == end_ || verdict != Verdict::good) return std::nullopt;
    const FrameView frame{{buffer_.get() + at, overhead + buffer_[at + 3]}};
    pos_ += frame.bytes().size();
    ++counters_.frames_in;
    return frame;
}

void Parser::begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept {
    if (waiting() > 0 && (now - last_arrival_ >= datagram_patience || frame_at(datagram))) finish();
}

bool Parser::expire(TimePoint now) noexcept {
    if (waiting() == 0 || none_behind_ || now - last_arrival_ < options_.quiet) return false;
    if (pos_ > sums_.end()) sums_.begin(pos_);
    sums_.extend({buffer_.get(), end_}, end_);    // all of them: next() begins at pos_ again
    sums_until_ = end_;
    for (std::size_t at = find_head(pos_ + 1); at < end_; at = find_head(at + 1)) {
        if (judge(at, end_) != Verdict::good) continue;
        barrier_ = at;
        return true;
    }
    none_behind_ = true;
    return false;
}

std::optional<TimePoint> Parser::deadline() const noexcept {
    if (waiting() <= overhead || none_behind_) return std::nullopt;
    return last_arrival_ + options_.quiet;
}

std::size_t Parser::find_head(std::size_t from) const noexcept {
    const void* found = from < end_ ? std::memchr(buffer_.get() + from, head, end_ - from) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - buffer_.get()) : end_;
}

Parser::Verdict Parser::judge(std::size_t at, std::size_t limit) noexcept {
    const std::size_t there = limit - at;
    if (there < header_size || there < overhead + buffer_[at + 3]) return Verdict::incomplete;
    return checks_hold(at, at + header_size + buffer_[at + 3]) ? Verdict::good : Verdict::bad;
}

bool Parser::checks_hold(std::size_t at, std::size_t to) noexcept {
    const std::uint8_t* const bytes = buffer_.get();
    if (at >= sums_until_) {
        if (checks_of({bytes + at, to - at}) == Checks{bytes[to], bytes[to + 1]}) return true;
        sums_until_ = to;
        return false;
    }
    if (at > sums_.end()) sums_.begin(at);
    if (to >= sums_.end()) sums_.extend({bytes, end_}, to + 1);
    if (sums_.sum_holds(at, to) && sums_.add(at, to) == bytes[to + 1]) return true;
    sums_until_ = std::max(sums_until_, to);
    return false;
}

}    // namespace ano::v7
