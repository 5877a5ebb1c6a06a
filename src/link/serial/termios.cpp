// termios2 and BOTHER are in the kernel's headers, which can't be included together with <termios.h>.
#include <link/serial/serial_settings.hpp>
#include <link/serial/termios.hpp>
#include <sys/errors.hpp>

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/major.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <filesystem>

#include <algorithm>
#include <thread>

namespace anogate::terminal {
namespace {

void set_line(termios2& t, const SerialSettings& settings) {
    t.c_iflag = t.c_oflag = t.c_lflag = 0;
    t.c_iflag |= IGNBRK;
    t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;    // no HUPCL: closing must not reset the connected board
    if (settings.parity != Parity::none) t.c_cflag |= PARENB;
    if (settings.parity == Parity::odd) t.c_cflag |= PARODD;
    if (settings.stop_bits == 2) t.c_cflag |= CSTOPB;
    if (settings.flow == FlowControl::hardware) t.c_cflag |= CRTSCTS;
    t.c_ispeed = t.c_ospeed = settings.baud;
    t.c_cc[VMIN] = 1;
    t.c_cc[VTIME] = 0;
}

bool is_same_line(const termios2& a, const termios2& b) {
    constexpr tcflag_t rates = CBAUD | CBAUD << IBSHIFT;    // the same as c_ispeed and c_ospeed
    return a.c_iflag == b.c_iflag && a.c_oflag == b.c_oflag && a.c_lflag == b.c_lflag &&
           (a.c_cflag & ~rates) == (b.c_cflag & ~rates) && a.c_ispeed == b.c_ispeed && a.c_ospeed == b.c_ospeed &&
           a.c_cc[VMIN] == b.c_cc[VMIN] && a.c_cc[VTIME] == b.c_cc[VTIME];
}

void set_modem_line(int fd, int line, bool on) noexcept { ::ioctl(fd, on ? TIOCMBIS : TIOCMBIC, &line); }

// Drivers without this option refuse; the error is ignored.
void ask_for_low_latency(int fd) noexcept {
    serial_struct serial{};
    if (::ioctl(fd, TIOCGSERIAL, &serial) != 0) return;
    serial.flags = static_cast<int>(static_cast<unsigned>(serial.flags) | ASYNC_LOW_LATENCY);
    ::ioctl(fd, TIOCSSERIAL, &serial);
}

bool is_pseudo(int fd) noexcept {
    struct stat status {};
    return ::fstat(fd, &status) == 0 && major(status.st_rdev) >= UNIX98_PTY_SLAVE_MAJOR &&
           major(status.st_rdev) < UNIX98_PTY_SLAVE_MAJOR + UNIX98_PTY_MAJOR_COUNT;
}

std::size_t bytes_in(int fd, unsigned long queue) noexcept {
    int bytes = 0;
    return ::ioctl(fd, queue, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

}    // namespace

// Setting unchanged values again makes some chips lose the bytes that they are receiving.
Expected<std::uint32_t> configure(int fd, const SerialSettings& settings, bool is_receiving) {
    termios2 t{};
    if (::ioctl(fd, TCGETS2, &t) != 0) return Unexpected{errno == ENOTTY ? "this is not a serial port" : error_text(errno)};
    const termios2 before = t;
    set_line(t, settings);
    if (!(is_receiving && is_same_line(before, t)) && ::ioctl(fd, TCSETS2, &t) != 0)
        return Unexpected{"the driver does not support " + std::to_string(settings.baud) +
                          " baud with these settings: " + error_text(errno)};
    if (settings.low_latency) ask_for_low_latency(fd);
    if (settings.dtr) set_modem_line(fd, TIOCM_DTR, *settings.dtr);
    if (settings.rts) set_modem_line(fd, TIOCM_RTS, *settings.rts);
    return ::ioctl(fd, TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}

void make_raw(int fd) noexcept {
    termios2 t{};
    if (::ioctl(fd, TCGETS2, &t) != 0) return;
    set_line(t, SerialSettings{});
    ::ioctl(fd, TCSETS2, &t);
}

bool is_port_at(int fd, const std::string& path) noexcept {
    struct stat open {
    }, named{};
    if (::fstat(fd, &open) != 0 || ::stat(path.c_str(), &named) != 0) return false;
    if (!S_ISCHR(open.st_mode) || !S_ISCHR(named.st_mode) || open.st_rdev != named.st_rdev) return false;
    if ((::fcntl(fd, F_GETFL) & O_ACCMODE) != O_RDWR) return false;
    pollfd hung_up{fd, 0, 0};
    return ::poll(&hung_up, 1, 0) >= 0 && (hung_up.revents & (POLLHUP | POLLERR | POLLNVAL)) == 0;
}

// The kernel clears TIOCEXCL at the last close of a port, but for a pseudo-terminal only when its master closes: after a kill it would
// stay locked until then.
void claim(int fd) noexcept {
    if (!is_pseudo(fd)) ::ioctl(fd, TIOCEXCL);
}
void release_exclusive(int fd) noexcept { ::ioctl(fd, TIOCNXCL); }

// First waits for the driver's buffer, by its size and the rate; then for the chip's buffer, if the driver reports it.
void wait_until_sent(int fd, Duration byte_time, const std::atomic<bool>& stop) noexcept {
    constexpr Duration max_pause = std::chrono::milliseconds{20};
    constexpr Duration min_pause = std::chrono::microseconds{50};
    while (const std::size_t bytes = unsent(fd)) {
        if (stop) return;
        std::this_thread::sleep_for(std::clamp<Duration>(static_cast<Duration::rep>(bytes) * byte_time, min_pause, max_pause));
    }
    unsigned status = 0;
    int result = 0;
    while (!stop && (result = ::ioctl(fd, TIOCSERGETLSR, &status)) == 0 && (status & TIOCSER_TEMT) == 0)
        std::this_thread::sleep_for(std::clamp<Duration>(byte_time, min_pause, max_pause));
    if (!stop && result != 0) ::ioctl(fd, TCSBRK, 1);    // tcdrain()
}

bool enable_rs485_by_rts(int fd, bool active_low) noexcept {
    serial_rs485 rs485{};
    rs485.flags = SER_RS485_ENABLED | (active_low ? SER_RS485_RTS_AFTER_SEND : SER_RS485_RTS_ON_SEND);
    return ::ioctl(fd, TIOCSRS485, &rs485) == 0;
}

void disable_rs485(int fd) noexcept {
    serial_rs485 rs485{};
    ::ioctl(fd, TIOCSRS485, &rs485);
}

std::string driver(int fd) {
    struct stat status {};
    if (::fstat(fd, &status) != 0) return {};
    const std::string device = std::to_string(major(status.st_rdev)) + ":" + std::to_string(minor(status.st_rdev));
    std::error_code none;
    return std::filesystem::read_symlink("/sys/dev/char/" + device + "/device/driver", none).filename().string();
}

std::size_t unsent(int fd) noexcept { return bytes_in(fd, TIOCOUTQ); }
std::size_t unread(int fd) noexcept { return bytes_in(fd, FIONREAD); }
void discard_output(int fd) noexcept { ::ioctl(fd, TCFLSH, TCOFLUSH); }
void discard_input(int fd) noexcept { ::ioctl(fd, TCFLSH, TCIFLUSH); }

}    // namespace anogate::terminal
