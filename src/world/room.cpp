#include "room.hpp"

#include <ano/wire.hpp>

namespace ano::world {

Scan scan_from(Vector position, double yaw) noexcept {
    Scan scan{};
    for (std::size_t i = 0; i < scan.size() / 4; ++i) {
        const double clockwise = 10.0 * static_cast<double>(i);
        const double distance = 100 * to_the_wall(position, yaw - clockwise * degree);
        store(scan.data() + 4 * i, static_cast<std::uint16_t>(100 * clockwise));
        store(scan.data() + 4 * i + 2, static_cast<std::uint16_t>(std::lround(std::clamp(distance, 0.0, 65535.0))));
    }
    return scan;
}

}    // namespace ano::world
