#include <sys/process_figures.hpp>
#include <sys/unique_fd.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <ctime>
#include <memory>

namespace anogate {
namespace {

std::optional<std::uint64_t> count_of_fds() {
    struct Close {
        void operator()(DIR* folder) const { ::closedir(folder); }
    };
    const std::unique_ptr<DIR, Close> folder{::opendir("/proc/self/fd")};
    if (!folder) return std::nullopt;
    std::uint64_t count = 0;
    while (const dirent* entry = ::readdir(folder.get()))    // NOLINT(concurrency-mt-unsafe): the folder is ours
        if (entry->d_name[0] != '.') ++count;
    return count - 1;    // without the descriptor of the folder itself
}

std::uint64_t max_fds() {
    rlimit limit{};
    return ::getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

double unix_time_at_boot() {
    timespec since_boot{};
    ::clock_gettime(CLOCK_BOOTTIME, &since_boot);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration<double>(now).count() - static_cast<double>(since_boot.tv_sec) -
           static_cast<double>(since_boot.tv_nsec) * 1e-9;
}

}    // namespace

std::optional<ProcessTimes> parse_stat(std::string_view text) {
    const auto name_end = text.rfind(')');    // the program name may contain any characters
    if (name_end == std::string_view::npos) return std::nullopt;
    text.remove_prefix(name_end + 1);
    constexpr std::size_t first = 3;    // the number of the first field after the name
    std::array<std::uint64_t, 25> fields{};
    for (std::size_t number = first; number < fields.size(); ++number) {
        const auto begin = text.find_first_not_of(' ');
        if (begin == std::string_view::npos) return std::nullopt;
        text.remove_prefix(begin);
        const auto end = std::min(text.find(' '), text.size());
        std::from_chars(text.data(), text.data() + end,
                        fields[number]);    // other fields may be negative or letters
        text.remove_prefix(end);
    }
    return ProcessTimes{fields[14] + fields[15], fields[22], fields[23], fields[24]};
}

ProcessFigures this_process() {
    ProcessFigures figures;
    std::array<char, 1024> text{};
    const UniqueFd file{::open("/proc/self/stat", O_RDONLY | O_CLOEXEC)};
    const ssize_t size = file ? ::read(file.get(), text.data(), text.size()) : 0;
    const double tick = 1.0 / static_cast<double>(::sysconf(_SC_CLK_TCK));
    if (const auto times = parse_stat({text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))})) {
        figures.cpu_s = static_cast<double>(times->ticks) * tick;
        figures.started_at_s = unix_time_at_boot() + static_cast<double>(times->started_ticks) * tick;
        figures.virtual_bytes = times->virtual_bytes;
        figures.resident_bytes = times->resident_pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    }
    figures.open_fds = count_of_fds();
    figures.max_fds = max_fds();
    return figures;
}

}    // namespace anogate
