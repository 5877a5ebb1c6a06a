// JSON from outside, as files and command lines have it.
#pragma once
#include "anoctl.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// "-" is standard input. Throws UsageError when it can't be read, or is not JSON.
nlohmann::json json_in_file(const std::string& path, Streams& streams);

/// `where`: the name of the file, or what else begins the text of the fault. Throws UsageError when it is not JSON, has a key twice, or is nested
/// too deep.
nlohmann::json json_with_comments(std::string_view text, const std::string& where);
/// The same without comments.
nlohmann::ordered_json json_in_text(std::string_view text, const std::string& where);

}    // namespace anoctl
