#include <host/exchange.hpp>

#include <algorithm>

namespace ano::host {

Exchange::Exchange(const Request& request, std::uint8_t own, std::uint8_t device, Asker* asker)
    : frame_(overhead + request.data.size()), patience_{request.patience}, asker_{asker}, tag_{request.tag} {
    if (encode(frame_, own, device, request.id, request.data) != 0) expects_ = Expectation::of(frame());
}

void Exchange::send(TimePoint now, const RoundTrip& round_trip) noexcept {
    if (sent_ == 0) first_sent_ = now;
    due_ = now + patience_.wait.value_or(std::max(patience_.at_least, round_trip.time_out_after(sent_)));
    ++sent_;
    on_its_way_ = true;
}

}    // namespace ano::host
