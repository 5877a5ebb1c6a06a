#include <gateway/channel.hpp>

namespace anogate {

ReceiveCounters Channel::received() const noexcept {
    ReceiveCounters all = routed;
    add(all, beside);
    add(all, parser.counters());
    return all;
}

SendCounters Channel::sent() const noexcept {
    SendCounters all = outbox.counters();
    if (questions) add(all, questions->counters());
    return all;
}

std::size_t Channel::waiting() const noexcept { return outbox.waiting() + (questions ? questions->waiting() : 0); }

}    // namespace anogate
