// The ROS types of the messages of the protocol, for all devices.
#pragma once
#include <ano/flexible.hpp>
#include <ros/table_message.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <memory>

namespace anogate {

class KnownMessages {
public:
    /// `layout`: of a flexible message, otherwise nullptr. The result is valid as long as this object; for a layout, until
    /// forget_layouts().
    const TableMessage& of(std::uint8_t id, const ano::FlexibleLayout* layout) {
        if (layout != nullptr) return flexible_.try_emplace(layout, *layout).first->second;
        if (!known_[id]) known_[id] = std::make_unique<TableMessage>(id);
        return *known_[id];
    }
    void forget_layouts() { flexible_.clear(); }

private:
    std::array<std::unique_ptr<TableMessage>, 256> known_{};
    std::map<const ano::FlexibleLayout*, TableMessage> flexible_;
};

}    // namespace anogate
