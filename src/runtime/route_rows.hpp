// The present route of each address.
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>
#include <gateway/router.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace anogate {

class Gateway;

struct RouteRow {
    std::uint8_t address = 0;
    LinkSet links;
    Via via = Via::nobody;
    std::optional<ano::TimePoint> heard_at;    // of a learned route
};

/// One row for each address with a route, with the rule that applies.
std::vector<RouteRow> route_rows(const Gateway& gateway, ano::TimePoint now);

}    // namespace anogate
