#include <log/log_line.hpp>
#include <runtime/peer_log.hpp>

#include <new>
#include <utility>

namespace anogate {
namespace {

constexpr int max_lines = 32;
constexpr ano::Duration period = std::chrono::seconds{5};

}    // namespace

void PeerLog::came(const std::string& link, const std::string& peer, ano::TimePoint now) {
    if (may_log(now)) log_info("{}: peer {}", link, peer);
}

void PeerLog::went(const std::string& link, const std::string& peer, std::string_view why, ano::TimePoint now) {
    if (may_log(now)) log_info("{}: peer {} is gone{}{}", link, peer, why.empty() ? "" : ": ", why);
}

void PeerLog::finish() {
    rest_.cancel();
    log_rest();
}

bool PeerLog::may_log(ano::TimePoint now) {
    if (now >= ends_at_ && !rest_.is_set()) {
        ends_at_ = now + period;
        lines_ = 0;
    }
    if (lines_ < max_lines) return ++lines_, true;
    ++unreported_;
    try {
        if (!rest_.is_set()) rest_.set(ends_at_);
    } catch (const std::bad_alloc&) {}    // the next one tries again
    return false;
}

void PeerLog::log_rest() {
    if (unreported_ > 0) log_info("{} more peers came or went", std::exchange(unreported_, 0));
}

}    // namespace anogate
