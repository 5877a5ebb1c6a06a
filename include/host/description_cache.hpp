// Descriptions of parameters, which do not change while a device is what it says it is.
#pragma once
#include <host/device.hpp>
#include <host/parameter_info.hpp>

#include <cstddef>
#include <cstdint>
#include <list>
#include <vector>

namespace ano::host {

/// What makes two devices the same: what it says of itself, how many parameters it has, and that it was not away.
struct DescriptionKey {
    std::uint8_t address = 0;
    std::uint32_t presence = 0;
    DeviceInfo info;
    std::uint16_t count = 0;
    friend bool operator==(const DescriptionKey&, const DescriptionKey&) = default;
};

/// Values are never kept: only the device knows them. Room for the devices used last.
class DescriptionCache {
public:
    static constexpr std::size_t max_devices = 32;

    /// Null when they are not known; valid until the next call of store() or forget().
    const std::vector<ParameterInfo>* find(const DescriptionKey& key);
    /// Takes the place of what was known of the same address.
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
