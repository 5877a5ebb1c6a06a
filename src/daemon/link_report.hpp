// What is known of a link at a moment, for the status, the metrics and the log.
#pragma once
#include <ano/time.hpp>
#include <gateway/hints.hpp>

#include <cstddef>

namespace anogate {

class Gateway;
struct LinkState;

/// Its counters are those of its channels, of channels that are gone, and of what never belonged to one.
struct LinkReport {
    LinkFigures figures;    // its names are the gateway's: valid as long as the links are
    std::size_t waiting = 0;
};
LinkReport report_of(const Gateway& gateway, const LinkState& state, ano::TimePoint now);

}    // namespace anogate
