// What must survive a crash: values to be written back to devices, which devices are in their loader, and what users stated of them.
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

/// A note is JSON under a name, stored by DeviceNet::keep(). This class holds a copy of all notes.
class Notes {
public:
    explicit Notes(DeviceNet& net) : net_{net} {}

    /// Adds a note without storing it, as one of an earlier run.
    void remember(std::string name, std::string text) { (*all_)[std::move(name)] = std::move(text); }
    /// nullptr: there is none. Valid until the next call.
    const std::string* find(const std::string& name) const;
    /// The names of the notes about this device.
    std::vector<std::string> names(std::uint8_t address) const;
    const std::map<std::string, std::string>& all() const noexcept { return *all_; }
    /// Calls `done` with the error or "", perhaps from within keep().
    void keep(const std::string& name, const std::string& text, std::function<void(std::string fault)> done);
    /// Deletes a note, also one of another program.
    void forget(const std::string& name);
    /// The same of one that is of no use any more, and `why` in a clause, for dropped().
    void drop(const std::string& name, const std::string& why);
    /// "NAME (WHY)" of the notes about this device that were dropped, unless one of that name was kept since.
    std::vector<std::string> dropped(std::uint8_t address) const;

private:
    DeviceNet& net_;
    std::map<std::string, std::string> dropped_;
    std::shared_ptr<std::map<std::string, std::uint64_t>> changes_ = std::make_shared<std::map<std::string, std::uint64_t>>();
    std::shared_ptr<std::map<std::string, std::string>> all_ = std::make_shared<std::map<std::string, std::string>>();
};

/// "firmware-0xDC-1a2b3c4d.json" (unit_note_name()): the device is in its loader with an incomplete image or none; the note has its earlier
/// identity.
bool is_loader_note(std::string_view name);
void keep_loader_note(const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info);
/// Its earlier identity; std::nullopt: there is no such note of it.
std::optional<ano::host::DeviceInfo> kept_identity(const WorkPlace& place);
/// Deletes the notes that a device with this address is in its loader there: it is not any more, whatever it is called now.
void forget_loader_notes(Notes& notes, std::uint8_t address, const UnitPlace& here);

/// "type7-0xDC-1a2b3c4d.json" (unit_note_name()): what value type 7 means for the device, as a user stated it.
bool is_type_7_note(std::string_view name);
/// Known from now on, even if it can't be stored.
void keep_type_7(const WorkPlace& place, ano::ValueType7 seven);
/// std::nullopt: nothing was stated of this device.
std::optional<ano::ValueType7> kept_type_7(const WorkPlace& place);

/// Whether `name` is exactly the name of such a note or one of a calibration, and so can be shown.
bool is_note(std::string_view name);
/// What it means for the user that the note `name` can't be used, in a clause.
std::string loss_of_note(std::string_view name);
/// Why the note is not used, and what that means, in a clause that follows its path; empty: it is whole. One of a calibration needs all values,
/// every one the device.
std::string damage_of_note(std::string_view name, const std::string& text);

}    // namespace anogate
