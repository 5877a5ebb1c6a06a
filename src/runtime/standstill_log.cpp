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

void StandstillLog::stood(const LoopWatch::Turn& turn, ano::TimePoint now) {
    if (!turn.is_told) return;
    if (now < next_) return void(++unsaid_);
    next_ = std::max(next_, now - (at_once - 1) * spacing) + spacing;
    const double seconds = std::chrono::duration<double>(turn.stood).count();
    const char* why = turn.suspended > ano::Duration::zero() ? "the machine slept" : "stopped, or the machine was too busy";
    const std::string more = unsaid_ == 0 ? "" : "; " + std::to_string(std::exchange(unsaid_, 0)) + " times more before";
    log_warning("stood still for at least {:.1f} s ({}): what came meanwhile counts as that old{}", seconds, why, more);
}

void StandstillLog::finish() const {
    if (unsaid_ > 0) log_warning("stood still {} times more", unsaid_);
}

}    // namespace anogate
