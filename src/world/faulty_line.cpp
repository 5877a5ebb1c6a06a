#include "faulty_line.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace ano::world {

FaultyLine::FaultyLine(std::unique_ptr<SimulatedDevice> device, const Faults& faults, std::uint64_t seed, TimePoint start)
    : device_{std::move(device)}, faults_{faults}, there_{~seed}, back_{seed + 1}, start_{start}, parser_{device_->uses_v7()} {}

void FaultyLine::take(Bytes bytes, TimePoint now, const Send& send) {
    run(now, send);
    put(bytes, Direction::to_device, now, there_);
    run(now, send);
}

// Frames are handled in the order of their times, even if run() is called late.
void FaultyLine::run(TimePoint now, const Send& send) {
    device_->notice_pause(now);
    for (;;) {
        const TimePoint first = passing_.empty() ? TimePoint::max() : passing_.begin()->first;
        const TimePoint device_due = device_->due();
        if (device_due <= std::min(now, first)) {
            device_->run(device_due, emit_);
        } else if (first <= now) {
            const auto next = passing_.extract(passing_.begin());
            arrive(next.mapped(), next.key(), send);
        } else {
            return;
        }
    }
}

TimePoint FaultyLine::due() const noexcept {
    const TimePoint device_due = device_->due();
    return passing_.empty() ? device_due : std::min(device_due, passing_.begin()->first);
}

// Every frame draws the same number of random numbers, so that faults of one frame do not change those of the next.
void FaultyLine::put(Bytes frame, Direction way, TimePoint at, Noise& chance) {
    const auto happens = [&](unsigned percent) { return chance.share() * 100 < percent; };
    const bool is_lost = happens(faults_.loss), is_double = happens(faults_.duplicate), is_damaged = happens(faults_.corrupt);
    const std::uint64_t bit = chance.bits();
    const std::array late{chance.share(), chance.share()};
    if (is_lost || passing_.size() >= max_passing) {
        ++counters_.lost;
        return;
    }
    counters_.doubled += is_double;
    counters_.damaged += is_damaged;
    Passing passing{way, {frame.begin(), frame.end()}};
    if (is_damaged) passing.bytes[bit / 8 % frame.size()] ^= static_cast<std::uint8_t>(1u << bit % 8);
    for (std::size_t copy = 0; copy < (is_double ? 2u : 1u); ++copy) {
        const Duration jitter{static_cast<Duration::rep>(late[copy] * static_cast<double>(faults_.jitter.count()))};
        passing_.emplace(at + faults_.delay + jitter, passing);
    }
}

void FaultyLine::arrive(const Passing& passing, TimePoint at, const Send& send) {
    switch (passing.way) {
    case Direction::to_host: return send(passing.bytes, at);
    case Direction::to_slow_device: --waiting_; return receive(passing.bytes, at);
    case Direction::to_device:
        if (faults_.slow > Duration::zero()) return wait_for_slow_device(passing, at);
        return receive(passing.bytes, at);
    }
}

void FaultyLine::wait_for_slow_device(const Passing& passing, TimePoint at) {
    if (waiting_ == (faults_.one_at_a_time ? 1 : max_waiting)) {
        ++counters_.unheard;
        return;
    }
    ++waiting_;
    busy_until_ = std::max(busy_until_, at) + faults_.slow;
    passing_.emplace(busy_until_, Passing{Direction::to_slow_device, passing.bytes});
}

bool FaultyLine::is_restarting(TimePoint at) const noexcept {
    return faults_.restart_after && at - start_ >= *faults_.restart_after &&
           at - start_ < *faults_.restart_after + time_to_restart;
}

// Restarts at the first frame, in either direction, after restart_after.
void FaultyLine::restart_if_due(TimePoint at) {
    if (has_restarted_ || !faults_.restart_after || at - start_ < *faults_.restart_after) return;
    has_restarted_ = true;
    device_->restart();
}

void FaultyLine::emit(Bytes frame, TimePoint at) {
    restart_if_due(at);
    if (!is_restarting(at)) put(frame, Direction::to_host, at, back_);
}

// Without the vendor's parser, damaged frames are dropped and do not affect the device.
void FaultyLine::receive(Bytes bytes, TimePoint at) {
    restart_if_due(at);
    const bool is_deaf = is_restarting(at) || (faults_.deaf_after && at - start_ >= *faults_.deaf_after);
    counters_.unheard += is_deaf;
    if (is_deaf) return;
    if (faults_.vendor_parser) parser_.feed(bytes, [&](Bytes frame) { device_->receive(frame, at, emit_); });
    else device_->receive(bytes, at, emit_);
}

}    // namespace ano::world
