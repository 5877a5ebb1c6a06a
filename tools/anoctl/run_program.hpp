// Runs another program and waits for it.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace anoctl {

/// Runs `words[0]`, looked up in PATH, with the standard streams of this process. Returns its exit status, or 128 + N if signal N
/// ended it; std::nullopt: it is not installed. Throws Failure if it can't be started.
std::optional<int> run_program(std::vector<std::string> words);

}    // namespace anoctl
