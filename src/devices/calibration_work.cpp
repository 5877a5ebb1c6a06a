#include <ano/hex.hpp>
#include <devices/calibration_work.hpp>
#include <devices/device_json.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::Calibration;
using ano::host::Sensor;
using ano::host::Task;

double hundredths(double value) { return std::round(value * 100) / 100; }

std::string_view name_of(Sensor sensor) { return sensor == Sensor::accelerometer ? "accelerometer" : "compass"; }

Json values_json(const ano::host::CalibrationValues& values) {
    Json json = Json::object();
    for (const auto& [name, value] : values) json[name] = value_json(value, ano::Type::f32);
    return json;
}

// {"face": "+x", "still": 1.0, "faces": {"+x": 0.5, …}, "done": ["-z"]}
Json faces_json(const ano::host::SixFaces& faces) {
    Json json{{"face", nullptr}, {"still", 0}, {"faces", Json::object()}, {"done", Json::array()}};
    if (const auto face = faces.face()) json["face"] = ano::host::name_of(*face);
    if (const auto unrest = faces.unrest()) json["still"] = hundredths(1 / std::max(1.0, *unrest));
    for (std::size_t i = 0; i < ano::host::face_names.size(); ++i) {
        const auto face = static_cast<ano::host::Face>(i);
        const double share = double(faces.samples(face)) / double{ano::host::SixFaces::enough};
        json["faces"][std::string{ano::host::name_of(face)}] = hundredths(std::min(1.0, share));
        if (faces.is_enough(face)) json["done"].push_back(ano::host::name_of(face));
    }
    return json;
}

// {"bands": 6, "sectors": 12, "coverage": [0, 1, …], "filled": 0.6}
Json sphere_json(const ano::host::CompassSphere& sphere) {
    using Sphere = ano::host::CompassSphere;
    Json cells = Json::array();
    for (std::size_t i = 0; i < Sphere::cells; ++i) cells.push_back(sphere.map().test(i) ? 1 : 0);
    return {{"bands", Sphere::bands},
            {"sectors", Sphere::sectors},
            {"coverage", std::move(cells)},
            {"filled", hundredths(sphere.coverage())},
            {"samples", sphere.samples()}};
}

class Calibrate final : public TaskWork {
public:
    Calibrate(const WorkPlace& place, Sensor sensor) : TaskWork{place}, sensor_{sensor} {}

    void start(TimePoint now) override {
        auto task = std::make_unique<Calibration>(place().device, sensor_, &place().cache);
        calibration_ = task.get();
        next(std::move(task)).start(now);
    }
    void hear(ano::FrameView frame, TimePoint now) override {
        if (calibration_ == nullptr || calibration_->end()) return;
        const Phase before = phase();
        calibration_->hear(frame, now);
        if (phase() != before) place().net.wake(now);
    }
    std::optional<TimePoint> due() const override { return calibration_ != nullptr ? calibration_->due() : std::nullopt; }
    bool is_waiting() const override { return phase() == Phase::keep && kept_->is_done && kept_->fault.empty(); }
    bool go_on(TimePoint now) override {
        if (!is_waiting()) return false;
        calibration_->kept(now);
        return true;
    }
    std::string message() const override {
        switch (phase()) {
        case Phase::read: return "reading the old values";
        case Phase::keep:
            return is_waiting() ? "the old values are kept; go on when the device may be turned" : "keeping the old values";
        case Phase::clear: return "the device is told to forget them";
        case Phase::turn: return sensor_ == Sensor::accelerometer ? "lay it on each of its six faces" : "turn it to all sides";
        case Phase::write: return "writing the new values";
        case Phase::restore: return "writing the old values back";
        case Phase::over: break;
        }
        return {};
    }
    std::string step() const override {
        if (calibration_ == nullptr || phase() != Phase::turn) return {};
        return (sensor_ == Sensor::accelerometer ? faces_json(calibration_->faces()) : sphere_json(calibration_->sphere()))
            .dump();
    }

private:
    using Phase = Calibration::Step;
    struct Kept {
        bool is_asked = false, is_done = false;
        std::string fault;
    };

    Phase phase() const { return calibration_ != nullptr ? calibration_->step() : Phase::read; }
    void look(TimePoint now) override {
        if (end() || calibration_ == nullptr) return;
        calibration_->look(now);
        if (phase() != Phase::keep) return;
        if (!std::exchange(kept_->is_asked, true)) keep();
        if (kept_->fault.empty()) return;
        calibration_->cancel(now);
        finish(work_fault(503, "the old values could not be kept, so nothing was changed: " + kept_->fault));
    }
    void keep() {
        const auto& device = place().device;
        const Json json{{"device", identity_json(device.address(), device.info())},
                        {"parameters", values_json(calibration_->old_values())}};
        place().net.keep(keep_name(device.address(), sensor_), json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n",
                         [kept = kept_, &net = place().net](std::string fault) {
                             kept->fault = std::move(fault);
                             kept->is_done = true;
                             net.wake(net.now());
                         });
    }
    void forget() {
        place().net.keep(keep_name(place().device.address(), sensor_), {}, [](const std::string&) {});
    }
    void done(const Task& task, TimePoint) override {
        forget();
        WorkEnd end = end_of(*task.end());
        const auto residuals = calibration_->residuals().value_or(std::pair{0.0, 0.0});
        end.result =
            Json{{"before", residuals.first}, {"after", residuals.second}, {"values", values_json(calibration_->new_values())}}
                .dump();
        finish(std::move(end));
    }
    // The old values are in the device, unless it is said that they could not be written back: then they stay where they are kept.
    void failed(const Task& task, TimePoint) override {
        if (calibration_->has_old_values()) forget();
        finish(end_of(*task.end()));
    }

    Sensor sensor_;
    Calibration* calibration_ = nullptr;
    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
};

}    // namespace

std::unique_ptr<Work> calibrate(const WorkPlace& place, Sensor sensor) { return std::make_unique<Calibrate>(place, sensor); }

std::string keep_name(std::uint8_t address, Sensor sensor) {
    return "calibration-" + ano::hex_byte(address) + "-" + std::string{name_of(sensor)} + ".json";
}

}    // namespace anogate
