// Tells systemd how we are (the documented datagram protocol of $NOTIFY_SOCKET). Without systemd nothing happens.
#pragma once
#include <ano/time.hpp>

#include <optional>
#include <string_view>

namespace anogate {

/// Sends one message such as "READY=1". False when there is nobody to tell, or the message did not get through.
bool notify_systemd(std::string_view message) noexcept;

/// How often the watchdog wants to hear "WATCHDOG=1": half of what it is set to. Nothing: it is not set for us.
std::optional<ano::Duration> watchdog_interval() noexcept;

}    // namespace anogate
