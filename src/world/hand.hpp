// A hand that turns a device for a calibration: onto its six faces, or in all directions.
#pragma once
#include "vector.hpp"

#include <cstddef>

namespace ano::world {

class Hand {
public:
    static constexpr std::size_t faces = 6;
    static constexpr double time_to_turn = 1;    // s, from one face to the next
    static constexpr unsigned rounds = 3;        // then it gives up
    static constexpr double time_to_look = 8;    // s, on the last face of a round: is it enough?
    static constexpr double time_to_begin =
        3;    // s, on the last face before the first round: the host measures so late behind a clear

    /// Lays it on one face after the other, for `rest` seconds each, on the last one for longer.
    void turn_to_faces(double rest) noexcept;
    /// Turns it so that `field`, as seen from the device, points in all directions within `duration` seconds.
    void turn_all_round(Vector field, double duration) noexcept;
    /// Lays it on this face and leaves it there: x up, x down, y up, y down, z up, z down.
    void lay(std::size_t face) noexcept;
    /// Goes on for a while, then puts it back upright: on the last face of a round `rest` and time_to_look, and
    /// always one more round; in all directions a quarter of a round.
    void finish() noexcept;
    /// Puts it back upright.
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
