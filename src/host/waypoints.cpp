#include <ano/typed.hpp>
#include <host/waypoints.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace ano::host {
namespace {

constexpr std::uint8_t all_of_them = 0xFF;    // in a question: how many there are

bool is_on_earth(const Waypoint& w) noexcept { return std::abs(w.lat) <= 90 && std::abs(w.lng) <= 180; }

// As the device stores it: rounded to the step of the wire.
Waypoint rounded(const Request& write) {
    std::vector<std::uint8_t> frame(overhead + write.data.size());
    encode(frame, 0, 0, write.id, write.data);
    return waypoint_in(FrameView{frame}).value_or(Waypoint{});
}

}    // namespace

std::optional<Waypoint> waypoint_in(FrameView frame) {
    const auto w = as<"waypoint">(frame);
    if (!w) return std::nullopt;
    return Waypoint{w->get<"num">(), w->get<"lng">(),
                    w->get<"lat">(), w->get<"alt">(),
                    w->get<"spd">(), w->get<"yaw">(),
                    w->get<"fun">(), {w->get<"cmd1">(), w->get<"cmd2">(), w->get<"cmd3">(), w->get<"cmd4">()}};
}

std::optional<Request> waypoint_write(const Waypoint& w, std::uint32_t tag) {
    Draft<"waypoint"> draft;
    if (w.num > last_waypoint || !is_on_earth(w) || !draft.set<"lng">(w.lng) || !draft.set<"lat">(w.lat)) return std::nullopt;
    (void)draft.set<"num">(w.num);
    (void)draft.set<"alt">(w.alt);
    (void)draft.set<"spd">(w.spd);
    (void)draft.set<"yaw">(w.yaw);
    (void)draft.set<"fun">(w.fun);
    (void)draft.set<"cmd1">(w.cmd[0]);
    (void)draft.set<"cmd2">(w.cmd[1]);
    (void)draft.set<"cmd3">(w.cmd[2]);
    (void)draft.set<"cmd4">(w.cmd[3]);
    return request(draft, tag);
}

Request WaypointsGet::how_many(std::uint32_t tag) { return waypoint(all_of_them, tag); }

Request WaypointsGet::waypoint(std::uint32_t num, std::uint32_t tag) {
    Draft<"waypoint_read"> draft;
    (void)draft.set<"num">(num);
    return request(draft, tag);
}

bool WaypointsGet::took(std::uint32_t i, FrameView answer) {
    const auto waypoint = waypoint_in(answer);
    if (!waypoint) return false;
    waypoints_[i] = *waypoint;
    return true;
}

void WaypointsGet::step_ended(const Ended& ended, TimePoint now) {
    if (ended.outcome != Outcome::answered)
        return finish_silent("number of waypoints", ended.evidence, now, "it probably keeps none");
    const std::size_t count = std::min(as<"waypoint_read">(*ended.answer)->get<"num">(), all_of_them);
    if (ended.tag == ask_count) {
        waypoints_.assign(count, {});
        return gather(count, now);
    }
    if (count != waypoints_.size())
        return finish({Ending::failed, hex_of(device().address()) + " changes while its waypoints are read", {}}, now);
    if (!missing().empty())
        return finish({Ending::incomplete, "waypoint " + std::to_string(missing().front()) + " did not come", {}}, now);
    finish({}, now);
}

void WaypointsPut::start(TimePoint now) {
    for (const Waypoint& waypoint : waypoints_) {
        auto request = waypoint_write(waypoint, write);
        if (!request)
            return finish(
                {Ending::invalid, "waypoint " + std::to_string(waypoint.num) + " is not on earth, or has no number", {}}, now);
        writes_.push_back(std::move(*request));
    }
    next(now);
}

void WaypointsPut::next(TimePoint now) {
    if (at_ == writes_.size()) return ask(WaypointsGet::how_many(ask_count), now);
    ask(writes_[at_], now);
}

void WaypointsPut::ended(const Ended& ended, TimePoint now) {
    const bool answered = ended.outcome == Outcome::answered;
    if (ended.tag == ask_count) {
        if (!answered) return finish_silent("number of waypoints", ended.evidence, now, "it probably keeps none");
        return counted(as<"waypoint_read">(*ended.answer)->get<"num">(), now);
    }
    const std::string number = "waypoint " + std::to_string(waypoints_[at_].num);
    if (ended.tag == write) {
        if (!answered)
            return finish_unacknowledged("write of " + number, ended.evidence, now, "it probably keeps no more, or none");
        return ask(WaypointsGet::waypoint(waypoints_[at_].num, read_back), now);
    }
    const auto stored = answered ? waypoint_in(*ended.answer) : std::nullopt;
    if (!stored)
        return finish({Ending::refused, hex_of(device().address()) + " acknowledged " + number + " and does not give it back",
                       ended.evidence},
                      now);
    stored_.push_back(*stored);
    if (*stored != rounded(writes_[at_])) ++changed_;
    ++at_;
    next(now);
}

void WaypointsPut::counted(std::uint8_t count, TimePoint now) {
    std::size_t wanted = 0;
    for (const Waypoint& waypoint : waypoints_) wanted = std::max(wanted, waypoint.num + std::size_t{1});
    std::string what;
    if (changed_ > 0) what = std::to_string(changed_) + " of them were stored otherwise than written";
    if (count > wanted) {
        if (!what.empty()) what += ", and ";
        what += hex_of(device().address()) + " has " + std::to_string(count) + ", the last " + std::to_string(count - wanted) +
                " are its old ones";
    }
    finish({Ending::done, std::move(what), {}}, now);
}

void WaypointsPut::cancel(TimePoint now) {
    finish({Ending::cancelled, std::to_string(at_) + " of " + std::to_string(waypoints_.size()) + " waypoints are written", {}},
           now);
}

}    // namespace ano::host
