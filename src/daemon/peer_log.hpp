// Which peers came and went, in few lines.
#pragma once
#include <link/alarm.hpp>

#include <spdlog/spdlog.h>

#include <string>
#include <utility>

namespace anogate {

/// A stranger is a new peer with every port that it sends from, and its lines must not fill the disk. So there are at most 32
/// lines in five seconds, and one for the number of the rest.
class PeerLog {
public:
    explicit PeerLog(AlarmClock& alarms) : rest_{alarms, [this] { tell_rest(); }} {}

    void came(const std::string& link, const std::string& peer, ano::TimePoint now) {
        if (may_say(now)) spdlog::info("{}: peer {}", link, peer);
    }
    void went(const std::string& link, const std::string& peer, ano::TimePoint now) {
        if (may_say(now)) spdlog::info("{}: peer {} is gone", link, peer);
    }
    /// At the end of the program: at once.
    void finish() {
        rest_.cancel();
        tell_rest();
    }

private:
    static constexpr int max_lines = 32;
    static constexpr ano::Duration period = std::chrono::seconds{5};

    bool may_say(ano::TimePoint now) {
        if (now >= ends_at_ && !rest_.is_set()) {
            ends_at_ = now + period;
            lines_ = 0;
        }
        if (lines_ < max_lines) return ++lines_, true;
        ++unsaid_;
        if (!rest_.is_set()) rest_.set(ends_at_);
        return false;
    }
    void tell_rest() {
        if (unsaid_ > 0) spdlog::info("peers came or went {} times more", std::exchange(unsaid_, 0));
    }

    Alarm rest_;
    ano::TimePoint ends_at_ = ano::TimePoint::min();
    int lines_ = 0;
    std::uint64_t unsaid_ = 0;
};

}    // namespace anogate
