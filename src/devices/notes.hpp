// What must survive a crash: values to be written back to devices, and which devices are in their loader.
#pragma once
#include <devices/device_net.hpp>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// A note is JSON under a name, stored by DeviceNet::keep(). This class holds a copy of all notes.
class Notes {
public:
    explicit Notes(DeviceNet& net) : net_{net} {}

    /// Adds a note of an earlier run.
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

private:
    DeviceNet& net_;
    std::shared_ptr<std::map<std::string, std::string>> all_ = std::make_shared<std::map<std::string, std::string>>();
};

/// "firmware-0xDC.json": the device is in its loader with an incomplete image or none; the note has its earlier identity.
std::string loader_note(std::uint8_t address);
/// Whether `name` is exactly the name of such a note or one of a calibration, and so can be shown.
bool is_note(std::string_view name);
/// Whether the note is complete: one of a calibration needs all values and their device.
bool is_whole_note(std::string_view name, const std::string& text);

}    // namespace anogate
