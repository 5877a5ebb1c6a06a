#include "inertial_unit.hpp"
#include "fill.hpp"

#include <algorithm>

namespace ano::world {

void InertialUnit::add_calibrations(device::Parameters& parameters, Hand& hand, unsigned hz, const Owner& owner) {
    using device::Action;
    constexpr double samples_of_a_face = 90, samples_all_round = 500;
    parameters.add_accelerometer_calibration(accelerometer_.calibration);
    parameters.add_compass_calibration(compass_.calibration);
    parameters.on(Action::clear_accelerometer, [&parameters, &hand, hz, may_be_turned = owner.may_be_turned] {
        if (may_be_turned()) hand.turn_to_faces(1 + samples_of_a_face / hz);
        return parameters.restore_defaults("CAL_A");
    });
    parameters.on(Action::clear_compass, [&parameters, &hand, hz, may_be_turned = owner.may_be_turned] {
        if (may_be_turned()) hand.turn_all_round(Compass::earth, samples_all_round / std::max(hz / 2, 1u));
        return parameters.restore_defaults("CAL_M");
    });
    for (const Action stored : {Action::store_accelerometer, Action::store_compass})
        parameters.on(stored, [&hand, store = owner.store] {
            hand.finish();
            return store();
        });
}

Draft<"inertial"> InertialUnit::inertial(Vector felt, Vector rates, Noise& chance) const noexcept {
    const Vector a = accelerometer_.corrected(accelerometer_.measure(felt, chance));
    const Vector turns = gyroscope_.measure(rates, chance);
    Draft<"inertial"> draft;
    fill<"acc_x">(draft, a.x);
    fill<"acc_y">(draft, a.y);
    fill<"acc_z">(draft, a.z);
    fill<"gyr_x">(draft, turns.x);
    fill<"gyr_y">(draft, turns.y);
    fill<"gyr_z">(draft, turns.z);
    return draft;
}

Draft<"compass"> InertialUnit::compass(const Attitude& attitude, Noise& chance) const noexcept {
    const Vector m = compass_.corrected(compass_.measure(attitude, chance));
    Draft<"compass"> draft;
    fill<"mag_x">(draft, m.x);
    fill<"mag_y">(draft, m.y);
    fill<"mag_z">(draft, m.z);
    fill<"tmp">(draft, 31 + 0.1 * chance.normal());
    fill<"mag_sta">(draft, 1);
    return draft;
}

}    // namespace ano::world
