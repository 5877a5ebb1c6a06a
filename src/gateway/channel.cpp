#include <gateway/channel.hpp>

namespace anogate {

ReceiveCounters Channel::received() const noexcept {
    ReceiveCounters all = routed;
    const ano::ParserCounters& parsed = parser.counters();
    all.frames_in += parsed.frames_in;
    all.bytes_in += parsed.bytes_in;
    all.bad_check += parsed.bad_check;
    all.bad_length += parsed.bad_length;
    all.skipped_bytes += parsed.skipped_bytes;
    all.expired += parsed.expired;
    return all;
}

}  // namespace anogate
