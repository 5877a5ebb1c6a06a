// The file with the tokens of the network doors.
#pragma once
#include <http/admission.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// Lines `view TOKEN` and `control TOKEN`; empty ones and those that begin with # say nothing. A token has 16 to 256 letters, digits
/// and characters of -._~+/=, so that it can stand in a header.
Expected<std::vector<Token>> parse_tokens(std::string_view text);

/// What the file has. When there is none it is made, readable for us alone, with one random token of each sort; folders above it
/// are made as well.
Expected<std::vector<Token>> read_or_make_tokens(const std::string& path);

/// What read_or_make_tokens() would say against the file, or the folder that it would be made in; makes nothing.
Expected<void> check_tokens(const std::string& path);

}    // namespace anogate::http
