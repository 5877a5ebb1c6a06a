// The tasks of a host, for tests of all of them.
#pragma once
#include <host/commands.hpp>
#include <host/firmware.hpp>
#include <host/parameter_apply.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace support {

inline constexpr unsigned task_kinds = 7;

/// A started task of the given kind.
inline std::unique_ptr<ano::host::Task> task_of(unsigned kind, ano::host::Device& device, ano::TimePoint now) {
    using namespace ano::host;
    switch (kind % task_kinds) {
    case 0: {
        auto task = std::make_unique<Parameters>(device);
        task->read_all(now);
        return task;
    }
    case 1: {
        auto task = std::make_unique<ParameterApply>(
            device, nullptr, std::vector<std::pair<std::string, AnyValue>>{{"PAR_1", std::int64_t{5}}, {"PAR_8", 2.5}},
            ApplyOptions{.rollback = true});
        task->start(now);
        return task;
    }
    case 2: {
        auto task = std::make_unique<Commands>(device);
        task->read(now);
        return task;
    }
    case 3: {
        auto task = std::make_unique<WaypointsPut>(device, std::vector<Waypoint>(3));
        task->start(now);
        return task;
    }
    case 4: {
        auto task = std::make_unique<WaypointsGet>(device);
        task->start(now);
        return task;
    }
    case 5: {
        auto task = std::make_unique<CommandCall>(device, CommandInfo{0, {1, 2, 3}, {}, false, "go", ""},
                                                  std::vector<AnyValue>{});
        task->start(now);
        return task;
    }
    default: {
        FirmwareImage image;
        image.bytes = std::vector<std::uint8_t>(2000, 7);
        auto task = std::make_unique<Firmware>(device, image);
        task->start(now);
        return task;
    }
    }
}

}    // namespace support
