#include <log/log_line.hpp>
#include <runtime/standstill_log.hpp>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration spacing = std::chrono::seconds{10};
constexpr int at_once = 5;

}    // namespace

void StandstillLog::stood(const StallDetector::Turn& turn, ano::TimePoint now) {
    if (!turn.is_reported) return;
    if (now < next_) return void(++unreported_);
    next_ = std::max(next_, now - (at_once - 1) * spacing) + spacing;
    const double seconds = std::chrono::duration<double>(turn.stood).count();
    const char* why = turn.suspended > ano::Duration::zero() ? "the computer slept" : "stopped, or the computer was too busy";
    const std::string more = unreported_ == 0 ? "" : "; " + std::to_string(std::exchange(unreported_, 0)) + " more times before";
    log_warning("stalled for at least {:.1f} s ({}): frames received meanwhile count as that old{}", seconds, why, more);
}

void StandstillLog::finish() const {
    if (unreported_ > 0) log_warning("stalled {} more times", unreported_);
}

}    // namespace anogate
