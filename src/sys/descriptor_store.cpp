#include <sys/descriptor_store.hpp>
#include <sys/notify.hpp>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

namespace anogate {
namespace {

constexpr int first_passed = 3;    // SD_LISTEN_FDS_START
constexpr int max_passed = 1024;
constexpr int patience_ms = 500;

int number(const char* text) {
    int value = -1;
    const std::string_view digits = text ? text : "";
    const auto [end, ec] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return ec == std::errc{} && end == digits.data() + digits.size() ? value : -1;
}

void remove_from_store(const std::string& name) { notify_systemd("FDSTOREREMOVE=1\nFDNAME=" + name, {}, Patience::some); }

}    // namespace

std::vector<NamedDescriptor> receive_descriptors() {
    const char* passed_names = std::getenv("LISTEN_FDNAMES");
    std::string names = passed_names ? passed_names : "";
    const bool is_ours = number(std::getenv("LISTEN_PID")) == ::getpid();
    const int count = is_ours ? std::min(number(std::getenv("LISTEN_FDS")), max_passed) : 0;
    for (const char* variable : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"}) ::unsetenv(variable);
    std::vector<NamedDescriptor> descriptors;
    for (int i = 0; i < count; ++i) {
        const std::size_t end = std::min(names.find(':'), names.size());
        const std::string name = names.substr(0, end);
        names.erase(0, end + 1);
        if (::fcntl(first_passed + i, F_SETFD, FD_CLOEXEC) != 0) continue;
        const bool is_new = std::none_of(descriptors.begin(), descriptors.end(), [&](const auto& d) { return d.first == name; });
        descriptors.emplace_back(name, UniqueFd{first_passed + i});
        if (is_new) remove_from_store(name);    // removes all of that name
    }
    return descriptors;
}

// FDPOLL=0: otherwise systemd closes a stored descriptor on an error, for example a UDP socket whose peer refuses datagrams.
bool store_descriptors(const std::string& name, std::span<const int> descriptors) {
    return notify_systemd("FDSTORE=1\nFDPOLL=0\nFDNAME=" + name, descriptors, Patience::some);
}

// systemd closes the other end after it has processed everything.
bool await_systemd() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return false;
    const UniqueFd ours{ends[0]};
    UniqueFd theirs{ends[1]};
    const int passed[] = {theirs.get()};
    if (!notify_systemd("BARRIER=1", passed, Patience::some)) return false;
    theirs = {};
    pollfd closed{ours.get(), 0, 0};
    return ::poll(&closed, 1, patience_ms) == 1;
}

}    // namespace anogate
