// Calibrates a sensor of a device.
#pragma once
#include <devices/works/work.hpp>
#include <host/calibration.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Waits for go_on() once, after the old values are stored: the device is not changed before. The old values are stored under
/// keep_name() until either they or the new ones are in the device.
std::unique_ptr<Work> calibrate(const WorkPlace& place, ano::host::Sensor sensor);
/// Writes the values that an unfinished calibration stored under `name` back to the device, and deletes them when they are there.
std::unique_ptr<Work> write_old_values_back(const WorkPlace& place, const std::string& name);
/// `values` ({NAME: value}) were written to the device: stored old values of these parameters are deleted.
void forget_written(const WorkPlace& place, const nlohmann::ordered_json& values);

/// Whether `text` is complete and can be written back: it has the device and all values.
bool is_whole_backup(const std::string& text, ano::host::Sensor sensor);

/// "calibration-0xDC-1a2b3c4d-compass.json" (unit_note_name()), which `anoctl param import` accepts.
std::string keep_name(const WorkPlace& place, ano::host::Sensor sensor);
/// "accelerometer of FC (0xDC), link 'fc', kept 2026-11-26 18:57:36 UTC".
std::string describe_note(std::string_view name, const std::string& text);
/// std::nullopt: `name` is not such a name.
std::optional<ano::host::Sensor> sensor_of_note(std::string_view name);

}    // namespace anogate
