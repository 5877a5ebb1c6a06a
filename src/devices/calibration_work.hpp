// Work that calibrates a sensor of a device.
#pragma once
#include <devices/work.hpp>
#include <host/calibration.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// It waits once, when the old values are kept: the device is not changed before somebody says go on. The old values are kept under the
/// name that keep_name() tells until they are in the device again, or the new ones are.
std::unique_ptr<Work> calibrate(const WorkPlace& place, ano::host::Sensor sensor);
/// Writes back what was kept under `name` by a calibration that never ended, and forgets it when it is in the device again.
std::unique_ptr<Work> write_old_values_back(const WorkPlace& place, const std::string& name);
/// `values` were written to the device, {NAME: value}: kept ones that are among them are kept no longer.
void forget_written(const WorkPlace& place, const nlohmann::ordered_json& values);

/// What `text` tells can be written back: whose the values are, and all of them.
bool is_whole_backup(const std::string& text, ano::host::Sensor sensor);

/// "calibration-0xDC-compass.json": what `anoctl param import` takes.
std::string keep_name(std::uint8_t address, ano::host::Sensor sensor);
/// Nothing: it is no such name.
std::optional<ano::host::Sensor> sensor_of_note(std::string_view name);
std::optional<std::uint8_t> address_of_note(std::string_view name);

}    // namespace anogate
