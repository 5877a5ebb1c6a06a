#include <ano/conversation.hpp>
#include <host/exchange.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {

Exchange::Exchange(const Request& request, std::uint8_t own, std::uint8_t device, Asker* asker)
    : frame_(overhead + request.data.size()),
      patience_{request.patience},
      asker_{asker},
      tag_{request.tag},
      urgent_{request.urgent},
      of_same_{request.of_same},
      needs_info_{request.needs_info},
      compares_info_{request.compares_info},
      present_device_{request.present_device},
      identity_{request.identity.value_or(Identity{})} {
    if (encode(frame_, own, device, request.id, request.data) == 0) return;
    expects_ = Expectation::of(frame());
    acts_ = intent_of(frame()) == Intent::acts;
}

void Exchange::send(TimePoint now, const RoundTrip& round_trip, const Send& send) noexcept {
    if (sent_ == 0) {
        first_sent_ = now;
        first_number_ = send.number;
    }
    last_sent_ = now;
    last_ = send;
    known_ = round_trip.smoothed().has_value();
    due_ = now + patience_.if_heard.value_or(wait_for_answer(now, round_trip, send));
    if (now < flush_at_) due_ = std::min(due_, flush_at_);
    waits_on_ = false;
    ++sent_;
    on_its_way_ = true;
    was_kept_ = false;
    passes_ = false;
}

Duration Exchange::wait_for_answer(TimePoint now, const RoundTrip& round_trip, const Send& send) const noexcept {
    if (patience_.wait) return *patience_.wait;
    if (asks_often(round_trip.smoothed().has_value())) return std::max(patience_.at_least, RoundTrip::first);
    const Duration wait = std::max(patience_.at_least, round_trip.time_out_after(sent_, send.answers, send.others == 0));
    const bool is_late = was_sent() && now - first_sent_ - kept_for_ >= Patience::repeated_for;
    return patience_.if_late > Duration::zero() && is_late ? std::max(wait, Patience::late_interval) : wait;
}

bool Exchange::waits_on(std::optional<TimePoint> heard_at) noexcept {
    if (!patience_.if_heard || !patience_.wait || std::exchange(waits_on_, true)) return false;
    if (heard_at && *heard_at > last_sent_ + *patience_.if_heard / 2) return false;
    due_ = last_sent_ + *patience_.wait;
    return true;
}

bool Exchange::keep(TimePoint now, Duration time) noexcept {
    if (std::exchange(was_kept_, true)) return false;
    kept_until_ = now + time;
    kept_for_ += time;
    return true;
}

void Exchange::wait_to_leave(TimePoint now) noexcept {
    const Duration late = now - last_sent_;
    if (late <= Duration::zero()) return;
    due_ += late;
    last_sent_ = now;
    if (sent_ == 1) first_sent_ = now;
}

}    // namespace ano::host
