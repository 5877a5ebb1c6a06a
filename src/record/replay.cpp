#include <record/replay.hpp>

#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <gateway/tunnel/tunnel.hpp>

#include <algorithm>
#include <chrono>

namespace anogate {
namespace {

constexpr std::uint64_t max_ns = 1'000'000'000ull * 3600 * 24 * 365;    // a year; longer times of a file are cut to it

constexpr std::size_t max_seen = 16;    // names of links

/// "fc, imu and radio"
std::string list_of(const std::vector<std::string>& words, const std::string& last) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
        text += (i == 0 ? "" : i + 1 < words.size() ? ", " : ' ' + last + ' ') + words[i];
    return text;
}

/// "0.4 s", "20 s"; always in seconds.
std::string seconds_text(ano::Duration time) {
    const auto tenths = std::chrono::duration_cast<std::chrono::milliseconds>(time + std::chrono::milliseconds{50}).count() / 100;
    std::string text = std::to_string(tenths / 10);
    if (tenths % 10 != 0 && tenths < 1000) text += '.' + std::to_string(tenths % 10);
    return text + " s";
}

bool is_of_host_or_control(ano::FrameView frame) noexcept {
    return ano::address::is_host(frame.source()) || ano::is_control(frame);
}

}    // namespace

Risk risk_of(ano::FrameView frame) noexcept {
    if (ano::address::is_host(frame.source())) return Risk::of_host;
    if (ano::is_control(frame)) return Risk::command;
    return may_contain(frame, is_of_host_or_control) ? Risk::tunnel : Risk::none;
}

ano::Duration ReplayClock::elapsed(const RecordedFrame& frame) noexcept {
    const bool has_boottime = frame.boottime_ns > 0 && last_boottime_ > 0;
    const std::uint64_t before = has_boottime ? last_boottime_ : last_time_,
                        now = has_boottime ? frame.boottime_ns : frame.time_ns;
    if (begun_ && now > before) elapsed_ns_ = std::min(elapsed_ns_ + std::min(now - before, max_ns), max_ns);
    begun_ = true;
    last_time_ = frame.time_ns;
    last_boottime_ = frame.boottime_ns;
    return std::chrono::nanoseconds{elapsed_ns_};
}

ano::Duration ReplayClock::at_rate(ano::Duration elapsed) const noexcept {
    if (rate_ <= 0) return {};
    const std::chrono::duration<double, std::nano> whole = elapsed;
    return std::chrono::duration_cast<ano::Duration>(
        std::chrono::duration<double, std::nano>{std::min(whole.count() / rate_, static_cast<double>(max_ns))});
}

std::optional<ano::Duration> ReplayPlan::due(const RecordedFrame& frame) {
    const ano::Duration elapsed = clock_.elapsed(frame);
    is_over_ = options_.to > ano::Duration{} && elapsed >= options_.to;
    if (!has_chosen_) note(frame, elapsed);
    if (is_over_ || elapsed < options_.from || !is_wanted(frame)) return std::nullopt;
    switch (options_.commands ? Risk::none : risk_of(frame.frame)) {
    case Risk::none: has_chosen_ = true; return clock_.at_rate(elapsed - options_.from);
    case Risk::of_host: ++kept_back_.of_hosts; break;
    case Risk::command: ++kept_back_.commands; break;
    case Risk::tunnel: ++kept_back_.tunnels; break;
    }
    return std::nullopt;
}

void ReplayPlan::note(const RecordedFrame& frame, ano::Duration elapsed) {
    has_frames_ = true;
    length_ = elapsed;
    if (!options_.links.empty() && seen_.size() < max_seen && std::find(seen_.begin(), seen_.end(), frame.link) == seen_.end())
        seen_.emplace_back(frame.link);
}

std::string ReplayPlan::why_nothing() const {
    if (has_chosen_) return {};
    if (!has_frames_) return "it contains no frames";
    const auto is_seen = [&](const std::string& link) { return std::find(seen_.begin(), seen_.end(), link) != seen_.end(); };
    const auto& links = options_.links;
    if (!links.empty() && std::none_of(links.begin(), links.end(), is_seen))
        return "there is no link " + list_of(links, "or") + " in it; it has " + list_of(seen_, "and");
    if (length_ < options_.from)
        return "it is " + seconds_text(length_) + " long, so there is nothing to replay from " + seconds_text(options_.from) +
               " on";
    if (kept_back_.of_hosts + kept_back_.commands + kept_back_.tunnels > 0)
        return "all received frames are from hosts or command a vehicle, so none is replayed; set commands=true to replay them";
    return "none of the requested frames was received";
}

bool ReplayPlan::is_wanted(const RecordedFrame& frame) const {
    if (frame.direction != Direction::in) return false;
    const auto& links = options_.links;
    return links.empty() || std::find(links.begin(), links.end(), frame.link) != links.end();
}

}    // namespace anogate
