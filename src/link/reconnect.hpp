// Opens what may be absent or go: now, again for as long as that fails, and whenever it has gone.
#pragma once
#include <ano/time.hpp>
#include <gateway/backoff.hpp>
#include <link/alarm.hpp>
#include <link/link_error.hpp>

#include <functional>
#include <string>

namespace anogate {

class Link;
struct LinkContext;

/// A retry may come this much later than Backoff says: the absent devices of a whole vehicle share one wake-up a second.
inline constexpr ano::Duration retry_slack = std::chrono::milliseconds{250};

/// Flow:    start()       → open → came_up()      // by whoever opens, at once or when the connection stands
///                               → or why not     // then `down` is called, and open again later
///          lost(why)     → down, and open again later
///          stop()        → nothing is opened any more
class Reconnect {
public:
    /// Begins to open, or says why that can't be done now.
    using Open = std::function<Opened<void>()>;
    /// It is not open, or no longer. After each try that fails.
    using Down = std::function<void(LinkError why)>;

    Reconnect(AlarmClock& alarms, std::function<ano::TimePoint()> now, Open open, Down down);
    /// Of a link, whose host is told.
    Reconnect(const LinkContext& context, Link& link, Open open);

    void start();
    /// No call comes after it, but what lost() says.
    void stop() noexcept;

    /// Opens without waiting for the next try. Only while it is not open.
    void try_now();
    /// The same within `retry_slack`.
    void try_soon();

    void came_up(ano::TimePoint now) noexcept { backoff_.came_up(now); }
    /// It has gone, or what open() had begun came to nothing.
    void lost(LinkError why);

private:
    std::function<ano::TimePoint()> now_;
    Open open_;
    Down down_;
    Backoff backoff_;
    Alarm retry_;
    bool stopped_ = true;
};

}    // namespace anogate
