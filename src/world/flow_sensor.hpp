// sim:flow. An optical flow sensor that looks down and moves in a circle.
#pragma once
#include "simulated_device.hpp"
#include "vector.hpp"

namespace ano::world {

class FlowSensor final : public SimulatedDevice {
public:
    static constexpr std::uint8_t usual_id = 0xDE;

    FlowSensor(const Settings& settings, TimePoint start);

private:
    void advance() override;
    void flow();
    double quality() const noexcept;

    std::uint16_t height_ = 100;    // cm
    std::uint16_t speed_ = 50;      // cm/s
    Vector velocity_;               // cm/s
    Vector way_;                    // cm
};

}    // namespace ano::world
