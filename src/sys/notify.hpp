// Tells systemd the state of the program (the documented datagram protocol of $NOTIFY_SOCKET). Without systemd nothing happens.
#pragma once
#include <ano/time.hpp>

#include <optional>
#include <span>
#include <string_view>

namespace anogate {

/// Sends one message such as "READY=1". False without systemd, or when the message could not be sent.
bool notify_systemd(std::string_view message) noexcept;
/// `some`: waits up to 0.2 s for room in systemd's queue.
enum class Patience { none, some };
/// The same with at most 253 descriptors, of which systemd gets copies.
bool notify_systemd(std::string_view message, std::span<const int> descriptors, Patience patience) noexcept;

/// The interval for sending "WATCHDOG=1": half the time of the watchdog. std::nullopt: this process has no watchdog.
std::optional<ano::Duration> watchdog_interval() noexcept;

}    // namespace anogate
