// The unit that a note belongs to: one rule for old values of a calibration, for devices left in their loader, and for statements
// of users about a device.
//
// A note belongs to a unit: gateway, link and its target, address, and the device information with name and versions.
#pragma once
#include <devices/device_net.hpp>
#include <host/device.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

struct WorkPlace;

/// The members of a note that identify its unit and its time. `info`: of the device, if known.
nlohmann::ordered_json unit_json(const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info);
/// "KIND-0xDC-1a2b3c4d.json", with "-ENDING" before the point unless it is empty. The digits identify the unit, so that two units
/// with one address have two journal.
std::string unit_note_name(std::string_view kind, const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info,
                           std::string_view ending = {});
/// Whether `name` is exactly the name of such a note, or one without the digits, as in older versions.
bool is_unit_note_name(std::string_view name, std::string_view kind, std::string_view ending = {});
/// std::nullopt: `name` is not the name of a note.
std::optional<std::uint8_t> address_of_note(std::string_view name);

/// The text of a note as JSON; null if it is damaged.
nlohmann::ordered_json note_json(const std::string& text);
/// The same for a note whose name and content must have the same address.
bool names_its_device(std::string_view name, const std::string& text);
/// The device information in a note.
std::optional<ano::host::DeviceInfo> info_in_note(const std::string& text);

/// Why the note does not belong to this gateway or link, as far as known before the device has answered; empty: it may belong to
/// it.
std::string misfit_of_place(const std::string& text, const UnitPlace& here, bool link_is_known);

enum class WithoutInfo : std::uint8_t { misfits, fits };
/// Why the note `text` does not belong to this device: a clause with the unit that it belongs to. Empty: all parts of the unit
/// are the same. `silent`: the result to assume if the device has sent no info, as in a loader.
std::string misfit_of_note(const std::string& text, const WorkPlace& place, WithoutInfo silent = WithoutInfo::misfits);
/// The name of a note of exactly this device that is `wanted`; empty: there is none.
std::string find_note(const WorkPlace& place, const std::function<bool(std::string_view name)>& wanted,
                      WithoutInfo silent = WithoutInfo::misfits);

/// "FC (0xDC), link 'fc', kept 2026-11-26 18:57:36 UTC".
std::string describe_unit(const std::string& text);

}    // namespace anogate
