// A device with an accelerometer that works like real ones: its samples are corrected by its calibration, which it loads from
// flash on a restart.
#pragma once
#include <host/calibration.hpp>
#include <support/fake_device.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace support {

/// The device, the host with its task, and a person who turns the device, in simulated time: one sample per step.
class CalibrationBench {
public:
    using Calibration = ano::host::Calibration;
    using Values = std::array<float, 15>;
    static constexpr Values raw{0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};

    FakeDevice fake;
    ano::host::Device device{0xDC};
    ano::host::DescriptionCache cache;
    Calibration task{device, ano::host::Sensor::accelerometer, &cache};
    TimePoint now = TimePoint{} + 1h;
    Values flash{-30, 20, 10, 0.97f, 1.02f, 1, 1, 0.01f, 0, 0, 1, 0, 0, 0, 1};    // of an earlier calibration, of another sensor
    Duration uses_after{};                                                        // the time from storing to using it
    Values (*as_it_uses)(Values) = [](Values values) { return values; };          // another one simulates a different formula
    struct Sensor {
        ano::host::Vector offset{25, -15, 5}, factor{1.02, 1.01, 1.00};
    } sensor;
    bool uses_nothing = false;         // it stores a calibration but never uses it
    bool shows_the_clear = true;       // its parameters change when the calibration is cleared
    bool uses_the_clear = true;        // false: it continues to use its old calibration
    bool ignores_the_clear = false;    // true: it only acknowledges the clear
    bool is_dead = false;
    Duration step = 20ms;
    Duration late{};            // samples arrive later than answers by this time
    double smooths = 0;         // s, the time constant of its low pass
    bool holds_still = true;    // the person does not move the device while it is measured
    double tilts = 0;           // °/s, the device is held in the hand and tilts slowly
    double lies_off = 0;        // rad, maximum: each face is tilted differently
    std::uint32_t lays = 1;     // the seed of these tilts
    double sways = 0;           // rad, amplitude about two axes
    Duration sways_in = 40s;    // the period
    std::vector<std::uint16_t> actions;
    std::function<void()> each_step;    // optional

    CalibrationBench() {
        for (const std::string& name : ano::host::calibration_names(ano::host::Sensor::accelerometer))
            fake.parameters.push_back({8, name, "", Bytes(4)});
        load(flash);
        used_ = flash;
        fake.instead = [this](ano::FrameView frame) -> std::optional<std::vector<Bytes>> {
            if (frame.id() == 0xE0 && frame.data()[0] == 0x10) act(ano::load<std::uint16_t>(frame.data().data() + 1));
            return std::nullopt;
        };
    }

    /// To be called after a change of `flash`, before the task starts.
    void load_flash() {
        load(flash);
        used_ = flash;
    }
    /// Makes its old calibration exactly right.
    void make_right(const Sensor& is) {
        sensor = is;
        flash = raw;
        for (std::size_t i = 0; i < 3; ++i) {
            flash[i] = static_cast<float>(is.offset[i]);
            flash[3 + i] = static_cast<float>(1 / is.factor[i]);
        }
        load_flash();
    }
    /// Makes it an older device, whose values are i32 with this scale.
    void make_scaled(std::int32_t mul) {
        fake.scaled = true;
        for (auto& parameter : fake.parameters) parameter.mul = mul;
        load(flash);
    }
    /// Restarts it: it uses the calibration in flash again, and sends nothing for `time`.
    void restart(Duration time) {
        load(flash);
        used_ = flash;
        uses_at_.reset();
        silent_until_ = now + time;
    }
    void announce(std::uint16_t version = 100) {
        const std::string name = "fake";
        receive(
            frame(0xDC, 0xFF, 0xE3,
                  Bytes{0xDC, 100, 0, static_cast<std::uint8_t>(version), 0, 0, 0, 0x20, 3} + Bytes(name.begin(), name.end())));
    }
    /// Runs until the task ends or `limit` is over.
    void run(Duration limit = 10min) {
        if (!begun_) task.start(now);
        begun_ = true;
        for (const TimePoint end = now + limit; !task.end() && now < end;) run_step();
    }
    /// Runs until the task is in step `where` with at least `faces` measured faces; false: it ended or `limit` was over first.
    bool run_to(Calibration::Step where, std::size_t faces = 0, Duration limit = 2min) {
        if (!begun_) task.start(now);
        begun_ = true;
        for (const TimePoint end = now + limit; !task.end() && now < end; run_step())
            if (task.step() == where && task.faces().faces_done() >= faces) return true;
        return false;
    }
    /// The largest error of a face with the stored calibration, in cm/s².
    double worst_face() const {
        double worst = 0;
        for (std::size_t face = 0; face < 6; ++face)
            worst = std::max(
                worst, ano::host::error_on(static_cast<ano::host::Face>(face),
                                           ano::host::AccelerometerCalibration::of(as_it_uses(flash)).corrected(felt(face))));
        return worst;
    }

private:
    void act(std::uint16_t action) {
        actions.push_back(action);
        if (action == 0x20 && !ignores_the_clear) {
            if (uses_the_clear) used_ = raw;
            if (shows_the_clear) load(raw);
        }
        if (action != 0x21) return;
        flash = stored();
        uses_at_ = now + uses_after;
    }
    void load(const Values& values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            auto& parameter = fake.parameters[i];
            if (fake.scaled)
                ano::store(parameter.value.data(), static_cast<std::int32_t>(std::lround(double{values[i]} * parameter.mul)));
            else ano::store(parameter.value.data(), values[i]);
        }
    }
    Values stored() const {
        Values values{};
        for (std::size_t i = 0; i < values.size(); ++i) {
            const auto& parameter = fake.parameters[i];
            const double scaled = ano::load<std::int32_t>(parameter.value.data());
            values[i] = fake.scaled ? static_cast<float>(scaled / parameter.mul) : ano::load<float>(parameter.value.data());
        }
        return values;
    }
    // The measurement of its sensor.
    ano::host::Vector felt(std::size_t face) const {
        ano::host::Vector v = sensor.offset;
        v[face / 2] += (face % 2 == 0 ? 1 : -1) * ano::host::SixFaces::gravity * sensor.factor[face / 2];
        return v;
    }
    ano::host::Vector felt_tilted() {
        ano::host::Vector v{};
        v[face_ / 2] = face_ % 2 == 0 ? 1 : -1;
        std::mt19937 chance{lays * 1000 + static_cast<std::uint32_t>(face_)};
        for (double& axis : v) axis += lies_off * (static_cast<double>(chance()) / 2147483648.0 - 1);
        const double since = std::chrono::duration<double>{now.time_since_epoch()}.count();
        const double a = sways * std::sin(since * 2 * std::numbers::pi / std::chrono::duration<double>{sways_in}.count());
        v = {v[0], std::cos(a) * v[1] - std::sin(a) * v[2], std::sin(a) * v[1] + std::cos(a) * v[2]};
        v = {std::cos(a) * v[0] - std::sin(a) * v[2], v[1], std::sin(a) * v[0] + std::cos(a) * v[2]};
        const double length = std::hypot(v[0], v[1], v[2]);
        for (std::size_t i = 0; i < 3; ++i)
            v[i] = sensor.offset[i] + v[i] / length * ano::host::SixFaces::gravity * sensor.factor[i];
        return v;
    }
    void run_step() {
        now += step;
        ++steps_;
        if (task.step() == Calibration::Step::keep) task.kept(now);
        if (uses_at_ && now >= *uses_at_ && !uses_nothing) used_ = flash;
        const bool is_silent = is_dead || (silent_until_ && now < *silent_until_);
        for (int n = 0; n < 2; ++n)
            if (const auto asked = device.next_frame(now); asked && !is_silent)
                for (const Bytes& answer : fake.take(*asked)) receive(answer);
        turn();
        if (!is_silent) send_sample();
        receive_samples();
        if (each_step) each_step();
        task.look(now);
    }
    // Turns to the next face when one is measured; the device moves for the next half second.
    void turn() {
        if (task.step() == Calibration::Step::verify && moving_ == 0 &&
            face_ != static_cast<std::size_t>(*task.face_to_verify())) {
            face_ = static_cast<std::size_t>(*task.face_to_verify());
            move();
        }
        const bool is_measured = task.step() == Calibration::Step::turn || task.step() == Calibration::Step::prove;
        if (!is_measured || moving_ > 0) {
            moving_ -= moving_ > 0;
            return;
        }
        if (!task.faces().is_enough(static_cast<ano::host::Face>(face_))) return;
        for (face_ = 0; face_ < 5 && task.faces().is_enough(static_cast<ano::host::Face>(face_));) ++face_;
        move();
    }
    void move() {
        moving_ = static_cast<int>(500ms / step);
        tilt_ = 0;
    }
    // The measurement of its sensor while it is tilted, after the low pass.
    ano::host::Vector measured() {
        ano::host::Vector v = lies_off > 0 || sways > 0 ? felt_tilted() : felt(face_);
        tilt_ += tilts * std::chrono::duration<double>{step}.count() * std::numbers::pi / 180;
        const std::size_t other = (face_ / 2 + 1) % 3;
        v[other] += (v[face_ / 2] - sensor.offset[face_ / 2]) * std::sin(tilt_);
        v[face_ / 2] -= (v[face_ / 2] - sensor.offset[face_ / 2]) * (1 - std::cos(tilt_));
        const double share = smooths > 0 ? 1 - std::exp(-std::chrono::duration<double>{step}.count() / smooths) : 1;
        for (std::size_t i = 0; i < 3; ++i) smoothed_[i] += share * (v[i] - smoothed_[i]);
        return smoothed_;
    }
    void send_sample() {
        const auto v = ano::host::AccelerometerCalibration::of(as_it_uses(used_)).corrected(measured());
        const bool moves = moving_ > 0 || !holds_still;
        const double shakes = moves ? (steps_ % 2 == 0 ? 200 : -200) : static_cast<double>(steps_ % 3) - 1;
        ano::Draft<"inertial"> m;
        (void)m.set<"acc_x">(std::round(v[0] + shakes));
        (void)m.set<"acc_y">(std::round(v[1] - shakes));
        (void)m.set<"acc_z">(std::round(v[2] + shakes));
        std::array<std::uint8_t, 64> bytes{};
        const std::size_t size = m.encode(bytes, 0xDC, 0xFF);
        on_the_way_.push_back({now + late, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}});
    }
    void receive_samples() {
        for (; !on_the_way_.empty() && on_the_way_.front().first <= now; on_the_way_.pop_front())
            receive(on_the_way_.front().second);
    }
    void receive(const Bytes& bytes) {
        device.take(ano::FrameView{bytes}, now);
        task.receive(ano::FrameView{bytes}, now);
    }

    Values used_{};
    std::optional<TimePoint> uses_at_, silent_until_;
    std::size_t face_ = 0, steps_ = 0;
    int moving_ = 0;
    double tilt_ = 0;    // rad
    ano::host::Vector smoothed_{};
    std::deque<std::pair<TimePoint, Bytes>> on_the_way_;    // by time of arrival
    bool begun_ = false;
};

}    // namespace support
