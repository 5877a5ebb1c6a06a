// Parses JSON from files and command lines.
#pragma once
#include "anoctl.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// Reads and parses a file; "-" is standard input. Throws UsageError if it is not readable or is not JSON.
nlohmann::json json_in_file(const std::string& path, Streams& streams);

/// `where`: the beginning of the error text, as the name of the file. Throws UsageError if the text is not JSON, contains a key
/// twice, or is nested too deeply.
nlohmann::json json_with_comments(std::string_view text, const std::string& where);
/// The same without comments.
nlohmann::ordered_json json_in_text(std::string_view text, const std::string& where);

}    // namespace anoctl
