#include "hand.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ano::world {
namespace {

Attitude face_up(std::size_t face) noexcept {
    constexpr double quarter = 90 * degree;
    constexpr std::array<Angles, Hand::faces> all{Angles{0, -quarter, 0}, Angles{0, quarter, 0}, Angles{quarter, 0, 0},
                                                  Angles{-quarter, 0, 0}, Angles{0, 0, 0},       Angles{2 * quarter, 0, 0}};
    return Attitude::of(all[face % all.size()]);
}

Attitude unit(Attitude a) noexcept {
    const double length = std::sqrt(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);
    return {a.w / length, a.x / length, a.y / length, a.z / length};
}

Attitude between(Attitude a, Attitude b, double share) noexcept {
    if (a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0) b = {-b.w, -b.x, -b.y, -b.z};
    const double rest = 1 - share;
    return unit({rest * a.w + share * b.w, rest * a.x + share * b.x, rest * a.y + share * b.y, rest * a.z + share * b.z});
}

}    // namespace

void Hand::turn_to_faces(double rest) noexcept {
    rest_ = rest;
    begin(Does::faces);
    at_ = duration() - time_to_begin;
    until_ += at_;
}

void Hand::turn_all_round(Vector field, double duration) noexcept {
    field_ = (1 / field.length()) * field;
    round_ = duration;
    begin(Does::round);
}

void Hand::begin(Does what) noexcept {
    does_ = what;
    at_ = 0;
    until_ = rounds * duration();
}

void Hand::finish() noexcept {
    if (does_ == Does::round) until_ = std::min(until_, at_ + round_ / 4);
    if (does_ != Does::faces) return;
    const double in_round = std::fmod(at_, duration());
    const double look = rest_ + time_to_look, looks_at = duration() - look;
    if (in_round < looks_at) {
        until_ = at_ + duration();
        return;
    }
    at_ -= in_round - looks_at;    // continue as at the beginning of the long rest on the last face
    until_ = at_ + look + duration();
}

void Hand::lay(std::size_t face) noexcept {
    does_ = Does::lies;
    face_ = face;
}

double Hand::duration() const noexcept {
    return does_ == Does::faces ? faces * (time_to_turn + rest_) + rest_ + time_to_look : round_;
}

Attitude Hand::next(double dt) noexcept {
    if (does_ == Does::lies) return face_up(face_);
    at_ += dt;
    if (at_ >= until_) {
        let_go();
        return {};
    }
    return does_ == Does::faces ? on_faces() : all_round();
}

// Each turn to the next face is less than half a circle, or about one axis.
Attitude Hand::on_faces() const noexcept {
    constexpr std::array<std::size_t, faces> order{4, 0, 2, 5, 1, 3};
    const double one = time_to_turn + rest_;
    const double in_round = std::fmod(at_, duration());
    const auto turn = std::min(static_cast<std::size_t>(in_round / one), faces - 1);
    const double moved = std::min((in_round - static_cast<double>(turn) * one) / time_to_turn, 1.0);
    return between(face_up(order[(turn + faces - 1) % faces]), face_up(order[turn % faces]), moved);
}

// A needle fixed to the device follows a spiral from pole to pole. The attitude is the shortest turn from the needle to the
// field.
Attitude Hand::all_round() const noexcept {
    constexpr double turns = 18;
    const double share = std::fmod(at_ / round_, 1.0);
    const double up = 1 - 2 * share, out = std::sqrt(std::max(1 - up * up, 0.0)), round = 2 * std::numbers::pi * turns * share;
    const Vector needle{out * std::cos(round), out * std::sin(round), up};
    const Vector axis = cross(needle, field_);
    const double w = 1 + needle.x * field_.x + needle.y * field_.y + needle.z * field_.z;
    return w < 1e-6 ? Attitude{0, 1, 0, 0} : unit({w, axis.x, axis.y, axis.z});
}

}    // namespace ano::world
