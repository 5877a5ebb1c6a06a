// Makes the description of a configured link for the Forwarder.
#pragma once
#include <gateway/forwarder_link.hpp>
#include <gateway/settings.hpp>

namespace anogate {

/// `group`: the number of its group, 0: none. `aliases`: those of all links.
ForwarderLink forwarder_link(const LinkSettings& link, std::uint8_t group, const std::vector<AliasSettings>& aliases);

}    // namespace anogate
