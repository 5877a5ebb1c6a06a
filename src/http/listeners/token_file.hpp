// The file with the tokens of the network listeners.
#pragma once
#include <http/listeners/admission.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// Lines `view TOKEN` and `control TOKEN`; empty lines and lines that begin with # are ignored. A token has 16 to 256 letters, digits
/// and characters of -._~+/=, so that it can be sent in a header.
Expected<std::vector<Token>> parse_tokens(std::string_view text);

/// The tokens of the file. A missing file is made with one random token of each sort, readable by our user only; missing folders are
/// made as well.
Expected<std::vector<Token>> read_or_make_tokens(const std::string& path);

/// Eight hex digits that distinguish the file from those of other gateways. They stay the same as long as the file exists.
std::string id_of_token_file(const std::string& path);

/// The error that read_or_make_tokens() would return for the file or its folder; makes nothing.
Expected<void> check_tokens(const std::string& path);

}    // namespace anogate::http
