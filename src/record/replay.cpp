#include <record/replay.hpp>

#include <ano/address.hpp>
#include <ano/control.hpp>
#include <gateway/tunnel.hpp>

#include <algorithm>
#include <chrono>

namespace anogate {
namespace {

constexpr std::uint64_t longest_ns = 1'000'000'000ull * 3600 * 24 * 365;    // of any file: what is beyond can't be told apart

// What can't be read may be anything.
bool may_hide_a_risk(ano::FrameView tunnel_frame) noexcept {
    const auto content = unwrap(tunnel_frame, {});
    if (!content) return true;
    if (content->inner.empty()) return false;
    InnerFrames frames{content->inner};
    while (const auto inner = frames.next())
        if (ano::address::is_host(inner->source()) || ano::is_control(*inner) || is_tunnel_frame(*inner)) return true;
    return !frames.good();
}

}    // namespace

Risk risk_of(ano::FrameView frame) noexcept {
    if (ano::address::is_host(frame.source())) return Risk::of_host;
    if (ano::is_control(frame)) return Risk::command;
    return is_tunnel_frame(frame) && may_hide_a_risk(frame) ? Risk::tunnel : Risk::none;
}

ano::Duration ReplayClock::elapsed(const RecordedFrame& frame) noexcept {
    const bool has_boottime = frame.boottime_ns > 0 && last_boottime_ > 0;
    const std::uint64_t before = has_boottime ? last_boottime_ : last_time_,
                        now = has_boottime ? frame.boottime_ns : frame.time_ns;
    if (begun_ && now > before) elapsed_ns_ = std::min(elapsed_ns_ + std::min(now - before, longest_ns), longest_ns);
    begun_ = true;
    last_time_ = frame.time_ns;
    last_boottime_ = frame.boottime_ns;
    return std::chrono::nanoseconds{elapsed_ns_};
}

ano::Duration ReplayClock::at_rate(ano::Duration elapsed) const noexcept {
    if (rate_ <= 0) return {};
    const std::chrono::duration<double, std::nano> whole = elapsed;
    return std::chrono::duration_cast<ano::Duration>(
        std::chrono::duration<double, std::nano>{std::min(whole.count() / rate_, static_cast<double>(longest_ns))});
}

std::optional<ano::Duration> ReplayPlan::due(const RecordedFrame& frame) {
    const ano::Duration elapsed = clock_.elapsed(frame);
    is_over_ = options_.to > ano::Duration{} && elapsed >= options_.to;
    if (is_over_ || elapsed < options_.from || !is_wanted(frame)) return std::nullopt;
    switch (options_.commands ? Risk::none : risk_of(frame.frame)) {
    case Risk::none: return clock_.at_rate(elapsed - options_.from);
    case Risk::of_host: ++kept_back_.of_hosts; break;
    case Risk::command: ++kept_back_.commands; break;
    case Risk::tunnel: ++kept_back_.tunnels; break;
    }
    return std::nullopt;
}

bool ReplayPlan::is_wanted(const RecordedFrame& frame) const {
    if (frame.direction != Direction::in) return false;
    const auto& links = options_.links;
    return links.empty() || std::find(links.begin(), links.end(), frame.link) != links.end();
}

}    // namespace anogate
