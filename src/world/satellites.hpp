// A satellite receiver: the position of the vehicle with an error that changes slowly.
#pragma once
#include "noise.hpp"
#include "vector.hpp"

#include <ano/typed.hpp>

#include <cstdint>

namespace ano::world {

/// A place on the Earth in degrees, WGS 84; east and north are positive.
struct Place {
    double lng = 0, lat = 0;
};

/// Metres per degree of latitude, and of longitude at the equator. The simulated world is flat.
inline constexpr double metres_of_a_degree = 111'319.5;

/// The position of `place` relative to `home`: metres to the north, to the west, and 0.
Vector from_home(Place place, Place home) noexcept;
/// The inverse of from_home(). Only x and y of `there` are used.
Place on_earth(Vector there, Place home) noexcept;

class Satellites {
public:
    static constexpr unsigned rate = 5;          // frames per second
    static constexpr double ground = 44;         // m, altitude of home above sea level
    static constexpr double wanders = 0.4;       // m, standard deviation of the horizontal error; the vertical one is twice that
    static constexpr double wanders_for = 30;    // s, time constant of the error

    /// The same seed gives the same errors.
    explicit Satellites(std::uint64_t seed) noexcept;
    /// To be called every 1 / rate seconds, with a position in metres from `home` and a velocity in m/s, both to the north, to
    /// the west and up.
    Draft<"gps"> look(Vector position, Vector velocity, Place home) noexcept;

private:
    Noise chance_;
    Vector error_;
    double seen_ = 14;    // number of satellites
};

}    // namespace ano::world
