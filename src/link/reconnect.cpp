#include <link/link_context.hpp>
#include <link/reconnect.hpp>
#include <sys/descriptors_left.hpp>

#include <random>

namespace anogate {
namespace {

constexpr std::size_t descriptors_of_one_link = 4;    // the most that a link opens at once: a pty

}    // namespace

Reconnect::Reconnect(AlarmClock& alarms, std::function<ano::TimePoint()> now, Open open, Down down, ano::Duration longest)
    : now_{std::move(now)},
      open_{std::move(open)},
      down_{std::move(down)},
      backoff_{longest},
      varies_{longest > Backoff::cap},
      retry_{alarms, [this] { try_now(); }, retry_slack} {}

Reconnect::Reconnect(const LinkContext& context, Link& link, Open open, ano::Duration longest)
    : Reconnect{context.alarms, [&host = context.host] { return host.now(); }, std::move(open),
                [&host = context.host, &link](LinkError why) { host.link_down(link, std::move(why)); }, longest} {}

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
    if (descriptors_left() < descriptors_of_one_link) return lost(no_descriptor());
    if (auto begun = open_(); !begun) lost(std::move(begun.error()));
}

void Reconnect::try_soon() {
    if (!stopped_) retry_.set(now_());
}

void Reconnect::lost(LinkError why) {
    const ano::TimePoint now = now_();
    ano::TimePoint next = backoff_.retry_at(now);
    if (varies_) next -= (next - now) * (std::random_device{}() % 512) / 1024;
    if (!stopped_) retry_.set(next);
    down_(std::move(why));
}

}    // namespace anogate
