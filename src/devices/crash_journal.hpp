// Data that must survive a crash: values to be written back to devices, devices in their loader, and statements of users about
// devices.
#pragma once
#include <ano/values.hpp>
#include <devices/device_net.hpp>
#include <host/device.hpp>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct WorkPlace;

/// A note is JSON under a name, stored by DeviceNet::keep(). This class holds a copy of all journal.
class CrashJournal {
public:
    explicit CrashJournal(DeviceNet& net) : net_{net} {}

    /// Adds a note of an earlier run without storing it.
    void remember(std::string name, std::string text) { (*all_)[std::move(name)] = std::move(text); }
    /// nullptr: not found. Valid until the next call.
    const std::string* find(const std::string& name) const;
    /// The names of the notes about this device.
    std::vector<std::string> names(std::uint8_t address) const;
    const std::map<std::string, std::string>& all() const noexcept { return *all_; }
    /// Stores a note and calls `done` with the error or "", perhaps from within keep().
    void keep(const std::string& name, const std::string& text, std::function<void(std::string fault)> done);
    /// Deletes a note, also one that another program stored.
    void forget(const std::string& name);
    /// Deletes a note that can't be used any more; `why` is the reason as a clause, for dropped().
    void drop(const std::string& name, const std::string& why);
    /// "NAME (WHY)" of the dropped notes about this device, unless a note of that name was stored since.
    std::vector<std::string> dropped(std::uint8_t address) const;

private:
    DeviceNet& net_;
    std::map<std::string, std::string> dropped_;
    std::shared_ptr<std::map<std::string, std::uint64_t>> changes_ = std::make_shared<std::map<std::string, std::uint64_t>>();
    std::shared_ptr<std::map<std::string, std::string>> all_ = std::make_shared<std::map<std::string, std::string>>();
};

/// "firmware-0xDC-1a2b3c4d.json" (unit_note_name()): the device is in its loader with an incomplete image or none; the note
/// contains its earlier identity.
bool is_loader_note(std::string_view name);
void keep_loader_note(const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info);
/// Its earlier identity; std::nullopt: there is no such note about it.
std::optional<ano::host::DeviceInfo> kept_identity(const WorkPlace& place);
/// Deletes the notes that a device with this address is in its loader there: it no longer is, whatever its name is now.
void forget_loader_notes(CrashJournal& journal, std::uint8_t address, const UnitPlace& here);

/// "type7-0xDC-1a2b3c4d.json" (unit_note_name()): the meaning of value type 7 for the device, as a user stated it.
bool is_type_7_note(std::string_view name);
/// Used from now on, even if it can't be stored.
void keep_type_7(const WorkPlace& place, ano::ValueType7 seven);
/// std::nullopt: no user stated it for this device.
std::optional<ano::ValueType7> kept_type_7(const WorkPlace& place);

/// Whether `name` is exactly the name of such a note or one of a calibration, and so can be shown.
bool is_note(std::string_view name);
/// The consequence for the user if the note `name` can't be used, as a clause.
std::string loss_of_note(std::string_view name);
/// Why the note is not used, and the consequence, as a clause that follows its path; empty: it is complete. The note of a
/// calibration must have all values; every note must name the device.
std::string damage_of_note(std::string_view name, const std::string& text);

}    // namespace anogate
