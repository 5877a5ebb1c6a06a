#include <link/device_holder.hpp>
#include <link/errors.hpp>
#include <link/serial_link.hpp>
#include <link/termios.hpp>

#include <algorithm>

#include <fcntl.h>
#include <sys/file.h>

namespace anogate {
namespace {

std::string busy_text(const std::string& device) {
    const std::string holder = device_holder(device);
    return device + " is in use" + (holder.empty() ? " by another program" : " by " + holder);
}

/// What is written "ttyUSB0" or "/dev/ttyUSB0:115200" by those who know it from other programs.
std::string absent_text(const std::string& device) {
    const std::size_t colon = device.rfind(':');
    const bool baud = colon != device.npos && device.size() - colon > 3 &&
                      device.find_first_not_of("0123456789", colon + 1) == device.npos;
    std::string meant = device.find('/') == device.npos ? "/dev/" : "";
    if (meant.empty() && !baud) return device + " is not there";
    meant += baud ? device.substr(0, colon) + ",baud=" + device.substr(colon + 1) : device;
    return device + " is not there (did you mean " + meant + "?)";
}

std::string open_error_text(const std::string& device, int error) {
    switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV: return absent_text(device);
    case EBUSY: return busy_text(device);
    case EACCES:
        return device +
               ": no permission (the user must be in the group of the device, usually dialout: sudo usermod -aG dialout $USER, "
               "and log in again)";
    default: return error_text(device, error);
    }
}

}    // namespace

Expected<UniqueFd> SerialLink::open_wire() {
    const SerialSettings& serial = settings().serial;
    UniqueFd fd{::open(serial.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!fd) return Unexpected{open_error_text(serial.device, errno)};
    // Exclusive among programs that lock, by flock; for all but root's, by TIOCEXCL, where that is gone with us however we end.
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return Unexpected{busy_text(serial.device)};
    terminal::claim(fd.get());
    if (auto ready = make_ready(fd.get()); !ready) {
        terminal::give_back(fd.get());
        return Unexpected{serial.device + ": " + ready.error()};
    }
    terminal::discard_input(fd.get());
    wire_ = fd.get();
    return fd;
}

Expected<void> SerialLink::make_ready(int fd) {
    const auto baud = terminal::configure(fd, settings().serial);
    if (!baud) return Unexpected{baud.error()};
    actual_baud_ = *baud;
    return begin_half_duplex(fd);
}

// Closing waits for what the driver still holds: it goes. What is on its way (in a pty: read by nobody yet) stays.
void SerialLink::leave_wire(int fd) {
    if (terminal::unsent(fd) > 0 || rs485_) terminal::discard_output(fd);
    if (rs485_) rs485_->close();
    if (rs485_by_driver_) terminal::disable_rs485(fd);
    terminal::give_back(fd);
    wire_ = -1;
}

void SerialLink::half_duplex(bool active_low, std::function<void(bool)> send) {
    rs485_active_low_ = active_low;
    rs485_ = std::make_unique<HalfDuplex>(context_.io, std::move(send));
}

// A driver that can turn the transceiver by its RTS line is told to. Whether the transceiver hangs on that line or on the GPIO
// line of the configuration can't be seen from here: the GPIO line is driven all the same.
Expected<void> SerialLink::begin_half_duplex(int fd) {
    if (!rs485_) return {};
    rs485_by_driver_ = terminal::enable_rs485_by_rts(fd, rs485_active_low_);
    return rs485_->open(fd, std::chrono::duration_cast<Duration>(std::chrono::nanoseconds{std::nano::den / byte_rate()}));
}

ssize_t SerialLink::write_some(std::span<const iovec> pieces) {
    if (!rs485_) return StreamSession::write_some(pieces);
    rs485_->writing();
    const ssize_t n = StreamSession::write_some(pieces);
    const int error = errno;
    rs485_->written();
    errno = error;
    return n;
}

std::string SerialLink::gone_text(int error) const {
    const std::string& device = settings().serial.device;
    return error == 0 || error == EIO || error == ENXIO || error == ENODEV ? device + " was unplugged"
                                                                           : error_text(device, error);
}

std::size_t SerialLink::unsent() const {
    if (wire_ < 0) return 0;
    return std::max<std::size_t>(terminal::unsent(wire_), rs485_ && rs485_->is_sending() ? 1 : 0);
}

std::size_t SerialLink::held_by_driver() const { return wire_ < 0 ? 0 : terminal::unsent(wire_); }

std::uint32_t SerialLink::byte_rate() const {
    const SerialSettings& s = settings().serial;
    return uart_rate(actual_baud_ != 0 ? actual_baud_ : s.baud, s.parity != Parity::none, s.stop_bits);
}

// To a USB modem class device the rate is a word without meaning: it takes what the bus carries.
std::uint32_t SerialLink::line_rate() const {
    const Pace pace = settings().serial.pace;
    if (pace == Pace::off || (pace == Pace::automatic && terminal::driver(fd()) == "cdc_acm")) return 0;
    return byte_rate();
}

LinkFacts SerialLink::facts() const {
    LinkFacts facts{{"device", settings().serial.device},
                    {"baud", std::int64_t{wire_ < 0 || actual_baud_ == 0 ? settings().serial.baud : actual_baud_}}};
    if (rs485_) facts.push_back({"rs485", rs485_by_driver_ ? "by the driver and a GPIO line" : "by a GPIO line"});
    if (pacing().is_on()) facts.push_back({"paced", std::int64_t{pacing().rate()}});
    return facts;
}

}    // namespace anogate
