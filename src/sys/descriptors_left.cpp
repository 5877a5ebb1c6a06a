#include <sys/descriptors_left.hpp>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace anogate {
namespace {

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

std::size_t descriptors_of_links() noexcept {
    constexpr std::size_t usual = 16, part = 4;
    return std::min(usual, most_descriptors() / part);
}

}    // namespace anogate
