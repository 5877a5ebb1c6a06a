// anoctl __complete devices|links|names|parameters|commands|fields WORD...: words for the completions of shells, from the running gateway,
// from one of its devices, or from the message table.
#pragma once
#include "anoctl.hpp"

#include <span>

namespace anoctl {

/// Writes one per line, "0xDC<tab>flight controller, fc". WORD... are those of the command line so far, which may have --control. Writes
/// nothing when no gateway answers within 300 ms (no device within 1.5 s), and no error message. For fields, the last WORD is the one being
/// typed: it offers "cmd=" for the message before it, or then "cmd=action"; without "cmd=" in shells where '=' is a word of its own.
int complete(std::span<const char* const> words, Streams& streams) noexcept;

/// The command that shells call; --help does not show it.
inline constexpr char complete_command[] = "__complete";

}    // namespace anoctl
