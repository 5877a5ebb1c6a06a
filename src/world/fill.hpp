// Sets the fields of messages of simulated devices, limited to the range of the field.
#pragma once
#include <ano/typed.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ano::world {

template <class Draft, Name F>
consteval const Field& field_of() {
    for (const Field& field : Draft::message().fields())
        if (field.name == F.view()) return field;
    table_error::the_layout_has_no_such_field();
    return Draft::message().fields().front();
}

/// The nearest number that the field can represent; 0 for NaN.
template <Name F, class Draft>
void fill(Draft& draft, double value) noexcept {
    constexpr const Field& field = field_of<Draft, F>();
    constexpr double steps = field.scale.wire / field.scale.value;
    const double wire = with_type(field.type, [&]<class T>(T) {
        if constexpr (std::is_floating_point_v<T>) return value * steps;
        else
            return std::clamp(std::round(value * steps), static_cast<double>(std::numeric_limits<T>::lowest()),
                              static_cast<double>(std::numeric_limits<T>::max()));
    });
    static_cast<void>(draft.template set<F>(std::isnan(wire) ? 0.0 : wire / steps));
}

}    // namespace ano::world
