// Secrets from the system's random source.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace anogate {

/// `bytes` random bytes as hex, two digits each. std::nullopt: no random numbers are available, see errno.
std::optional<std::string> random_hex(std::size_t bytes);
/// `count` random decimal digits, at most 9; all numbers are equally likely.
std::optional<std::string> random_digits(std::size_t count);

}    // namespace anogate
