#include <ano/address.hpp>
#include <runtime/gateway.hpp>
#include <runtime/route_rows.hpp>

namespace anogate {

std::vector<RouteRow> route_rows(const Gateway& gateway, TimePoint now) {
    const Router& router = gateway.forwarder().router();
    std::vector<RouteRow> rows;
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (address == gateway.settings().gateway.id) rows.push_back({address, {}, Via::own, {}});
        else if (const LinkSet port = router.port(address); !port.empty()) rows.push_back({address, port, Via::port, {}});
        else if (const LinkSet pinned = router.pinned(address); !pinned.empty())
            rows.push_back({address, pinned, Via::pinned, {}});
        else if (const Router::Learned learned = router.learned(address, now); !learned.links.empty())
            rows.push_back({address, learned.links, Via::learned, learned.last});
    }
    return rows;
}

}    // namespace anogate
