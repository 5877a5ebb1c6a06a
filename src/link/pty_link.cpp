#include <link/errors.hpp>
#include <link/pty_link.hpp>
#include <link/termios.hpp>

#include <fcntl.h>
#include <grp.h>
#include <stdlib.h>
#include <sys/inotify.h>
#include <sys/stat.h>

#include <filesystem>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// So that the people who may use serial ports may use this one.
void let_dialout_in(const std::string& device) {
    if (const group* dialout = ::getgrnam("dialout"); dialout && ::chown(device.c_str(), uid_t(-1), dialout->gr_gid) == 0)
        ::chmod(device.c_str(), 0660);
}

}  // namespace

StreamLink::Opened PtyLink::open_wire() {
    UniqueFd ours{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    char name[64];
    if (!ours || ::grantpt(ours.get()) != 0 || ::unlockpt(ours.get()) != 0 ||
        ::ptsname_r(ours.get(), name, sizeof name) != 0)
        return {{}, error_text("no pseudo-terminal", errno)};
    device_ = name;
    user_side_ = UniqueFd{::open(name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!user_side_) return {{}, error_text(device_, errno)};
    terminal::make_raw(user_side_.get());
    let_dialout_in(device_);
    if (std::string error = link_path(device_); !error.empty()) return {{}, std::move(error)};
    watch_users();
    return {std::move(ours), {}};
}

// Replaces a link that an earlier run may have left, and nothing else.
std::string PtyLink::link_path(const std::string& device) {
    const fs::path path = settings().pty.path;
    std::error_code ec;
    fs::create_directories(path.parent_path(), ec);
    if (const auto there = fs::symlink_status(path, ec); fs::exists(there) && !fs::is_symlink(there))
        return path.string() + " exists and is not a link: it is left alone, choose another path";
    const fs::path fresh = path.string() + ".new";
    fs::remove(fresh, ec);
    fs::create_symlink(device, fresh, ec);
    if (!ec) fs::rename(fresh, path, ec);
    return ec ? error_text(path.string(), ec.value()) : std::string{};
}

void PtyLink::watch_users() {
    watch_.close();
    users_ = 0;
    UniqueFd notify{::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)};
    if (!notify || ::inotify_add_watch(notify.get(), device_.c_str(), IN_OPEN | IN_CLOSE) < 0) return;
    watch_.open(std::move(notify));
    watch_.read_with([this] { count_users(); });
}

void PtyLink::came_up() {
    if (!watch_.is_open()) {    // no way to see users: as if there always were one
        up_ = true;
        context_.host.link_up(*this);
    } else {
        context_.host.link_down(*this, "no program has " + settings().pty.path + " open");
    }
}

void PtyLink::count_users() {
    alignas(inotify_event) char buffer[4096];
    const ssize_t n = ::read(watch_.fd(), buffer, sizeof buffer);
    for (ssize_t at = 0; at < n;) {
        inotify_event event;
        std::memcpy(&event, buffer + at, sizeof event);
        at += static_cast<ssize_t>(sizeof event + event.len);
        if (event.mask & IN_OPEN) ++users_;
        if (event.mask & IN_CLOSE && users_ > 0) --users_;
    }
    if (users_ > 0) heard();
    else if (up_) users_gone();
}

void PtyLink::heard() {
    if (up_) return;
    up_ = true;
    context_.host.link_up(*this);
}

// What the last user did not read is not for the next one.
void PtyLink::users_gone() {
    up_ = false;
    context_.host.link_down(*this, "no program has " + settings().pty.path + " open");
    terminal::discard_output(fd());
    terminal::discard_input(user_side_.get());
    terminal::make_raw(user_side_.get());
}

void PtyLink::leave_wire(int) {
    watch_.close();
    up_ = false;
    std::error_code ec;
    if (fs::read_symlink(settings().pty.path, ec) == device_) fs::remove(settings().pty.path, ec);
    user_side_ = UniqueFd{};
}

void PtyLink::stop() {
    StreamLink::stop();
    watch_.close();
}

std::string PtyLink::gone_text(int error) const { return error_text(device_, error == 0 ? EIO : error); }

LinkFacts PtyLink::facts() const { return {{"path", settings().pty.path}, {"device", device_}}; }

}  // namespace anogate
