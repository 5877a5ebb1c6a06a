#include <ano_json/compact_json.hpp>
#include <devices/works/waypoint_works.hpp>
#include <host/waypoints.hpp>

#include <nlohmann/json.hpp>

#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::Task;

class ReadWaypoints final : public TaskWork {
public:
    ReadWaypoints(const WorkPlace& place, WaypointForm form) : TaskWork{place}, form_{form} {}
    void start(TimePoint now) override {
        auto task = std::make_unique<ano::host::WaypointsGet>(place().device);
        get_ = task.get();
        next(std::move(task)).start(now);
    }
    std::string message() const override { return "reading waypoints"; }

private:
    void done(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end(), texts());
        end.result = waypoints_json(get_->waypoints(), form_).dump();
        finish(std::move(end));
    }

    WaypointForm form_;
    ano::host::WaypointsGet* get_ = nullptr;
};

class WriteWaypoints final : public TaskWork {
public:
    WriteWaypoints(const WorkPlace& place, std::vector<ano::host::Waypoint> waypoints)
        : TaskWork{place}, waypoints_{std::move(waypoints)} {}
    void start(TimePoint now) override {
        auto task = std::make_unique<ano::host::WaypointsPut>(place().device, std::move(waypoints_));
        task->mean_present_device();
        put_ = task.get();
        next(std::move(task)).start(now);
    }
    std::string message() const override { return "writing waypoints"; }

private:
    void done(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end(), texts());
        Json result{{"written", put_->stored().size()}};
        if (!end.fault.empty()) result["note"] = end.fault.text();
        end.result = ano::compact_json(result);
        finish(std::move(end));
    }

    std::vector<ano::host::Waypoint> waypoints_;
    ano::host::WaypointsPut* put_ = nullptr;
};

}    // namespace

std::unique_ptr<Work> read_waypoints(const WorkPlace& place, WaypointForm form) {
    return std::make_unique<ReadWaypoints>(place, form);
}

std::unique_ptr<Work> write_waypoints(const WorkPlace& place, std::vector<ano::host::Waypoint> waypoints) {
    return std::make_unique<WriteWaypoints>(place, std::move(waypoints));
}

}    // namespace anogate
