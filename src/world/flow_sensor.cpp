#include "flow_sensor.hpp"

namespace ano::world {
namespace {

// `number` as an i16 that wraps around.
double wrapped_i16(double number) noexcept { return static_cast<std::int16_t>(static_cast<std::int64_t>(number) & 0xFFFF); }

}    // namespace

FlowSensor::FlowSensor(const Settings& settings, TimePoint start)
    : SimulatedDevice{{.id = settings.id != 0 ? settings.id : usual_id, .name = "SimFlow"}, settings, start} {
    auto& parameters = device().parameters();
    parameters.add("SIM_HEIGHT", height_, {.info = "above ground, cm", .min = 8, .max = 1000});
    parameters.add("SIM_SPEED", speed_, {.info = "speed at which it is carried, cm/s", .min = 0, .max = 500});
    parameters.on_save([this] { return store_values(); });
    every(at_rate(hz()), [this] { flow(); });
    every(at_rate(hz() / 2), [this] {
        Draft<"ranging"> down;
        fill<"dist">(down, 10.0 * height_ + 5 * chance().normal());
        emit(down);
    });
}

void FlowSensor::advance() {
    const double angle = 0.5 * time();
    velocity_ = static_cast<double>(speed_) * Vector{std::cos(angle), std::sin(angle), 0};
    way_ = way_ + dt * velocity_;
}

// The quality is full up to four metres.
double FlowSensor::quality() const noexcept { return std::clamp(255 - std::max(height_ - 400, 0) / 3.0, 0.0, 255.0); }

void FlowSensor::flow() {
    constexpr double pixels = 400;    // per radian and 20 ms
    const Vector seen = velocity_ + Vector{2 * chance().normal(), 2 * chance().normal(), 0};
    const double is_valid = quality() > 100 ? 1 : 0;
    Draft<"optical_flow"> raw;
    fill<"state">(raw, is_valid);
    fill<"dx_0">(raw, pixels * 0.02 * seen.x / height_);
    fill<"dy_0">(raw, pixels * 0.02 * seen.y / height_);
    fill<"quality">(raw, quality());
    emit(raw);
    Draft<"optical_flow", "mode1"> fused;
    fill<"state">(fused, is_valid);
    fill<"dx_1">(fused, seen.x);
    fill<"dy_1">(fused, seen.y);
    fill<"quality">(fused, quality());
    emit(fused);
    Draft<"optical_flow", "mode2"> with_inertia;
    fill<"state">(with_inertia, is_valid);
    fill<"dx_2">(with_inertia, seen.x);
    fill<"dy_2">(with_inertia, seen.y);
    fill<"dx_fix">(with_inertia, velocity_.x);
    fill<"dy_fix">(with_inertia, velocity_.y);
    fill<"integ_x">(with_inertia, wrapped_i16(way_.x));
    fill<"integ_y">(with_inertia, wrapped_i16(way_.y));
    fill<"quality">(with_inertia, quality());
    emit(with_inertia);
}

}    // namespace ano::world
