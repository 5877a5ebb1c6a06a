#include <ano/hex.hpp>
#include <ano_json/text.hpp>
#include <ros/ros_names.hpp>
#include <ros2/prefixes.hpp>

namespace anogate {

const Ros2Device* Prefixes::entry(std::uint8_t address, std::string_view link) const noexcept {
    for (const Ros2Device& device : settings_.devices)
        if (device.address == address && (device.link.empty() || device.link == link)) return &device;
    return nullptr;
}

std::string Prefixes::wanted(std::uint8_t address, std::string_view link, std::string_view name) const {
    if (const Ros2Device* device = entry(address, link); device != nullptr && !device->prefix.empty()) return device->prefix;
    if (settings_.prefix == PrefixFrom::link) return ros_name(link, "link");
    return name.empty() ? std::string{} : ros_name(name, "device");
}

Prefixes::Answer Prefixes::of(std::uint8_t address, std::string_view link, std::string_view name) {
    const std::string prefix = wanted(address, link, name);
    if (prefix.empty()) return {};
    const auto [owner, is_new] = owners_.emplace(prefix, address);
    if (owner->second == address) return {prefix, {}};
    return {{},
            "prefix " + ano::in_quotes(prefix) + " belongs to device " + ano::hex_byte(owner->second) + "; add {\"address\": \"" +
                ano::hex_byte(address) + "\", \"prefix\": \"NAME\"} to \"devices\" in ros2.json"};
}

}    // namespace anogate
