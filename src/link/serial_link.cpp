#include <link/device_holder.hpp>
#include <link/errors.hpp>
#include <link/serial_link.hpp>
#include <link/termios.hpp>

#include <fcntl.h>
#include <sys/file.h>

namespace anogate {
namespace {

std::string busy_text(const std::string& device) {
    const std::string holder = device_holder(device);
    return device + " is in use" + (holder.empty() ? " by another program" : " by " + holder);
}

std::string open_error_text(const std::string& device, int error) {
    switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV: return device + " is not there";
    case EBUSY: return busy_text(device);
    case EACCES: return device + ": no permission (the user must be in the group of the device, usually dialout)";
    default: return error_text(device, error);
    }
}

}  // namespace

StreamLink::Opened SerialLink::open_wire() {
    const SerialSettings& serial = settings().serial;
    UniqueFd fd{::open(serial.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!fd) return {{}, open_error_text(serial.device, errno)};
    // Exclusive for every user but root, by TIOCEXCL; for root too, among programs that lock, by flock.
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return {{}, busy_text(serial.device)};
    terminal::claim(fd.get());
    if (std::string error = terminal::configure(fd.get(), serial, actual_baud_); !error.empty()) {
        terminal::give_back(fd.get());
        return {{}, serial.device + ": " + error};
    }
    terminal::discard_input(fd.get());
    wire_ = fd.get();
    return {std::move(fd), {}};
}

// Closing waits for what the driver still holds: it goes. What is on its way (in a pty: read by nobody yet) stays.
void SerialLink::leave_wire(int fd) {
    if (terminal::unsent(fd) > 0) terminal::discard_output(fd);
    terminal::give_back(fd);
    wire_ = -1;
}

std::string SerialLink::gone_text(int error) const {
    const std::string& device = settings().serial.device;
    return error == 0 || error == EIO || error == ENXIO || error == ENODEV ? device + " was unplugged"
                                                                           : error_text(device, error);
}

// To a USB modem class device the rate is a word without meaning: it takes what the bus carries.
std::uint32_t SerialLink::line_rate() const {
    const SerialSettings& s = settings().serial;
    if (s.pace == Pace::off || (s.pace == Pace::automatic && terminal::driver(fd()) == "cdc_acm")) return 0;
    return uart_rate(actual_baud_ != 0 ? actual_baud_ : s.baud, s.parity != Parity::none, s.stop_bits);
}

std::size_t SerialLink::unsent() const { return wire_ < 0 ? 0 : terminal::unsent(wire_); }

LinkFacts SerialLink::facts() const {
    LinkFacts facts{{"device", settings().serial.device},
                    {"baud", std::int64_t{wire_ < 0 || actual_baud_ == 0 ? settings().serial.baud : actual_baud_}}};
    if (pacing().is_on()) facts.push_back({"paced", std::int64_t{pacing().rate()}});
    return facts;
}

}  // namespace anogate
