// That one gateway alone makes what stands at a path: a lock that the kernel keeps, gone with its owner however that ends.
#pragma once
#include <link/unique_fd.hpp>

#include <filesystem>
#include <string>

#include <tl/expected.hpp>

namespace anogate {

/// The lock file is where no other user can put one: in /run/anogate for root and the service, in $XDG_RUNTIME_DIR/anogate for a user.
/// Where there is neither it is beside the path; if somebody else has put something there, the path is had without a lock,
/// for nobody is to be kept from it by that. The folder of the path is told by its number: a path may be written in several ways.
class PathClaim {
public:
    PathClaim() = default;
    PathClaim(const PathClaim&) = delete;
    PathClaim& operator=(const PathClaim&) = delete;
    ~PathClaim() { release(); }

    struct Refusal {
        std::string why;
        bool in_use = false;    // by another gateway, or another link of this one
    };
    /// Never waits. The folder of `path` must be there. Once more for the same path: it stays ours.
    tl::expected<void, Refusal> take(const std::filesystem::path& path);
    void release() noexcept;

private:
    enum class Lock { ours, in_use, impossible };
    Lock lock(bool trusted);

    UniqueFd folder_;     // of the lock file
    std::string name_;    // of the lock file
    UniqueFd lock_;
};

}    // namespace anogate
