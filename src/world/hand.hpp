// Turns a device as a person does for a calibration: onto its six faces, or in all directions.
#pragma once
#include "vector.hpp"

#include <cstddef>

namespace ano::world {

class Hand {
public:
    static constexpr std::size_t faces = 6;
    static constexpr double time_to_turn = 1;    // s, from one face to the next
    static constexpr unsigned rounds = 3;        // then it stops
    static constexpr double time_to_look = 8;    // s, on the last face of a round, for the person to check the result
    static constexpr double time_to_begin =
        3;    // s, on the last face before the first round: the host starts to measure this long after a clear

    /// Turns it to one face after the other and rests for `rest` seconds on each, on the last one longer.
    void turn_to_faces(double rest) noexcept;
    /// Turns it so that `field`, as seen from the device, points in all directions within `duration` seconds.
    void turn_all_round(Vector field, double duration) noexcept;
    /// Turns it to this face and leaves it there: x up, x down, y up, y down, z up, z down.
    void lay(std::size_t face) noexcept;
    /// Continues for a while, then turns it upright. On the faces: for one more round, preceded by `rest` and time_to_look on the
    /// last face of a round. In all directions: for at most a quarter of a round.
    void finish() noexcept;
    /// Turns it upright.
    void let_go() noexcept { does_ = Does::nothing; }

    bool holds() const noexcept { return does_ != Does::nothing; }
    /// The attitude `dt` seconds later.
    Attitude next(double dt) noexcept;

private:
    enum class Does : unsigned char { nothing, lies, faces, round };

    Attitude on_faces() const noexcept;
    Attitude all_round() const noexcept;
    double duration() const noexcept;    // of a round
    void begin(Does what) noexcept;

    Does does_ = Does::nothing;
    std::size_t face_ = 4;
    double rest_ = 0, round_ = 0, at_ = 0, until_ = 0;
    Vector field_;
};

}    // namespace ano::world
