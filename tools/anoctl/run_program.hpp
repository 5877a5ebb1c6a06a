// Runs another program and waits for it.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace anoctl {

/// Runs `words[0]`, looked up in PATH, with our standard streams. Returns its exit status, 128 + N when signal N ended it;
/// std::nullopt: it is not installed. Throws Failure when it can't be started.
std::optional<int> run_program(std::vector<std::string> words);

}    // namespace anoctl
