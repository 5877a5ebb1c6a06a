// What the Forwarder has to know of a configured link.
#pragma once
#include <gateway/forwarder_link.hpp>
#include <gateway/settings.hpp>

namespace anogate {

/// `group` is the number of its group, 0: none; `aliases` those of every link.
ForwarderLink forwarder_link(const LinkSettings& link, std::uint8_t group, const std::vector<AliasSettings>& aliases);

}    // namespace anogate
