#include <gateway/channel.hpp>

namespace anogate {

ReceiveCounters Channel::received() const noexcept {
    ReceiveCounters all = routed;
    add(all, beside);
    add(all, parser.counters());
    return all;
}

}  // namespace anogate
