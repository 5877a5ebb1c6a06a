// Work that calibrates a sensor of a device.
#pragma once
#include <devices/work.hpp>
#include <host/calibration.hpp>

#include <memory>

namespace anogate {

/// It waits once, when the old values are kept: the device is not changed before somebody says go on. The old values are kept under the
/// name that keep_name() tells until they are in the device again, or the new ones are.
std::unique_ptr<Work> calibrate(const WorkPlace& place, ano::host::Sensor sensor);
/// "calibration-0xDC-compass.json": what `anoctl param import` takes.
std::string keep_name(std::uint8_t address, ano::host::Sensor sensor);

}    // namespace anogate
