// Logs new and removed peers, with a limited number of lines.
#pragma once
#include <sys/alarm.hpp>

#include <cstdint>
#include <string>
#include <string_view>

namespace anogate {

/// A host that sends from many ports is a new peer with each of them, and must not fill the disk with lines. Therefore at most 32
/// lines are logged per five seconds, and one line with the number of the others.
class PeerLog {
public:
    explicit PeerLog(AlarmClock& alarms) : rest_{alarms, [this] { log_rest(); }} {}

    void came(const std::string& link, const std::string& peer, ano::TimePoint now);
    /// `why` may be empty.
    void went(const std::string& link, const std::string& peer, std::string_view why, ano::TimePoint now);
    /// To be called at the end of the program: logs the rest at once.
    void finish();

private:
    bool may_log(ano::TimePoint now);
    void log_rest();

    Alarm rest_;
    ano::TimePoint ends_at_ = ano::TimePoint::min();
    int lines_ = 0;
    std::uint64_t unreported_ = 0;
};

}    // namespace anogate
