#include <gateway/simulated_setup.hpp>

#include <cstddef>
#include <utility>

namespace anogate {
namespace {

using ano::device::LogColor;
using ano::device::Parameter;
using ano::device::Value;

constexpr std::uint64_t serial = 0xA0'0000'0001;
constexpr std::uint16_t lowest = 20, highest = 10'000;    // cm
constexpr std::size_t waypoints = 50;

Parameter fixed(std::string name, std::uint64_t value) {
    Parameter row;
    row.name = std::move(name);
    row.type = ano::Type::u64;
    row.initial = value;
    row.get = [value] { return Value{value}; };
    row.info = "can't be written";
    return row;
}

}    // namespace

SimulatedSetup::SimulatedSetup(ano::device::Device& device) : device_{device} {
    add_parameters();
    add_commands();
    device_.waypoints().allow(waypoints);
    device_.waypoints().resize(1);
    ano::device::Waypoint home;
    home.lng = home_lng_;
    home.lat = home_lat_;
    device_.waypoints().set(0, home);
}

void SimulatedSetup::add_parameters() {
    auto& parameters = device_.parameters();
    parameters.add("SIM_MODE", mode_, {.info = "flight mode", .max = 3});
    parameters.add("SIM_TURN", turn_, {.info = "how fast it turns, degrees a second", .min = -90, .max = 90});
    parameters.add("SIM_HEIGHT", height_, {.info = "where it hovers, cm", .min = lowest, .max = highest});
    parameters.add("SIM_BAR_OFFSET", barometer_offset_, {.info = "what the barometer is off by, cm", .min = -1000, .max = 1000});
    parameters.add("SIM_FLIGHT_TIME", flight_time_, {.info = "until the battery is empty, s", .min = 60, .max = 86'400});
    parameters.add("SIM_RANGE_OFFSET", range_offset_, {.info = "what the range finder is off by, cm", .min = -1000, .max = 1000});
    parameters.add(fixed("SIM_SERIAL", serial));
    parameters.add("SIM_BORN", born_, {.info = "seconds since 1970"});
    parameters.add("SIM_SWAY", sway_, {.info = "how far it sways, degrees", .min = 0, .max = 30});
    parameters.add("SIM_HOME_LNG", home_lng_, {.info = "degrees", .min = -180, .max = 180});
    parameters.add("SIM_HOME_LAT", home_lat_, {.info = "degrees", .min = -90, .max = 90});
    parameters.add("SIM_NOTE", note_, {.info = "anything", .max_size = 29});
    parameters.add_accelerometer_calibration(accelerometer_);
    parameters.add_compass_calibration(compass_);
    parameters.on_save([] { return true; });    // it has no other memory than this
}

void SimulatedSetup::add_commands() {
    auto& commands = device_.commands();
    commands.add({0x10, 0, 1}, "TAKE_OFF", "height in cm", [this](std::uint16_t height) {
        if (height < lowest || height > highest) return false;
        height_ = height;
        flies_ = true;
        device_.log("took off", LogColor::green);
        return true;
    });
    commands.add({0x10, 0, 2}, "LAND", "", [this] {
        flies_ = false;
        device_.log("landed", LogColor::green);
    });
    commands.add({0x10, 0, 3}, "TURN", "degrees a second", [this](std::int8_t turn) { turn_ = turn; });
    commands.add({0x10, 0, 4}, "BORN", "seconds since 1970", [this](std::int64_t seconds) { born_ = seconds; });
    commands.add({0x10, 0, 5}, "ADD", "tells the sum of its values",
                 [this](std::uint8_t a, std::int8_t b, std::uint16_t c, std::int16_t d, std::uint32_t e, std::int32_t f, float g,
                        double h) {
                     device_.log(static_cast<float>(a + b + c + d + static_cast<double>(e) + f + static_cast<double>(g) + h),
                                 "is the sum");
                 });
}

std::array<double, 3> SimulatedSetup::corrected(std::array<double, 3> raw) const noexcept {
    std::array<double, 3> scaled{}, result{};
    for (std::size_t i = 0; i < 3; ++i) scaled[i] = (raw[i] - accelerometer_[i]) * accelerometer_[3 + i];
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t i = 0; i < 3; ++i) result[row] += scaled[i] * accelerometer_[6 + 3 * row + i];
    return result;
}

}    // namespace anogate
