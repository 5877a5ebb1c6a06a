// A snapshot of the figures of a link, for the status, the metrics and the log.
#pragma once
#include <ano/time.hpp>
#include <gateway/hints.hpp>
#include <link/link_error.hpp>

#include <cstddef>

namespace anogate {

class Gateway;
struct LinkState;

/// The counters are sums over its channels, its former channels, and the traffic that belonged to no channel.
struct LinkReport {
    LinkFigures figures;    // its strings refer to the gateway: valid as long as the links
    std::size_t waiting = 0;
    LinkError error{};    // the reason why the link is down, or its fault; empty text: none
    Hint hint{};          // empty text: none
};
LinkReport report_of(const Gateway& gateway, const LinkState& state, ano::TimePoint now);

}    // namespace anogate
