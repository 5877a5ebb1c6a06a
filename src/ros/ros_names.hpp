// Converts any text to a name that ROS 2 allows.
#pragma once
#include <set>
#include <string>
#include <string_view>

namespace anogate {

/// Letters, digits and single underscores, beginning with a letter and not ending with an underscore; at most 64 bytes. `instead`
/// must be such a name: it is put before a leading digit, and replaces a text without an allowed character.
std::string ros_name(std::string_view text, std::string_view instead);

/// The same in lower case for fields, in upper case for constants.
std::string lower_case_name(std::string_view text, std::string_view instead);
std::string upper_case_name(std::string_view text, std::string_view instead);

/// "flight_controller" as "FlightController": for the name of a message.
std::string camel_case(std::string_view name);

/// `name`, with a number appended if it is in `taken`. Adds the result to `taken`.
std::string unique_name(const std::string& name, std::set<std::string>& taken);

}    // namespace anogate
