// The layouts of flexible messages that a running gateway uses.
#pragma once
#include "gateway.hpp"

#include <ano/flexible.hpp>

#include <vector>

namespace anoctl {

/// Empty for an older gateway, which has no such route. Throws Failure if there is no gateway.
std::vector<ano::FlexibleSpec> layouts_of_gateway(const GatewayOptions& gateway);

}    // namespace anoctl
