// Encodes text as a part of a request target.
#pragma once
#include <string>
#include <string_view>

namespace anogate::http {

/// `word`, in which every byte that has a meaning in a target is written as %XX.
std::string percent_encoded(std::string_view word);

}    // namespace anogate::http
