#include <sys/descriptors_left.hpp>

#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace anogate {
namespace {

constexpr std::size_t for_own_work = 8, for_links = 16, for_peers = 64;
constexpr std::size_t for_own_files = 6;    // of those for own work: to read the configuration in a thread
constexpr std::size_t enough = 640;         // a higher number decides nothing: half of the rest is for 256 waiting clients

std::size_t most_descriptors() noexcept {
    rlimit limit{};
    return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

/// The free numbers in [first, last), counted until they are enough.
std::size_t free_numbers(std::size_t first, std::size_t last) noexcept {
    std::array<pollfd, 128> some{};
    std::size_t free = 0;
    while (first < last && free < enough) {
        const std::size_t count = std::min(some.size(), last - first);
        for (std::size_t i = 0; i < count; ++i) some[i] = {static_cast<int>(first + i), 0, 0};
        if (::poll(some.data(), count, 0) < 0) return free;
        free += static_cast<std::size_t>(std::count_if(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(count),
                                                       [](const pollfd& one) { return (one.revents & POLLNVAL) != 0; }));
        first += count;
    }
    return free;
}

// A new descriptor gets the lowest free number; higher ones may be in use.
std::size_t free_descriptors() noexcept {
    const int next = ::dup(STDERR_FILENO);
    if (next < 0) return 0;
    ::close(next);
    const auto first = static_cast<std::size_t>(next);
    return free_numbers(first, most_descriptors());
}

}    // namespace

std::size_t descriptors_left() noexcept {
    const std::size_t free = free_descriptors();
    return free - std::min(free, for_own_work);
}

bool may_use_reserved_descriptor() noexcept { return free_descriptors() > for_own_files; }

bool can_open_descriptors() noexcept {
    const int next = ::dup(STDERR_FILENO);
    if (next < 0) return false;
    ::close(next);
    return true;
}

std::size_t descriptors_of_links() noexcept { return std::min(for_links, most_descriptors() / 4); }
std::size_t descriptors_of_links_and_peers() noexcept { return std::min(for_links + for_peers, most_descriptors() / 2); }

}    // namespace anogate
