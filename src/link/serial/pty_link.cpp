#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/make_link.hpp>
#include <link/serial/pty_link.hpp>
#include <link/serial/pty_settings.hpp>
#include <link/serial/termios.hpp>
#include <link/v7_keys.hpp>
#include <sys/errors.hpp>
#include <sys/files/own_folder.hpp>
#include <sys/files/terminal_path.hpp>

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/inotify.h>
#include <sys/stat.h>

#include <filesystem>

namespace anogate {
namespace {

namespace fs = std::filesystem;

constexpr Duration between_looks = std::chrono::milliseconds{100};    // polling where inotify is not available

// Gives access to the group dialout, as for serial ports.
void let_dialout_in(int terminal) {
    if (const group* dialout = ::getgrnam("dialout"); dialout && ::fchown(terminal, uid_t(-1), dialout->gr_gid) == 0)
        ::fchmod(terminal, 0660);
}

}    // namespace

Opened<UniqueFd> PtyLink::open_wire() {
    UniqueFd ours{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    char name[64];
    if (!ours || ::grantpt(ours.get()) != 0 || ::unlockpt(ours.get()) != 0 || ::ptsname_r(ours.get(), name, sizeof name) != 0)
        return Unexpected{error_text("can't open a pseudo-terminal", errno)};
    device_ = name;
    {
        const UniqueFd user_side = open_user_side();    // after its first close, our side reports when no program has it open
        if (!user_side) return Unexpected{error_text(device_, errno)};
        terminal::make_raw(user_side.get());
        let_dialout_in(user_side.get());
    }
    watch_users();
    const auto linked = link_path();
    watch_path();
    if (linked) return ours;
    lock_.release();
    look_.cancel();
    watch_.close();    // another pseudo-terminal may get this number; its users would count as ours
    return Unexpected{linked.error()};
}

UniqueFd PtyLink::open_user_side() const { return UniqueFd{::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)}; }

Expected<void> PtyLink::link_path() {
    const fs::path path = settings().as<PtySettings>().path;
    if (auto there = make_folder_of(path); !there) return there;
    if (auto taken = lock_.acquire(path); !taken) return Unexpected{std::move(taken.error().why)};
    return link_to_terminal(device_, path);
}

// The events only trigger a check: equal events are merged, so they can't be counted. The number of inotify instances per user is
// limited; without one, look_ polls.
void PtyLink::watch_users() {
    watch_.close();
    UniqueFd notify{::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)};
    if (!notify || ::inotify_add_watch(notify.get(), device_.c_str(), IN_OPEN) < 0)
        return look_.set(context_.host.now() + between_looks);
    watch_.open(std::move(notify));
    watch_.read_with([this] {
        alignas(inotify_event) char events[4096];
        while (::read(watch_.fd(), events, sizeof events) > 0) {}
        keep_path();
        if (watch_.is_open()) look_for_users();
    });
}

void PtyLink::look() {
    watch_users();
    watch_path();
    keep_path();
    if (fd() >= 0) look_for_users();
}

// Watches the current symbolic link at the path, even if another program made it, until it is removed.
void PtyLink::watch_path() {
    if (!watch_.is_open()) return;
    constexpr std::uint32_t gone = IN_DELETE_SELF | IN_MOVE_SELF | IN_ATTRIB;
    ::inotify_add_watch(watch_.fd(), settings().as<PtySettings>().path.c_str(), gone | IN_DONT_FOLLOW);
}

// Makes the symbolic link again if it was removed: by a cleaner of /tmp, or by a second gateway that had claimed the path and
// stopped.
void PtyLink::keep_path() {
    std::error_code ec;
    const fs::file_status there = fs::symlink_status(settings().as<PtySettings>().path, ec);
    if (!fs::exists(there)) {
        if (auto linked = link_path(); !linked) return fail(std::move(linked.error()));
    } else if (fs::read_symlink(settings().as<PtySettings>().path, ec) == device_) {
        return;
    }
    watch_path();
    if (!up_) context_.host.link_down(*this, no_user_error());
}

void PtyLink::came_up() { context_.host.link_down(*this, no_user_error()); }

// Our side reports POLLHUP while no program has the other side open. The data of the last program is read first.
void PtyLink::look_for_users() {
    pollfd ours{fd(), POLLIN, 0};
    if (::poll(&ours, 1, 0) < 0) return;
    const bool used = (ours.revents & POLLHUP) == 0;
    if (used && !up_) {
        up_ = true;
        context_.host.link_up(*this);
    }
    if (ours.revents & POLLIN) check_what_waits();
    if (used || ours.revents & POLLIN) resume_reading();
}

void PtyLink::read_ended(int error) {
    if (error != EIO) return fail(why_gone(error));
    pause_reading();
    if (up_) users_gone();
}

// Discards the data that the last program did not read, and resets its terminal settings.
void PtyLink::users_gone() {
    up_ = false;
    context_.host.link_down(*this, no_user_error());
    end_of_input();
    terminal::discard_output(fd());
    const UniqueFd user_side = open_user_side();
    if (!user_side) return fail(error_text(device_, errno));
    terminal::discard_input(user_side.get());
    terminal::release_exclusive(user_side.get());
    terminal::make_raw(user_side.get());
}

void PtyLink::leave_wire(int) {
    look_.cancel();
    watch_.close();
    up_ = false;
    remove_link_to(device_, settings().as<PtySettings>().path);
    lock_.release();
}

void PtyLink::stop_reading() {
    StreamLink::stop_reading();
    look_.cancel();
    watch_.stop_reading();
}

void PtyLink::stop() {
    StreamLink::stop();
    look_.cancel();
    watch_.close();
}

// Closing our side discards the data that the other side has not read.
std::size_t PtyLink::unsent() const {
    const UniqueFd user_side = open_user_side();
    return user_side ? terminal::unread(user_side.get()) : 0;
}

LinkError PtyLink::no_user_error() const {
    const std::string& path = settings().as<PtySettings>().path;
    std::error_code ec;
    const fs::path leads_to = fs::read_symlink(path, ec);
    if (ec || leads_to == device_) return {"nobody_there", "no program has opened " + path, {{"path", path}}};
    return path + " leads to " + leads_to.string() + ", which belongs to another program: choose another path for this link";
}

LinkError PtyLink::why_gone(int error) const { return error_text(device_, error == 0 ? EIO : error); }

LinkFacts PtyLink::facts() const {
    LinkFacts facts{{"path", settings().as<PtySettings>().path}, {"device", device_}};
    if (pacing().rate() > 0) facts.push_back({"paced", std::int64_t{pacing().rate()}});
    add_facts(facts);
    return facts;
}

namespace {

using namespace key_rows;

constexpr Key<LinkSettings> own_pty_keys[] = {
    text<own<PtySettings>, &PtySettings::path>("path", 1, max_path, "the symbolic link to create for the pseudo-terminal") |
        as("PATH") | needed,
};
constexpr auto pty_keys = with_v7(own_pty_keys, v7_rows<PtySettings>());

std::optional<SharedByTwo> shared_path(const LinkSettings& a, const LinkSettings& b) {
    const std::string& path = b.as<PtySettings>().path;
    if (path.empty() || a.as<PtySettings>().path != path) return std::nullopt;
    return SharedByTwo{"path", "'path' " + in_quotes(path) + " is already created by "};
}

}    // namespace

extern const LinkKind pty_kind;    // listed in kinds.cpp
constinit const LinkKind pty_kind{
    .name = "pty",
    .address = "path",
    .example = "/run/anogate/app",
    .help = "a pseudo-terminal at PATH, for programs that expect a serial port",
    .carries = Carries::bytes,
    .may_be_paced = true,
    .keys = pty_keys,
    .settings = [] { return KindSettings{PtySettings{}}; },
    .make = make_link_of<PtyLink>,
    .usual_name =
        [](const LinkSettings& link) {
            const std::string& path = link.as<PtySettings>().path;
            return path.substr(path.rfind('/') + 1);
        },
    .has_uart = [](const LinkSettings&) { return true; },    // such as a simulator in place of a device
    .path = [](const LinkSettings& link) { return LinkPath{.path = link.as<PtySettings>().path, .is_made = true}; },
    .validate = [](const LinkSettings& link, LinkFaults& faults) { check_v7(link.as<PtySettings>().v7, faults); },
    .shared = shared_path,
};

}    // namespace anogate
