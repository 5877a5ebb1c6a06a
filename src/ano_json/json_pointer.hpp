// Places in JSON (RFC 6901).
#pragma once
#include <string>
#include <string_view>

namespace ano {

/// `key` as a step of a JSON pointer, with the preceding slash: "/a~1b".
std::string pointer_step(std::string_view key);

}    // namespace ano
