// The messages with questions to devices and with their answers (protocol text, sections 3 and 4).
#pragma once
#include <ano/messages.hpp>

#include <cstdint>

namespace anogate::questions {

enum : std::uint8_t {
    waypoint_read = ano::id_of<"waypoint_read">,
    waypoint = ano::id_of<"waypoint">,
    command_query = ano::id_of<"command_query">,
    command_info = ano::id_of<"command_info">,
    parameter_command = ano::id_of<"parameter_command">,
    parameter_value = ano::id_of<"parameter_value">,
    parameter_info = ano::id_of<"parameter_info">,
    device_info = ano::id_of<"device_info">,
};

}    // namespace anogate::questions
