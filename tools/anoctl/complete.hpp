// anoctl __complete devices|links WORD...: what the gateway that runs knows, for the completions of shells.
#pragma once
#include "anoctl.hpp"

#include <span>

namespace anoctl {

/// One a line, "0xDC<tab>flight controller, fc"; WORD... are those of the command line so far, which may have --control. Nothing when
/// no gateway answers within 300 ms, and never a word about why.
int complete(std::span<const char* const> words, Streams& streams) noexcept;

/// The command that shells call; --help does not show it.
inline constexpr char complete_command[] = "__complete";

}    // namespace anoctl
