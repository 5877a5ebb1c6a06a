// Commands and their results as JSON, in std_msgs/String on PREFIX/command and PREFIX/command_result.
#pragma once
#include <http/answer.hpp>
#include <sys/expected.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// {"command": "TAKE_OFF", "values": [150], "id": "7"}
struct CommandText {
    static constexpr std::size_t max_size = 4096, max_id = 64;    // bytes

    std::string command;    // the name or the number of the command, as the device describes it
    std::string body;       // of POST /devices/A/commands/C
    std::string id;         // chosen by the sender, returned in the result; empty: none
};

/// The error is one clause.
Expected<CommandText> parse_command(std::string_view json);

/// The result of a command: {"id": "7", "command": "TAKE_OFF", "ok": true, "result": {...}}, or with "ok": false and "error".
std::string command_result(const CommandText& command, const http::Outcome& outcome);
/// For a command that was not sent. `command`: what is known of it.
std::string command_failure(const CommandText& command, const std::string& error);

}    // namespace anogate
