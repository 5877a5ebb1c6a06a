// Descriptions of parameters or commands, which do not change while the device is the same.
#pragma once
#include <host/device.hpp>
#include <host/parameter_info.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <utility>
#include <vector>

namespace ano::host {

/// Equal keys mean the same device: same device info, same number of parameters or commands, and not away in between.
struct DescriptionKey {
    std::uint8_t address = 0;
    std::uint32_t presence = 0;
    DeviceInfo info;
    std::uint16_t count = 0;
    friend bool operator==(const DescriptionKey&, const DescriptionKey&) = default;
};

/// The key of `device` from its last reports; `count`: its number of parameters or commands. std::nullopt: the device is away, or
/// has not reported all of this since it was away.
inline std::optional<DescriptionKey> key_of(const Device& device, std::optional<std::uint16_t> count, TimePoint now) {
    if (!device.is_present(now) || !device.info() || !count) return std::nullopt;
    return DescriptionKey{device.address(), device.presence(), *device.info(), *count};
}

/// Values are not cached, since the device may change them. Stores the `max_devices` devices used last.
template <class Description>
class DescriptionCacheOf {
public:
    static constexpr std::size_t max_devices = 32;

    /// nullptr if the descriptions are not known; valid until the next call of store() or forget().
    const std::vector<Description>* find(const DescriptionKey& key) {
        const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
        if (found == entries_.end()) return nullptr;
        entries_.splice(entries_.begin(), entries_, found);
        return &entries_.front().descriptions;
    }
    /// Descriptions that an earlier run may have stored. `recall` returns them for a device that looks the same; each must be
    /// compared before it is used. `keep` is called with what was read.
    struct EarlierRuns {
        std::function<std::optional<std::vector<Description>>(const DescriptionKey&)> recall;
        std::function<void(const DescriptionKey&, const std::vector<Description>&)> keep;
    };
    void use(EarlierRuns earlier) { earlier_ = std::move(earlier); }
    std::optional<std::vector<Description>> recall(const DescriptionKey& key) const {
        return earlier_.recall ? earlier_.recall(key) : std::nullopt;
    }

    struct Entry {
        DescriptionKey key;
        std::vector<Description> descriptions;
        std::uint32_t signs;    // Device::signs() when the descriptions were read
    };
    /// The last entry stored for `address`, even if the device has changed since; nullptr: none. Valid as stated at find().
    Entry* last_of(std::uint8_t address) noexcept {
        const auto found = std::find_if(entries_.begin(), entries_.end(),
                                        [&](const Entry& entry) { return entry.key.address == address; });
        return found == entries_.end() ? nullptr : &*found;
    }

    /// Replaces the entry of the same address. `signs`: Device::signs() when the reading began.
    void store(DescriptionKey key, std::vector<Description> descriptions, std::uint32_t signs = 0) {
        forget(key.address);
        if (earlier_.keep) earlier_.keep(key, descriptions);
        entries_.push_front({std::move(key), std::move(descriptions), signs});
        if (entries_.size() > max_devices) entries_.pop_back();
    }
    void forget(std::uint8_t address) {
        entries_.remove_if([&](const Entry& entry) { return entry.key.address == address; });
    }
    bool has(std::uint8_t address) const noexcept {
        return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key.address == address; });
    }

private:
    std::list<Entry> entries_;    // the most recently used one is first
    EarlierRuns earlier_;
};

using DescriptionCache = DescriptionCacheOf<ParameterInfo>;

}    // namespace ano::host
