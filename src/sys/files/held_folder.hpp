// An open folder for creating files: moving the folder or replacing it by a link has no effect on us.
#pragma once
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <filesystem>
#include <string>

namespace anogate {

/// Symbolic links in the path are followed only if root or our own user owns them.
class HeldFolder {
public:
    HeldFolder() = default;    // has no folder
    static Expected<HeldFolder> of(const std::filesystem::path& path);

    /// Returns the descriptor. Afterwards no other function may be called.
    UniqueFd take() noexcept { return std::move(fd_); }
    int fd() const noexcept { return fd_.get(); }
    /// Whether only root and our user can change where its path leads.
    bool is_fixed() const noexcept { return fixed_; }
    /// A path of the entry `name` in it that no other user can redirect.
    std::string at(const std::string& name) const { return "/proc/self/fd/" + std::to_string(fd_.get()) + "/" + name; }

private:
    bool enter(const char* name);

    UniqueFd fd_;
    bool fixed_ = true;
};

}    // namespace anogate
