// Functions for the kernel's terminal interface: any integer rate, raw mode, modem lines.
#pragma once
#include <gateway/settings.hpp>
#include <link/serial/serial_settings.hpp>
#include <sys/expected.hpp>

#include <atomic>
#include <string>

namespace anogate::terminal {

/// Sets raw mode and the line settings, clears HUPCL. Returns the actual rate (0: unknown), or an error with the refused setting.
/// For a port that `is_receiving`, unchanged settings are not set again.
Expected<std::uint32_t> configure(int fd, const SerialSettings& settings, bool is_receiving = false);
/// Raw mode for the user's side of a pseudo-terminal.
void make_raw(int fd) noexcept;

/// Whether `fd` is the device that is at `path` now, and not one that was unplugged or replaced.
bool is_port_at(int fd, const std::string& path) noexcept;

/// Prevents other users' programs (except root's) from opening the port, until release_exclusive(). Does nothing for a pseudo-terminal,
/// where the lock would outlast this program.
void claim(int fd) noexcept;
void release_exclusive(int fd) noexcept;

/// The name of the kernel driver of a port; empty: none, as for a pseudo-terminal.
std::string driver(int fd);

/// Bytes that are written but not yet on the wire; 0 if the driver does not report them.
std::size_t unsent(int fd) noexcept;
/// Blocks until the last bit is on the wire, as precisely as the driver reports it, or until soon after `stop`. For a separate
/// thread.
void wait_until_sent(int fd, Duration byte_time, const std::atomic<bool>& stop) noexcept;

/// Makes the driver switch an RS-485 transceiver by the RTS line (TIOCSRS485). False: not supported.
bool enable_rs485_by_rts(int fd, bool active_low) noexcept;
void disable_rs485(int fd) noexcept;
/// The number of received bytes that are not read yet.
std::size_t unread(int fd) noexcept;
/// Discards output that is not yet on the wire, so that closing does not wait for it.
void discard_output(int fd) noexcept;
/// Discards received bytes that are not read yet.
void discard_input(int fd) noexcept;

}    // namespace anogate::terminal
