#include <sys/descriptors_left.hpp>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace anogate {
namespace {

constexpr std::size_t for_links = 16, for_peers = 64;

std::size_t most_descriptors() noexcept {
    rlimit limit{};
    return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

}    // namespace

// A new descriptor gets the lowest free number.
std::size_t descriptors_left() noexcept {
    const int next = ::dup(STDERR_FILENO);
    if (next < 0) return 0;
    ::close(next);
    return most_descriptors() - std::min(most_descriptors(), static_cast<std::size_t>(next));
}

std::size_t descriptors_of_links() noexcept { return std::min(for_links, most_descriptors() / 4); }
std::size_t descriptors_of_links_and_peers() noexcept { return std::min(for_links + for_peers, most_descriptors() / 2); }

}    // namespace anogate
