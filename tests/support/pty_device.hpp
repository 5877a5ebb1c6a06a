// A serial device that can be plugged in and unplugged: a pseudo-terminal whose master side is the device.
#pragma once
#include "bytes.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

namespace support {

/// `path` is a link to the terminal while the device is plugged in.
class PtyDevice {
public:
    explicit PtyDevice(std::string path) : path_{std::move(path)} { plug(); }
    ~PtyDevice() { unplug(); }
    PtyDevice(const PtyDevice&) = delete;
    PtyDevice& operator=(const PtyDevice&) = delete;

    void plug() {
        fd_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        char name[64];
        if (fd_ < 0 || ::grantpt(fd_) != 0 || ::unlockpt(fd_) != 0 || ::ptsname_r(fd_, name, sizeof name) != 0)
            throw std::runtime_error{"no pseudo-terminal"};
        terminal_ = name;
        std::filesystem::create_symlink(terminal_, path_);
    }
    void unplug() {
        if (fd_ < 0) return;
        std::filesystem::remove(path_);
        ::close(fd_);
        fd_ = -1;
    }

    const std::string& path() const { return path_; }
    const std::string& terminal() const { return terminal_; }    // /dev/pts/N
    int fd() const { return fd_; }

    /// Returns the number of accepted bytes.
    std::size_t write(std::span<const std::uint8_t> bytes) {
        const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }
    /// The bytes received since the last call, at most `most`.
    Bytes read(std::size_t most = 65536) {
        Bytes bytes(most);
        const ssize_t n = ::read(fd_, bytes.data(), bytes.size());
        bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
        return bytes;
    }
    /// Reads again, and returns all bytes received so far.
    const Bytes& heard() {
        for (Bytes more = read(); !more.empty(); more = read()) heard_ = std::move(heard_) + more;
        return heard_;
    }
    termios settings() const {
        termios t{};
        ::tcgetattr(fd_, &t);
        return t;
    }

private:
    std::string path_;
    std::string terminal_;
    int fd_ = -1;
    Bytes heard_;
};

/// A program at the other end of a pseudo-terminal, or of a serial port.
class PortUser {
public:
    explicit PortUser(const std::string& path) : fd_{::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)} {}
    PortUser(PortUser&& other) noexcept : fd_{std::exchange(other.fd_, -1)}, heard_{std::move(other.heard_)} {}
    ~PortUser() { close(); }

    bool is_open() const { return fd_ >= 0; }
    void close() {
        if (fd_ >= 0) ::close(fd_);
        fd_ = -1;
    }
    int fd() const { return fd_; }
    std::size_t write(std::span<const std::uint8_t> bytes) {
        const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }
    const Bytes& heard() {
        Bytes more(65536);
        for (ssize_t n; (n = ::read(fd_, more.data(), more.size())) > 0;)
            heard_.insert(heard_.end(), more.begin(), more.begin() + n);
        return heard_;
    }

private:
    int fd_;
    Bytes heard_;
};

}    // namespace support
