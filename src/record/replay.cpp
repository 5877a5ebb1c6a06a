#include <record/replay.hpp>

#include <ano/address.hpp>
#include <gateway/inhibit.hpp>

#include <algorithm>
#include <chrono>

namespace anogate {

bool may_command(ano::FrameView frame) noexcept {
    return ano::address::is_host(frame.source()) || is_control(frame) || may_bring_control(frame);
}

ano::Duration ReplayClock::due(const RecordedFrame& frame) noexcept {
    constexpr std::uint64_t longest_ns = 1'000'000'000ull * 3600 * 24 * 365;    // of any file: what is beyond can't be told apart
    const bool has_boottime = frame.boottime_ns > 0 && last_boottime_ > 0;
    const std::uint64_t before = has_boottime ? last_boottime_ : last_time_,
                        now = has_boottime ? frame.boottime_ns : frame.time_ns;
    if (begun_ && now > before) elapsed_ns_ = std::min(elapsed_ns_ + std::min(now - before, longest_ns), longest_ns);
    begun_ = true;
    last_time_ = frame.time_ns;
    last_boottime_ = frame.boottime_ns;
    const double ns = std::min(static_cast<double>(elapsed_ns_) / rate_, static_cast<double>(longest_ns));
    return std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double, std::nano>{ns});
}

}    // namespace anogate
