#include <log/log_queue.hpp>

#include <spdlog/common.h>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate {
namespace {

std::uint64_t lines(std::string_view text) {
    return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')) + (text.ends_with('\n') ? 0 : 1);
}

}    // namespace

void LogQueue::push(spdlog::level::level_enum level, spdlog::log_clock::time_point at, std::string_view text,
                    bool plain) noexcept {
    if (waiting_.lost == 0 && size_ < room) {
        try {
            waiting_.messages.push_back({level, at, std::string{text}, plain});
            size_ += sizeof(LogMessage) + text.size();
            return;
        } catch (const std::bad_alloc&) {    // the message is lost, as with a full queue
        }
    }
    waiting_.lost += lines(text);
}

LogQueue::Batch LogQueue::pop_all() noexcept {
    size_ = 0;
    return std::exchange(waiting_, {});
}

}    // namespace anogate
