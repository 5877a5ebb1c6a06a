#include <sys/device_watch.hpp>

#include <sys/inotify.h>

#include <cstddef>
#include <cstring>
#include <string_view>

namespace anogate {

void DeviceWatch::start() {
    UniqueFd fd{::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)};
    if (!fd || ::inotify_add_watch(fd.get(), "/dev", IN_CREATE | IN_DELETE | IN_ATTRIB | IN_MOVE | IN_ONLYDIR) < 0) return;
    descriptor_.open(std::move(fd));
    descriptor_.read_with([this] { read(); });
}

void DeviceWatch::read() {
    alignas(inotify_event) char events[4096];
    bool ours = false;
    for (ssize_t size; (size = ::read(descriptor_.fd(), events, sizeof events)) > 0;) {
        for (std::size_t at = 0; at < static_cast<std::size_t>(size);) {
            inotify_event event;
            std::memcpy(&event, events + at, sizeof event);
            const char* name = events + at + sizeof event;    // padded with zeros
            ours = ours || (event.mask & IN_Q_OVERFLOW) != 0 || (event.len > 0 && std::string_view{name}.starts_with(prefix_));
            at += sizeof event + event.len;
        }
    }
    if (ours) call_();
}

}    // namespace anogate
