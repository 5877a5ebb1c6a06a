// Sends the state of the program to systemd (the documented datagram protocol of $NOTIFY_SOCKET). Without systemd, nothing is
// sent.
#pragma once
#include <ano/time.hpp>

#include <optional>
#include <span>
#include <string_view>

namespace anogate {

/// Sends one message such as "READY=1". False: no systemd, or the message could not be sent.
bool notify_systemd(std::string_view message) noexcept;
/// `some`: waits up to 0.2 s for room in systemd's queue.
enum class Patience { none, some };
/// The same with copies of at most 253 descriptors.
bool notify_systemd(std::string_view message, std::span<const int> descriptors, Patience patience) noexcept;

/// The interval for sending "WATCHDOG=1": half the time of the watchdog. std::nullopt: this process has no watchdog.
std::optional<ano::Duration> watchdog_interval() noexcept;

}    // namespace anogate
