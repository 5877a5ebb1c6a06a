// Secrets from the random numbers of the system.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

namespace anogate {

/// Two hex digits for each of so many bytes. std::nullopt: the system has none, see errno.
std::optional<std::string> random_hex(std::size_t bytes);
/// So many decimal digits, each number of them as likely as any other; at most 9.
std::optional<std::string> random_digits(std::size_t count);

}    // namespace anogate
