// Names as ROS 2 allows them, from any text.
#pragma once
#include <set>
#include <string>
#include <string_view>

namespace anogate {

/// Letters, digits and single underscores, of which the first is a letter and the last is no underscore; at most 64 bytes. `instead` is
/// such a name: it stands before a digit, and for a text in which nothing can stay.
std::string ros_name(std::string_view text, std::string_view instead);

/// For fields and constants: the same in one case.
std::string lower_case_name(std::string_view text, std::string_view instead);
std::string upper_case_name(std::string_view text, std::string_view instead);

/// "flight_controller" as "FlightController": for the name of a message.
std::string camel_case(std::string_view name);

/// `name`, or with a number behind it where `taken` has it; `taken` has it then.
std::string unique_name(const std::string& name, std::set<std::string>& taken);

}    // namespace anogate
