#include <host/description_cache.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {

const std::vector<ParameterInfo>* DescriptionCache::find(const DescriptionKey& key) {
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
    if (found == entries_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found);
    return &entries_.front().descriptions;
}

void DescriptionCache::store(DescriptionKey key, std::vector<ParameterInfo> descriptions) {
    forget(key.address);
    entries_.push_front({std::move(key), std::move(descriptions)});
    if (entries_.size() > max_devices) entries_.pop_back();
}

void DescriptionCache::forget(std::uint8_t address) {
    entries_.remove_if([&](const Entry& entry) { return entry.key.address == address; });
}

}    // namespace ano::host
