// anoctl __complete devices|links|names|parameters|commands|fields WORD...: what the gateway that runs knows, or one of its devices, and
// the fields of messages, for the completions of shells.
#pragma once
#include "anoctl.hpp"

#include <span>

namespace anoctl {

/// One a line, "0xDC<tab>flight controller, fc"; WORD... are those of the command line so far, which may have --control. Nothing when
/// no gateway answers within 300 ms (no device within 1.5 s), and never a word about why. For fields, the last WORD is the one that is
/// being written: "cmd=", of the message that stands before it, or behind that "cmd=action"; without "cmd=" where '=' is a word of its own.
int complete(std::span<const char* const> words, Streams& streams) noexcept;

/// The command that shells call; --help does not show it.
inline constexpr char complete_command[] = "__complete";

}    // namespace anoctl
