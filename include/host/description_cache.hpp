// Descriptions of parameters, which do not change as long as the device is the same.
#pragma once
#include <host/device.hpp>
#include <host/parameter_info.hpp>

#include <cstddef>
#include <cstdint>
#include <list>
#include <vector>

namespace ano::host {

/// Equal keys mean the same device: same device info, same number of parameters, and it was not away.
struct DescriptionKey {
    std::uint8_t address = 0;
    std::uint32_t presence = 0;
    DeviceInfo info;
    std::uint16_t count = 0;
    friend bool operator==(const DescriptionKey&, const DescriptionKey&) = default;
};

/// Values are not cached, since they may change in the device. Keeps the `max_devices` devices used last.
class DescriptionCache {
public:
    static constexpr std::size_t max_devices = 32;

    /// Null when the descriptions are not known; valid until the next call of store() or forget().
    const std::vector<ParameterInfo>* find(const DescriptionKey& key);
    /// Replaces what was known of the same address.
    void store(DescriptionKey key, std::vector<ParameterInfo> descriptions);
    void forget(std::uint8_t address);

private:
    struct Entry {
        DescriptionKey key;
        std::vector<ParameterInfo> descriptions;
    };
    std::list<Entry> entries_;    // the one used last is first
};

}    // namespace ano::host
