// What the kernel's terminal interface needs here: any integer rate, raw, and the modem lines.
#pragma once
#include <gateway/settings.hpp>
#include <link/expected.hpp>
#include <link/serial_settings.hpp>

#include <atomic>
#include <string>

namespace anogate::terminal {

/// Raw mode, the line settings, HUPCL cleared. What the driver made of the rate (0: it does not say), or what it refused. Of a port
/// that `is_receiving`, what is as it should be is left alone.
Expected<std::uint32_t> configure(int fd, const SerialSettings& settings, bool is_receiving = false);
/// Raw mode for the user's side of a pseudo-terminal.
void make_raw(int fd) noexcept;

/// Whether `fd` is the open port that `path` names now: not one that was unplugged, nor another device.
bool is_port_at(int fd, const std::string& path) noexcept;

/// Nobody else may open the port (root excepted), until give_back(). Not of a pseudo-terminal, which would outlive us.
void claim(int fd) noexcept;
void give_back(int fd) noexcept;

/// The name of the kernel's driver behind a port; empty where it has none, as a pseudo-terminal.
std::string driver(int fd);

/// Bytes that are written and not yet on the wire; 0 where the driver does not say.
std::size_t unsent(int fd) noexcept;
/// Returns when the last bit is on the wire, as exactly as the driver knows, or soon after `stop`. Blocks: for a thread of its own.
void wait_until_sent(int fd, Duration byte_time, const std::atomic<bool>& stop) noexcept;

/// Lets the driver itself turn an RS-485 transceiver on the RTS line (TIOCSRS485). False: it can't.
bool enable_rs485_by_rts(int fd, bool active_low) noexcept;
void disable_rs485(int fd) noexcept;
/// Bytes that have arrived and were not read.
std::size_t unread(int fd) noexcept;
/// Throws away what is written and not yet on the wire, so that closing does not wait for it.
void discard_output(int fd) noexcept;
/// Throws away what has arrived and was not read.
void discard_input(int fd) noexcept;

}    // namespace anogate::terminal
