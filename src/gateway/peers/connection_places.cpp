#include <gateway/peers/connection_places.hpp>

#include <algorithm>

namespace anogate {

ConnectionPlaces::Place ConnectionPlaces::place_for(std::span<const Connection> all, const IpAddress& stranger, bool is_trusted,
                                                    ano::TimePoint now) const {
    const auto count = [&](auto&& counts) { return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), counts)); };
    const auto is_of_address = [&](const Connection& c) { return c.address == stranger; };
    const auto is_ordinary = [](const Connection& c) { return !c.is_trusted; };
    const bool address_is_full = !stranger.is_loopback() && count(is_of_address) >= max_of_address;
    const bool is_full = all.size() >= max || (!is_trusted && count(is_ordinary) >= max - kept_for_trusted);
    if (!address_is_full && !is_full) return {true, {}};

    std::optional<std::size_t> oldest;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool may_go = !all[i].has_sent_frame && now - all[i].since >= silent_after && (is_trusted || is_ordinary(all[i])) &&
                            (!address_is_full || is_of_address(all[i]));
        if (may_go && (!oldest || all[i].since < all[*oldest].since)) oldest = i;
    }
    return {oldest.has_value(), oldest};
}

}    // namespace anogate
