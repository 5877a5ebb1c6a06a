// anoctl __complete devices|links|names|parameters|commands|fields WORD...: words for shell completion, from the running gateway,
// from one of its devices, or from the message table.
#pragma once
#include "anoctl.hpp"

#include <span>

namespace anoctl {

/// Writes one word per line, "0xDC<tab>flight controller, fc". WORD... are those of the command line so far, which may contain
/// --control. Writes nothing if no gateway responds within 300 ms (no device within 1.5 s), and never an error message.
/// With `fields`, the last WORD is the one being typed. It offers "cmd=" for the message named before it, then "cmd=action";
/// without "cmd=" in shells that treat '=' as a separate word.
int complete(std::span<const char* const> words, Streams& streams) noexcept;

/// The command that shells call; not shown in --help.
inline constexpr char complete_command[] = "__complete";

}    // namespace anoctl
