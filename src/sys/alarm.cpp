#include <sys/alarm.hpp>
#include <sys/asio.hpp>

#include <algorithm>

namespace anogate {

struct AlarmClock::Timer : asio::steady_timer {
    using asio::steady_timer::steady_timer;
};

AlarmClock::AlarmClock(asio::io_context& io) : io_{io}, timer_{std::make_shared<Timer>(io)} {}

AlarmClock::~AlarmClock() = default;

// ring() sets the timer once at its end.
void AlarmClock::arm(ano::TimePoint latest) {
    if (!ringing_ && (!rings_at_ || latest < *rings_at_)) wait(latest);
}

void AlarmClock::wait(ano::TimePoint latest) {
    rings_at_.reset();    // until async_wait() has succeeded: it may throw for lack of memory
    timer_->expires_at(latest);
    timer_->async_wait([this, mine = ++generation_](error_code ec) {
        if (ec || mine != generation_) return;
        rings_at_.reset();
        ring();
    });
    rings_at_ = latest;
}

void AlarmClock::ring_next() {
    if (rings_next_) return;
    asio::post(io_, [this, clock = std::weak_ptr{timer_}] {
        if (clock.expired()) return;
        rings_next_ = false;
        ring();
    });
    rings_next_ = true;
}

void AlarmClock::ring() {
    const ano::TimePoint now = ano::Clock::now();
    // A call may create and destroy alarms: each step reads alarms_ again, and no element moves.
    ringing_ = true;
    for (std::size_t i = 0; i < alarms_.size(); ++i) {
        Alarm* alarm = alarms_[i];
        if (!alarm || !alarm->at_ || *alarm->at_ > now) continue;
        alarm->at_.reset();
        alarm->call_();
    }
    ringing_ = false;
    std::erase(alarms_, nullptr);
    std::optional<ano::TimePoint> next;
    for (const Alarm* alarm : alarms_)
        if (alarm->at_) next = std::min(next.value_or(ano::TimePoint::max()), *alarm->at_ + alarm->slack_);
    if (next && next != rings_at_) wait(*next);    // also if later: setting it costs less than a needless wake-up
}

void AlarmClock::remove(Alarm* alarm) noexcept {
    const auto place = std::find(alarms_.begin(), alarms_.end(), alarm);
    if (ringing_) *place = nullptr;
    else alarms_.erase(place);
    if (std::any_of(alarms_.begin(), alarms_.end(), [](Alarm* a) { return a && a->at_; })) return;
    ++generation_;
    rings_at_.reset();
    timer_->cancel();
}

Alarm::Alarm(AlarmClock& clock, std::function<void()> call, ano::Duration slack)
    : clock_{clock}, call_{std::move(call)}, slack_{slack} {
    clock_.alarms_.push_back(this);
}

Alarm::~Alarm() { clock_.remove(this); }

void Alarm::set(ano::TimePoint at) {
    at_ = at;
    clock_.arm(at + slack_);
}

void Alarm::hurry() {
    if (!at_) return;
    at_ = std::min(*at_, ano::Clock::now());
    clock_.ring_next();
}

}    // namespace anogate
