// The rate that is set on a serial port, any integer: <termios.h> returns only the traditional rates.
#pragma once
#include <sys/ioctl.h>

#include <cstdint>

namespace support {

inline std::uint32_t rate_of(int fd) {
    struct {
        std::uint32_t flags[4];
        std::uint8_t line, cc[19];
        std::uint32_t input, output;
    } settings{};
    return ::ioctl(fd, _IOC(_IOC_READ, 'T', 0x2A, sizeof settings), &settings) == 0 ? settings.output : 0;
}

}    // namespace support
