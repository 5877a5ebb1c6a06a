// The routes of devices in this process, with its own link.
#pragma once
#include "device_access.hpp"

#include <anoctl/anoctl.hpp>

#include <gateway/settings.hpp>

#include <cstdint>
#include <memory>
#include <optional>

namespace anoctl {

/// `io` and `streams` must outlive it. Messages about the link go to `err`. `there`: a device that is treated as known from the
/// beginning.
std::unique_ptr<DeviceAccess> link_access(anogate::asio::io_context& io, const anogate::LinkSettings& settings, Streams& streams,
                                          std::optional<std::uint8_t> there = std::nullopt);

}    // namespace anoctl
