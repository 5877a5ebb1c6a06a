// Shell completions of the programs.
#pragma once
#include "programs.hpp"

#include <string>

namespace reference {

std::string bash_completion(const Program& program);
std::string zsh_completion(const Program& program);
std::string fish_completion(const Program& program);

}    // namespace reference
