// What is to be known of devices after a crash: values to be written back, and who is left in its loader.
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

/// Notes are JSON under a name (DeviceNet::keep()); here they are as they are kept.
class Notes {
public:
    explicit Notes(DeviceNet& net) : net_{net} {}

    /// One that a run before this left.
    void remember(std::string name, std::string text) { (*all_)[std::move(name)] = std::move(text); }
    /// nullptr: there is none. Valid until the next call.
    const std::string* find(const std::string& name) const;
    /// Of this device.
    std::vector<std::string> names(std::uint8_t address) const;
    const std::map<std::string, std::string>& all() const noexcept { return *all_; }
    /// `done` may be called at once, with why it can't be kept or nothing.
    void keep(const std::string& name, const std::string& text, std::function<void(std::string fault)> done);
    /// Also one that another program kept.
    void forget(const std::string& name);

private:
    DeviceNet& net_;
    std::shared_ptr<std::map<std::string, std::string>> all_ = std::make_shared<std::map<std::string, std::string>>();
};

/// "firmware-0xDC.json": the device is in its loader, with half an image or none; who it was before is in it.
std::string loader_note(std::uint8_t address);
/// Whether a file of this name is such a note or one of a calibration: it is exactly as we name them, so that it can be shown.
bool is_note(std::string_view name);
/// Whether it can be used: a calibration's is damaged without all the values, or without the device that they are of.
bool is_whole_note(std::string_view name, const std::string& text);

}    // namespace anogate
