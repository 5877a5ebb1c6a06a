// sim:radio. A data radio, with measurements of its radio link.
#pragma once
#include "simulated_device.hpp"

namespace ano::world {

class Radio final : public SimulatedDevice {
public:
    Radio(const Settings& settings, TimePoint start);

    /// The strength of the received signal, dBm.
    double strength() const noexcept { return strength_; }

private:
    void advance() override;
    void figures();

    std::uint8_t power_ = 20;    // dBm
    std::uint8_t channel_ = 6;
    std::uint32_t distance_ = 200;    // m, to the other radio
    std::uint16_t port_ = 12333;
    double strength_ = -60, fading_ = 0;
    bool was_poor_ = false;
};

}    // namespace ano::world
