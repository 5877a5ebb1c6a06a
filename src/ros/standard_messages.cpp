#include <ano/messages.hpp>
#include <ros/standard_messages.hpp>
#include <ros/standard_types.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>

namespace anogate {
namespace {

using ano::id_of;
using Rotation = StandardMessages::Rotation;
using Vector = StandardMessages::Vector;

constexpr double radian = std::numbers::pi / 180;    // per degree
constexpr double metre = 0.01;                       // per centimetre
constexpr double tesla = 1e-7;                       // per milligauss
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The inverse rotation of `v`.
Vector turned_back(const Rotation& q, const Vector& v) noexcept {
    const auto [w, x, y, z] = q;
    return {(1 - 2 * (y * y + z * z)) * v.x + 2 * (x * y + w * z) * v.y + 2 * (x * z - w * y) * v.z,
            2 * (x * y - w * z) * v.x + (1 - 2 * (x * x + z * z)) * v.y + 2 * (y * z + w * x) * v.z,
            2 * (x * z + w * y) * v.x + 2 * (y * z - w * x) * v.y + (1 - 2 * (x * x + y * y)) * v.z};
}

void append(const Vector& v, ValueList& out) {
    for (const double number : {v.x, v.y, v.z}) out.push(number);
}

void append(const Rotation& q, ValueList& out) {
    for (const double number : {q.x, q.y, q.z, q.w}) out.push(number);
}

void append(std::string_view text, ValueList& out) { out.push(ano::Value{text}); }
void append_whole(std::int64_t number, ValueList& out) { out.push(ano::Value{number}); }

constexpr Covariance<9> no_covariance{};
constexpr std::int64_t diagonal_known = 2;    // NavSatFix.COVARIANCE_TYPE_DIAGONAL_KNOWN
constexpr Covariance<9> no_orientation = [] {
    Covariance<9> covariance;
    covariance.set(0, -1);
    return covariance;
}();

// The elements `first` to `first` + 2 of the diagonal of a matrix.
template <std::size_t Size>
void set_diagonal(Covariance<Size>& covariance, std::size_t first, double value) noexcept {
    constexpr std::size_t next = Size == 9 ? 4 : 7;
    for (std::size_t axis = first; axis < first + 3; ++axis) covariance.set(axis * next, value);
}

template <std::size_t Size>
void append(const Covariance<Size>& covariance, ValueList& out) {
    out.push(ano::Value{ano::Bytes{covariance.bytes}});
}

bool is_fix(double fix_sta) noexcept { return fix_sta >= 2 && fix_sta <= 4; }    // UBX: 2D, 3D, 3D with dead reckoning

}    // namespace

const StandardRow& standard_row(StandardTopic topic) {
    const auto& t = standard_types();
    static const std::array<StandardRow, standard_topics> rows{{{"imu", t.imu},
                                                                {"magnetic_field", t.magnetic_field},
                                                                {"temperature", t.temperature},
                                                                {"orientation", t.quaternion_stamped},
                                                                {"linear_velocity", t.vector3_stamped},
                                                                {"point", t.point_stamped},
                                                                {"odometry", t.odometry},
                                                                {"battery", t.battery_state},
                                                                {"fix", t.nav_sat_fix},
                                                                {"fix_velocity", t.vector3_stamped},
                                                                {"external_point", t.point_stamped},
                                                                {"external_velocity", t.vector3_stamped},
                                                                {"scan", t.point_cloud},
                                                                {"image_raw", t.image},
                                                                {"range_down", t.range},
                                                                {"range_forward", t.range},
                                                                {"range_back", t.range},
                                                                {"range_left", t.range},
                                                                {"range_right", t.range},
                                                                {"range_up", t.range}}};
    return rows[static_cast<std::size_t>(topic)];
}

StandardMessages::StandardMessages(std::string_view frame, ImageRows* images, std::uint64_t sender)
    : frame_{frame},
      ground_{frame_ + "/odom"},
      east_north_up_{frame_ + "/enu"},
      external_{frame_ + "/external"},
      camera_{frame_ + "/camera"},
      images_{images},
      sender_{sender} {
    set_variances({});
    for (std::size_t i = 0; i < range_frames_.size(); ++i) {
        const auto topic = static_cast<std::size_t>(StandardTopic::range_down) + i;
        range_frames_[i] = frame_ + '/' + std::string{standard_row(static_cast<StandardTopic>(topic)).name};
    }
}

void StandardMessages::set_variances(const Variances& variances) noexcept {
    variances_ = variances;
    set_diagonal(orientation_covariance_, 0, variances.orientation);
    set_diagonal(rates_covariance_, 0, variances.angular_velocity);
    set_diagonal(acceleration_covariance_, 0, variances.linear_acceleration);
    set_diagonal(field_covariance_, 0, variances.magnetic_field);
    set_diagonal(fix_covariance_, 0, variances.fix);
    fix_covariance_.set(8, variances.fix_altitude);
    set_diagonal(pose_covariance_, 0, variances.position);
    set_diagonal(pose_covariance_, 3, variances.orientation);
    set_diagonal(twist_covariance_, 0, variances.velocity);
    set_diagonal(twist_covariance_, 3, variances.angular_velocity);
    set_diagonal(twist_without_rates_, 0, variances.velocity);
    set_diagonal(twist_without_rates_, 3, -1);
}

std::span<const StandardTopic> StandardMessages::receive(const ano::Reading& reading, std::uint64_t time_ns) {
    reading_ = reading;
    now_ns_ = time_ns;
    published_count_ = 0;
    switch (reading.message()->id) {
    case id_of<"inertial">:
        rates_ = {vector("gyr_", radian), now_ns_};
        publish(StandardTopic::imu);
        break;
    case id_of<"compass">:
        publish(StandardTopic::magnetic_field);
        publish(StandardTopic::temperature);
        break;
    case id_of<"euler">: on_euler(); break;
    case id_of<"quaternion">: on_quaternion(); break;
    case id_of<"velocity">:
        velocity_ = {vector("speed_", metre), now_ns_};
        publish(StandardTopic::linear_velocity);
        break;
    case id_of<"position">: on_position(); break;
    case id_of<"power">: publish(StandardTopic::battery); break;
    case id_of<"gps">: on_gps(); break;
    case id_of<"general_position">:
        if (std::isfinite(number("pos_x") + number("pos_y") + number("pos_z"))) publish(StandardTopic::external_point);
        break;
    case id_of<"general_velocity">:
        if (std::isfinite(number("speed_x") + number("speed_y") + number("speed_z"))) publish(StandardTopic::external_velocity);
        break;
    case id_of<"ranging">: on_ranging(); break;
    case id_of<"image">:
        image_ = images_ != nullptr ? images_->receive(sender_, reading, time_ns) : nullptr;
        if (image_ != nullptr) publish(StandardTopic::image_raw);
        break;
    default: break;
    }
    return {published_.data(), published_count_};
}

// Ignored if the device sends quaternions too, which are more precise.
void StandardMessages::on_euler() {
    if (is_fresh(by_quaternion_)) return;
    by_euler_ = {ano::rotation_of_euler(number("rol"), number("pit"), number("yaw"), signs_), now_ns_};
    publish(StandardTopic::orientation);
}

// A quaternion whose length is far from 1 is ignored: devices without quaternions send zeros.
void StandardMessages::on_quaternion() {
    const auto q = ano::rotation_of_quaternion(number("v0"), number("v1"), number("v2"), number("v3"));
    if (!q) return;
    by_quaternion_ = {*q, now_ns_};
    publish(StandardTopic::orientation);
}

void StandardMessages::on_position() {
    if (reading_->field("pos_z") == nullptr) return;    // both messages need a height
    publish(StandardTopic::point);
    if ((is_fresh(by_quaternion_) || is_fresh(by_euler_)) && is_fresh(velocity_)) publish(StandardTopic::odometry);
}

void StandardMessages::on_gps() {
    publish(StandardTopic::fix);
    if (is_fix(number("fix_sta"))) publish(StandardTopic::fix_velocity);
}

// The layout with one distance at an angle is not converted: it has no fixed direction for a frame_id.
void StandardMessages::on_ranging() {
    if (reading_->message()->ends_in_list()) publish(StandardTopic::scan);
    if (!reading_->message()->is_base()) return;
    const auto type = static_cast<std::size_t>(number("type"));
    publish(static_cast<StandardTopic>(static_cast<std::size_t>(StandardTopic::range_down) + type % range_frames_.size()));
}

template <class T>
bool StandardMessages::is_fresh(const Heard<T>& heard) const noexcept {
    if (!heard.time_ns) return false;
    const std::uint64_t apart = now_ns_ > *heard.time_ns ? now_ns_ - *heard.time_ns : *heard.time_ns - now_ns_;
    return apart <= fresh_ns;
}

double StandardMessages::number(std::string_view field) const noexcept {
    const ano::Field* const f = reading_->field(field);
    return f != nullptr ? reading_->number(*f) : nan;
}

Vector StandardMessages::vector(std::string_view prefix, double factor) const noexcept {
    std::array<char, 16> name{};
    char* const last = std::copy(prefix.begin(), prefix.end(), name.begin());
    const auto along = [&](char axis) {
        *last = axis;
        return factor * number({name.data(), prefix.size() + 1});
    };
    return {along('x'), along('y'), along('z')};
}

void StandardMessages::append_header(std::string_view frame, ValueList& out) const {
    constexpr std::uint64_t second = 1'000'000'000;
    append_whole(static_cast<std::int64_t>(std::min<std::uint64_t>(now_ns_ / second, std::numeric_limits<std::int32_t>::max())),
                 out);
    append_whole(static_cast<std::int64_t>(now_ns_ % second), out);
    append(frame, out);
}

void StandardMessages::append_values(StandardTopic topic, ValueList& out) const {
    switch (topic) {
    case StandardTopic::imu: return append_imu(out);
    case StandardTopic::magnetic_field:
        append_header(frame_, out);
        append(vector("mag_", tesla), out);
        return append(field_covariance_, out);
    case StandardTopic::temperature:
        append_header(frame_, out);
        out.push(number("tmp"));
        return out.push(variances_.temperature);
    case StandardTopic::orientation:
        append_header(ground_, out);
        return append(is_fresh(by_quaternion_) ? by_quaternion_.value : by_euler_.value, out);
    case StandardTopic::linear_velocity: append_header(ground_, out); return append(velocity_.value, out);
    case StandardTopic::point: append_header(ground_, out); return append(vector("pos_", metre), out);
    case StandardTopic::odometry: return append_odometry(out);
    case StandardTopic::battery: return append_battery(out);
    case StandardTopic::fix: return append_fix(out);
    case StandardTopic::fix_velocity:
        append_header(east_north_up_, out);
        return append(Vector{metre * number("e_spe"), metre * number("n_spe"), 0 - metre * number("d_spe")}, out);
    case StandardTopic::external_point: append_header(external_, out); return append(vector("pos_", 0.001), out);
    case StandardTopic::external_velocity: append_header(frame_, out); return append(vector("speed_", metre), out);
    case StandardTopic::scan: return append_scan(out);
    case StandardTopic::image_raw: return append_image(out);
    default: return append_range(topic, out);
    }
}

void StandardMessages::append_imu(ValueList& out) const {
    append_header(frame_, out);
    if (is_fresh(by_quaternion_) || is_fresh(by_euler_)) {
        append(is_fresh(by_quaternion_) ? by_quaternion_.value : by_euler_.value, out);
        append(orientation_covariance_, out);
    } else {
        append(Rotation{}, out);
        append(no_orientation, out);
    }
    append(rates_.value, out);
    append(rates_covariance_, out);
    append(vector("acc_", metre), out);
    append(acceleration_covariance_, out);
}

void StandardMessages::append_odometry(ValueList& out) const {
    const Rotation& attitude = is_fresh(by_quaternion_) ? by_quaternion_.value : by_euler_.value;
    append_header(ground_, out);
    append(std::string_view{frame_}, out);
    append(vector("pos_", metre), out);
    append(attitude, out);
    append(pose_covariance_, out);
    append(turned_back(attitude, velocity_.value), out);
    const bool turns = is_fresh(rates_);
    append(turns ? rates_.value : Vector{}, out);
    append(turns ? twist_covariance_ : twist_without_rates_, out);
}

void StandardMessages::append_battery(ValueList& out) const {
    append_header(frame_, out);
    for (const double number : {number("voltage"), nan, 0 - number("current"), nan, nan, nan, nan}) out.push(number);
    for (int unknown = 0; unknown < 3; ++unknown) append_whole(0, out);
    append_whole(1, out);
    for (int sequence = 0; sequence < 2; ++sequence) out.push_count(0);
    for (int empty = 0; empty < 2; ++empty) append(std::string_view{}, out);
}

void StandardMessages::append_fix(ValueList& out) const {
    const double fix_sta = number("fix_sta");
    append_header(frame_, out);
    append_whole(is_fix(fix_sta) ? 0 : -1, out);
    append_whole(0, out);
    out.push(is_fix(fix_sta) ? number("lat") : nan);
    out.push(is_fix(fix_sta) ? number("lng") : nan);
    out.push(is_fix(fix_sta) && fix_sta > 2 ? metre * number("alt_gps") : nan);
    const bool is_known = is_fix(fix_sta) && variances_.fix > 0;
    append(is_known ? fix_covariance_ : no_covariance, out);
    append_whole(is_known ? diagonal_known : 0, out);
}

// Angles are clockwise from the nose. A distance of 0 means no measurement.
void StandardMessages::append_scan(ValueList& out) const {
    constexpr std::size_t point_size = 3 * sizeof(float);
    constexpr std::int64_t float32 = 7;
    const std::span<const ano::Field> element = reading_->element_fields();
    const std::uint8_t* const points = reading_->data().data() + reading_->fixed_size();
    const auto at = [&](std::size_t point, std::size_t field) {
        return number_at(element[field], points + point * reading_->message()->element_size + element[field].offset);
    };
    std::size_t count = 0;
    for (std::size_t i = 0; i < reading_->element_count(); ++i) count += at(i, 1) > 0;

    append_header(frame_, out);
    append_whole(1, out);
    append_whole(static_cast<std::int64_t>(count), out);
    out.push_count(3);
    for (const std::string_view axis : {"x", "y", "z"}) {
        append(axis, out);
        append_whole((axis.front() - 'x') * std::int64_t{sizeof(float)}, out);
        append_whole(float32, out);
        append_whole(1, out);
    }
    append_whole(0, out);
    append_whole(point_size, out);
    append_whole(static_cast<std::int64_t>(count * point_size), out);
    std::uint8_t* to = out.push_bytes(count * point_size).data();
    for (std::size_t i = 0; i < reading_->element_count(); ++i) {
        const double angle = at(i, 0) * radian, distance = at(i, 1) * metre;
        if (!(distance > 0)) continue;
        for (const double number : {distance * std::cos(angle), 0 - distance * std::sin(angle), 0.0}) {
            ano::store(to, static_cast<float>(number));
            to += sizeof(float);
        }
    }
    append_whole(1, out);
}

void StandardMessages::append_image(ValueList& out) const {
    append_header(camera_, out);
    append_whole(image_->height, out);
    append_whole(image_->width, out);
    append(std::string_view{"mono8"}, out);
    append_whole(0, out);
    append_whole(image_->width, out);
    out.push(ano::Value{image_->pixels});
}

void StandardMessages::append_range(StandardTopic topic, ValueList& out) const {
    constexpr std::int64_t neither = 255;    // neither ultrasound nor infrared: not known
    const double dist = 0.001 * number("dist");
    append_header(range_frames_[static_cast<std::size_t>(topic) - static_cast<std::size_t>(StandardTopic::range_down)], out);
    append_whole(neither, out);
    for (const double number : {0.0, 0.0, std::numeric_limits<double>::infinity(), dist < 0 ? nan : dist, variances_.range})
        out.push(number);
}

}    // namespace anogate
