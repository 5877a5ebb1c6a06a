// A folder that is held while something is made in it: whoever moves it, or puts a link in its place, changes nothing for us.
#pragma once
#include <link/expected.hpp>
#include <link/unique_fd.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// On the way to it links are followed that root or our own user made, never one of another user.
class HeldFolder {
public:
    HeldFolder() = default;    // holds none
    static Expected<HeldFolder> of(const std::filesystem::path& path);

    /// The descriptor, for as long as it is wanted; nothing else may be asked then.
    UniqueFd take() noexcept { return std::move(fd_); }
    int fd() const noexcept { return fd_.get(); }
    /// Nobody but root and our user can lead its path elsewhere.
    bool is_fixed() const noexcept { return fixed_; }
    /// A path of what is called `name` in it, which nobody can lead elsewhere.
    std::string at(const std::string& name) const { return "/proc/self/fd/" + std::to_string(fd_.get()) + "/" + name; }

private:
    bool enter(const char* name);

    UniqueFd fd_;
    bool fixed_ = true;
};

}    // namespace anogate
