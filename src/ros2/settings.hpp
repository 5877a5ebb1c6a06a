// The settings of anogate-ros2.
#pragma once
#include <gateway/settings.hpp>
#include <ros/standard_messages.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Where the prefix of a device's topics comes from, unless it is configured.
enum class PrefixFrom : std::uint8_t { link, device };

enum class Reliability : std::uint8_t { reliable, best_effort };

/// The topics by which ROS 2 nodes may control a device.
enum class Input : std::uint8_t { cmd_vel, joy, command };
inline constexpr std::string_view input_names[] = {"cmd_vel", "joy", "command"};    // in the order of Input

struct Ros2Device {
    std::uint8_t address = 0;
    std::string link{};                   // empty: any
    std::string prefix{};                 // empty: by Ros2Settings::prefix
    std::vector<std::string> accept{};    // of input_names
    std::uint32_t hover_throttle = 0;     // thousandths of a percent; 0: not set
    std::vector<std::uint8_t> velocity_modes{2};

    bool accepts(Input input) const noexcept {
        for (const std::string& name : accept)
            if (name == input_names[static_cast<std::size_t>(input)]) return true;
        return false;
    }
    bool operator==(const Ros2Device&) const = default;
};

struct Ros2Settings {
    std::string control;    // the socket of the gateway; empty: searched
    std::uint32_t domain = 0;
    std::vector<std::string> interfaces;    // empty: all
    PrefixFrom prefix = PrefixFrom::link;
    bool raw = true;
    bool tf = false;
    std::map<std::string, Reliability> qos;    // by the name of a topic without its prefix; others are reliable
    Variances variances;
    std::vector<Ros2Device> devices;
    LogSettings log;
};

}    // namespace anogate
