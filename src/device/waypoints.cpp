#include <device/waypoints.hpp>

#include <algorithm>

namespace ano::device {
namespace {

constexpr std::uint8_t how_many = 0xFF;

Waypoint waypoint_of(const View<"waypoint">& view) {
    return {view.get<"lng">(),
            view.get<"lat">(),
            view.get<"alt">(),
            view.get<"spd">(),
            view.get<"yaw">(),
            view.get<"fun">(),
            {view.get<"cmd1">(), view.get<"cmd2">(), view.get<"cmd3">(), view.get<"cmd4">()}};
}

}    // namespace

void Waypoints::allow(std::size_t count) {
    allowed_ = std::min(count, max_waypoints);
    resize(list_.size());
    list_.reserve(allowed_);
}

Outcome Waypoints::process(const View<"waypoint_read">& question, Reply& reply) const {
    const std::uint8_t num = question.get<"num">();
    if (allowed_ == 0) return Outcome::unknown;
    if (num == how_many) {
        Draft<"waypoint_read"> answer;
        return answer.set<"num">(list_.size()) ? reply.send(answer) : Outcome::unknown;
    }
    if (num >= list_.size()) return Outcome::unknown;
    const Waypoint& w = list_[num];
    Draft<"waypoint"> answer;
    const bool all = answer.set<"num">(num) && answer.set<"lng">(w.lng) && answer.set<"lat">(w.lat) && answer.set<"alt">(w.alt) &&
                     answer.set<"spd">(w.spd) && answer.set<"yaw">(w.yaw) && answer.set<"fun">(w.fun) &&
                     answer.set<"cmd1">(w.cmd[0]) && answer.set<"cmd2">(w.cmd[1]) && answer.set<"cmd3">(w.cmd[2]) &&
                     answer.set<"cmd4">(w.cmd[3]);
    return all ? reply.send(answer) : Outcome::unknown;    // always true for values that a host has written
}

Outcome Waypoints::process(const View<"waypoint">& written, Reply& reply) {
    const std::size_t num = written.get<"num">();
    if (num > list_.size() || num >= allowed_) return Outcome::unknown;
    const Waypoint waypoint = waypoint_of(written);
    if (may_ && !may_(num, waypoint)) return Outcome::refused;
    if (num == list_.size()) list_.push_back(waypoint);
    else list_[num] = waypoint;
    return reply.acknowledge();
}

}    // namespace ano::device
