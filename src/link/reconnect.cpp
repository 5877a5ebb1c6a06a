#include <link/link_context.hpp>
#include <link/reconnect.hpp>

namespace anogate {

Reconnect::Reconnect(AlarmClock& alarms, std::function<ano::TimePoint()> now, Open open, Down down)
    : now_{std::move(now)}, open_{std::move(open)}, down_{std::move(down)}, retry_{alarms, [this] { try_now(); }, retry_slack} {}

Reconnect::Reconnect(const LinkContext& context, Link& link, Open open)
    : Reconnect{context.alarms, [&host = context.host] { return host.now(); }, std::move(open),
                [&host = context.host, &link](LinkError why) { host.link_down(link, std::move(why)); }} {}

void Reconnect::start() {
    stopped_ = false;
    try_now();
}

void Reconnect::stop() noexcept {
    stopped_ = true;
    retry_.cancel();
}

void Reconnect::try_now() {
    if (stopped_) return;
    retry_.cancel();
    if (auto begun = open_(); !begun) lost(std::move(begun.error()));
}

void Reconnect::try_soon() {
    if (!stopped_) retry_.set(now_());
}

void Reconnect::lost(LinkError why) {
    const ano::TimePoint next = backoff_.retry_at(now_());
    if (!stopped_) retry_.set(next);
    down_(std::move(why));
}

}    // namespace anogate
