// Many alarms on one timer: the process wakes up once for all alarms that are due at about the same time.
#pragma once
#include <ano/time.hpp>
#include <sys/asio_fwd.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace anogate {

class Alarm;

/// The timer used by all Alarms of a loop. Must outlive them.
class AlarmClock {
public:
    explicit AlarmClock(asio::io_context& io);
    ~AlarmClock();
    AlarmClock(const AlarmClock&) = delete;
    AlarmClock& operator=(const AlarmClock&) = delete;

private:
    friend class Alarm;
    void arm(ano::TimePoint latest);
    void wait(ano::TimePoint latest);
    void ring_next();
    void ring();
    void remove(Alarm* alarm) noexcept;

    struct Timer;
    asio::io_context& io_;
    std::shared_ptr<Timer> timer_;    // expires with this object; posted handlers check it
    std::vector<Alarm*> alarms_;
    std::optional<ano::TimePoint> rings_at_;
    std::uint64_t generation_ = 0;
    bool ringing_ = false;
    bool rings_next_ = false;    // a ring() is posted
};

/// Calls its function once, between the set time and `slack` later; a slack lets alarms share one wake-up. Setting it again
/// replaces the time; destruction and cancel() cancel it.
class Alarm {
public:
    Alarm(AlarmClock& clock, std::function<void()> call, ano::Duration slack = {});
    ~Alarm();
    Alarm(const Alarm&) = delete;
    Alarm& operator=(const Alarm&) = delete;

    void set(ano::TimePoint at);
    /// Sets it, unless it is already set to an earlier time.
    void set_no_later(ano::TimePoint at) {
        if (!at_ || at < *at_) set(at);
    }
    /// If it is set, makes it due at once: it rings after the current handler of the loop, without an extra wake-up.
    void hurry();
    void cancel() noexcept { at_.reset(); }
    bool is_set() const noexcept { return at_.has_value(); }
    /// Whether it is set to `time` or earlier.
    bool is_due(ano::TimePoint time) const noexcept { return at_ && *at_ <= time; }

private:
    friend class AlarmClock;
    AlarmClock& clock_;
    std::function<void()> call_;
    ano::Duration slack_;
    std::optional<ano::TimePoint> at_;
};

}    // namespace anogate
