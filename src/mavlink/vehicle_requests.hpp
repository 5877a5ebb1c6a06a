// Requests to the gateway about a device, and its responses.
#pragma once
#include <http/answer.hpp>
#include <mavlink/device_commands.hpp>
#include <mavlink/mission_items.hpp>
#include <mavlink/parameter_table.hpp>
#include <mavlink/station_command.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate::mavlink {

struct DeviceRequest {
    std::string method, target, body;
};

DeviceRequest call_request(std::uint8_t address, const DeviceCommand& command);
DeviceRequest parameters_request(std::uint8_t address);
DeviceRequest parameter_request(std::uint8_t address, const std::string& name, const ano::Number& value);
DeviceRequest waypoints_request(std::uint8_t address);
DeviceRequest put_waypoints_request(std::uint8_t address, const std::vector<Waypoint>& waypoints);

bool is_success(const http::Outcome& outcome) noexcept;
/// How the command ended: accepted only if the device acknowledged it.
Result result_of(const http::Outcome& outcome) noexcept;
/// std::nullopt: not such a response.
std::optional<std::vector<DeviceParameter>> parameters_in(const std::string& body);
std::optional<ano::Number> stored_value_in(const std::string& body);
std::optional<std::vector<Waypoint>> waypoints_in(const std::string& body);

}    // namespace anogate::mavlink
