#include "radio.hpp"

#include <cmath>

namespace ano::world {
namespace {

constexpr double noise_floor = -100, poor = -90;    // dBm

}    // namespace

Radio::Radio(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : address::data_radio, .name = "SimRadio"}, settings, start} {
    auto& parameters = device().parameters();
    parameters.add("RF_POWER", power_, {.info = "dBm", .min = 0, .max = 27});
    parameters.add("RF_CHANNEL", channel_, {.info = "", .min = 1, .max = 13});
    parameters.add("IP_PORT", port_, {.info = "port of its data", .min = 1, .max = {}});
    parameters.add("SIM_DISTANCE", distance_, {.info = "distance to the other side, m", .min = 1, .max = 100'000});
    parameters.on_save([this] { return store_values(); });
    every(at_rate(hz() / 10), [this] { figures(); });
    every(at_rate(1), [this] {
        Draft<"power"> power;
        fill<"voltage">(power, 5.02 + 0.01 * chance().normal());
        fill<"current">(power, 0.2 + 0.02 * power_);
        emit(power);
    });
}

// Path loss at 2.4 GHz in free space, with slow fading.
void Radio::advance() {
    fading_ += dt * (-fading_ + 20 * chance().normal());
    strength_ = power_ - 40.0 - 20 * std::log10(distance_) + fading_;
}

// As a layout:
// {"id": "0xFA", "fields": [{"name": "strength", "type": "i8", "unit": "dBm"}, {"name": "noise", "type": "i8", "unit": "dBm"},
//  {"name": "lost", "type": "u8", "unit": "%"}]}
void Radio::figures() {
    const auto as_i8 = [](double value) {
        return static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(std::clamp(value, -128.0, 127.0))));
    };
    const double above = strength_ - noise_floor;
    const double lost = 100 / (1 + std::exp(above - 8));
    const std::array<std::uint8_t, 3> data{as_i8(strength_), as_i8(noise_floor + chance().normal()),
                                           static_cast<std::uint8_t>(std::lround(lost))};
    emit_flexible(id_of<"flexible10">, data);
    const bool is_poor = strength_ < poor;
    if (is_poor && !was_poor_) device().log(static_cast<float>(strength_), "dBm: the link is poor");
    was_poor_ = is_poor;
}

}    // namespace ano::world
