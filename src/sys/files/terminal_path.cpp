#include <sys/errors.hpp>
#include <sys/files/held_folder.hpp>
#include <sys/files/own_folder.hpp>
#include <sys/files/terminal_path.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <array>

namespace anogate {
namespace {

namespace fs = std::filesystem;

enum class There { nothing, ours, anothers, no_link };

struct Found {
    There what = There::nothing;
    fs::path leads_to;
};

Found find(const HeldFolder& folder, const std::string& name) {
    struct stat info {};
    if (::fstatat(folder.fd(), name.c_str(), &info, AT_SYMLINK_NOFOLLOW) != 0) return {};
    std::array<char, 4096> target{};
    const ssize_t size = ::readlinkat(folder.fd(), name.c_str(), target.data(), target.size());
    if (!S_ISLNK(info.st_mode) || size < 0) return {There::no_link, {}};
    const fs::path leads_to{std::string{target.data(), static_cast<std::size_t>(size)}};
    if (leads_to.parent_path() != "/dev/pts") return {There::no_link, {}};
    return {info.st_uid == ::geteuid() ? There::ours : There::anothers, leads_to};
}

}    // namespace

// symlink() never follows or replaces an existing file; a check before the call could not guarantee that.
Expected<void> link_to_terminal(const std::string& device, const fs::path& path) {
    const auto folder = HeldFolder::of(folder_of(path));
    if (!folder) return Unexpected{path.string() + ": " + folder.error()};
    const std::string name = path.filename();
    const There there = find(*folder, name).what;
    if (there == There::anothers)
        return Unexpected{path.string() + " is a symbolic link of another user and is left alone; choose another path"};
    if (there == There::ours) ::unlinkat(folder->fd(), name.c_str(), 0);
    if (there != There::no_link && ::symlinkat(device.c_str(), folder->fd(), name.c_str()) == 0) return {};
    if (there == There::no_link || errno == EEXIST)
        return Unexpected{path.string() + " exists, was not created by anogated and is left alone; choose another path"};
    return Unexpected{error_text(path.string(), errno)};
}

void remove_link_to(const std::string& device, const fs::path& path) {
    const auto folder = HeldFolder::of(folder_of(path));
    if (!folder) return;
    const std::string name = path.filename();
    if (const Found found = find(*folder, name); found.what == There::ours && found.leads_to == device)
        ::unlinkat(folder->fd(), name.c_str(), 0);
}

}    // namespace anogate
