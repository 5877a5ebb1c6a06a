// The layouts of flexible messages that a running gateway uses.
#pragma once
#include "gateway.hpp"

#include <ano/flexible.hpp>

#include <vector>

namespace anoctl {

/// Throws Failure when there is no gateway; an older one has none.
std::vector<ano::FlexibleSpec> layouts_of_gateway(const GatewayOptions& gateway);

}    // namespace anoctl
