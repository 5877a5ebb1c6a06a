// Opens something that may be absent or lost: retries until it works, and again after each loss.
#pragma once
#include <ano/time.hpp>
#include <gateway/backoff.hpp>
#include <link/link_error.hpp>
#include <sys/alarm.hpp>

#include <functional>
#include <string>

namespace anogate {

class Link;
struct LinkContext;

/// A retry may be this much later than Backoff computes, so that all absent devices share one wake-up per second.
inline constexpr ano::Duration retry_slack = std::chrono::milliseconds{250};

/// Flow:    start()       → open → came_up()      // called by the user, at once or when the connection is established
///                               → or the error   // then `down` is called, and open again later
///          lost(why)     → down, and open again later
///          stop()        → nothing is opened any more
class Reconnect {
public:
    /// Begins to open, or returns why that is not possible now. Not called while only descriptors for the gateway's own work are left.
    using Open = std::function<Opened<void>()>;
    /// Called after each failed try, and when the connection is lost.
    using Down = std::function<void(LinkError why)>;

    Reconnect(AlarmClock& alarms, std::function<ano::TimePoint()> now, Open open, Down down,
              ano::Duration longest = Backoff::cap);
    /// For a link: `down` is LinkHost::link_down(). With a `longest` pause above Backoff::cap, pauses are randomized, so that
    /// clients of one lost peer do not reconnect at the same time.
    Reconnect(const LinkContext& context, Link& link, Open open, ano::Duration longest = Backoff::cap);

    void start();
    /// No calls afterwards, except `down` from lost().
    void stop() noexcept;

    /// Opens without waiting for the next retry. Only while it is not open.
    void try_now();
    /// The same as try_now(), within `retry_slack`.
    void try_soon();

    void came_up(ano::TimePoint now) noexcept { backoff_.came_up(now); }
    /// To be called when the connection is lost, or when an opening that open() began has failed.
    void lost(LinkError why);

private:
    std::function<ano::TimePoint()> now_;
    Open open_;
    Down down_;
    Backoff backoff_;
    bool varies_;
    Alarm retry_;
    bool stopped_ = true;
};

}    // namespace anogate
