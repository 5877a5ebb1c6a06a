// What a receiver of satellites says of where the world's vehicle is: near the truth, with an error that wanders slowly.
#pragma once
#include "noise.hpp"
#include "vector.hpp"

#include <ano/typed.hpp>

#include <cstdint>

namespace ano::world {

/// A place on the earth. Degrees, WGS 84; east and north are positive.
struct Place {
    double lng = 0, lat = 0;
};

/// Metres of a degree of latitude, and of longitude at the equator; the world is flat, and near its home.
inline constexpr double metres_of_a_degree = 111'319.5;

/// Where `place` is from `home`: metres to the north and to the west, and 0.
Vector from_home(Place place, Place home) noexcept;
/// The other way round. Only x and y of `there` count.
Place on_earth(Vector there, Place home) noexcept;

class Satellites {
public:
    static constexpr unsigned rate = 5;          // frames a second
    static constexpr double ground = 44;         // m, home above the sea
    static constexpr double wanders = 0.4;       // m, standard deviation of the error to each side; upwards twice that
    static constexpr double wanders_for = 30;    // s, after which the error is another

    /// The same seed, the same errors.
    explicit Satellites(std::uint64_t seed) noexcept;
    /// Once every 1 / rate seconds: a position in metres from `home` and a velocity in m/s, both to the north, to the west and up.
    Draft<"gps"> look(Vector position, Vector velocity, Place home) noexcept;

private:
    Noise chance_;
    Vector error_;
    double seen_ = 14;    // satellites
};

}    // namespace ano::world
