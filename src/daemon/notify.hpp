// Tells systemd the state of the program (the documented datagram protocol of $NOTIFY_SOCKET). Without systemd nothing happens.
#pragma once
#include <ano/time.hpp>

#include <optional>
#include <span>
#include <string_view>

namespace anogate {

/// Sends one message such as "READY=1". False without systemd, or when the message could not be sent.
bool notify_systemd(std::string_view message) noexcept;
/// Whether a message waits for room in systemd's queue: up to 0.2 s.
enum class Patience { none, some };
/// The same with descriptors, at most 253, which systemd gets copies of.
bool notify_systemd(std::string_view message, std::span<const int> descriptors, Patience patience) noexcept;

/// How often to send "WATCHDOG=1": half the time of the watchdog. Nothing: there is none for this process.
std::optional<ano::Duration> watchdog_interval() noexcept;

}    // namespace anogate
