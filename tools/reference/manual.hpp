// The manual pages of the programs, the configuration and the HTTP API.
#pragma once
#include <http/routes.hpp>

#include <span>
#include <string>

namespace reference {

std::string anogated_page();                                               // anogated(8)
std::string anoctl_page();                                                 // anoctl(1)
std::string anogate_ros2_page();                                           // anogate-ros2(8)
std::string anogate_mavlink_page();                                        // anogate-mavlink(8)
std::string anogate_mqtt_page();                                           // anogate-mqtt(8)
std::string configuration_page();                                          // anogate.json(5)
std::string api_page(std::span<const anogate::http::Routes::Row> rows);    // anogate-api(7)

}    // namespace reference
