// A file that can't be opened at once: a slow disk, for programs that open files without our read().
#pragma once
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>
#include <stdexcept>
#include <string>

namespace support {

/// While this object exists, opening the file takes 45 seconds (/proc/sys/fs/lease-break-time), in this process as well. Nothing
/// else may have the file open.
class LeasedFile {
public:
    explicit LeasedFile(const std::string& path) : fd_{::open(path.c_str(), O_RDWR | O_CLOEXEC)} {
        std::signal(SIGIO, SIG_IGN);    // sent when somebody opens the file
        struct stat facts {};
        if (::fcntl(fd_.get(), F_SETLEASE, F_WRLCK) != 0 || ::fstat(fd_.get(), &facts) != 0)
            throw std::runtime_error{"can't lease " + path};
        inode_ = ":" + std::to_string(facts.st_ino) + " ";
    }
    /// Whether somebody waits to open the file.
    bool is_awaited() const {
        std::ifstream locks{"/proc/locks"};
        for (std::string line; std::getline(locks, line);)
            if (line.find("BREAKING") != line.npos && line.find(inode_) != line.npos) return true;
        return false;
    }

private:
    anogate::UniqueFd fd_;
    std::string inode_;
};

}    // namespace support
