#include "satellites.hpp"
#include "fill.hpp"

#include <algorithm>
#include <cmath>

namespace ano::world {
namespace {

Vector chance_vector(Noise& chance) noexcept {
    const double x = chance.normal(), y = chance.normal(), z = chance.normal();    // drawn in this order with every compiler
    return {x, y, 2 * z};
}

}    // namespace

Vector from_home(Place place, Place home) noexcept {
    return {(place.lat - home.lat) * metres_of_a_degree,
            (home.lng - place.lng) * metres_of_a_degree * std::cos(home.lat * degree), 0};
}

Place on_earth(Vector there, Place home) noexcept {
    return {home.lng - there.y / (metres_of_a_degree * std::cos(home.lat * degree)), home.lat + there.x / metres_of_a_degree};
}

Satellites::Satellites(std::uint64_t seed) noexcept : chance_{seed}, error_{wanders * chance_vector(chance_)} {}

Draft<"gps"> Satellites::look(Vector position, Vector velocity, Place home) noexcept {
    constexpr double keeps = 1 - 1 / (rate * wanders_for), speed_error = 0.05;    // m/s
    constexpr double min_seen = 11, max_seen = 18, fix_in_three_dimensions = 3;
    error_ = keeps * error_ + wanders * std::sqrt(1 - keeps * keeps) * chance_vector(chance_);
    seen_ = std::clamp(seen_ + 0.2 * chance_.normal(), min_seen, max_seen);
    const Vector seen = position + error_, moves = velocity + speed_error * chance_vector(chance_);
    const Place place = on_earth(seen, home);
    Draft<"gps"> draft;
    fill<"fix_sta">(draft, fix_in_three_dimensions);
    fill<"s_num">(draft, seen_);
    fill<"lng">(draft, place.lng);
    fill<"lat">(draft, place.lat);
    fill<"alt_gps">(draft, 100 * (ground + seen.z));
    fill<"n_spe">(draft, 100 * moves.x);
    fill<"e_spe">(draft, -100 * moves.y);
    fill<"d_spe">(draft, -100 * moves.z);
    fill<"pdop">(draft, 20 / seen_);
    fill<"sacc">(draft, 300);
    fill<"vacc">(draft, 900);
    return draft;
}

}    // namespace ano::world
