#include <ano/typed.hpp>
#include <host/waypoints.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace ano::host {
namespace {

constexpr std::uint8_t all_of_them = 0xFF;    // in a question: asks for their number

bool is_on_earth(const Waypoint& w) noexcept { return std::abs(w.lat) <= 90 && std::abs(w.lng) <= 180; }

// The waypoint as the device stores it: rounded to the step of the wire.
Waypoint rounded(const Request& write) {
    std::vector<std::uint8_t> frame(overhead + write.data.size());
    encode(frame, 0, 0, write.id, write.data);
    return waypoint_in(FrameView{frame}).value_or(Waypoint{});
}

std::string list_of(const std::vector<std::uint8_t>& numbers) {
    std::string list;
    for (const std::uint8_t num : numbers) list += (list.empty() ? "" : ", ") + std::to_string(num);
    return list;
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
        return finish_silent({"number_of_waypoints"}, ended.evidence, now, {"probably_stores_none"});
    const std::size_t count = std::min(as<"waypoint_read">(*ended.answer)->get<"num">(), all_of_them);
    if (ended.tag == ask_count) {
        waypoints_.assign(count, {});
        return gather(count, now);
    }
    if (count != waypoints_.size())
        return finish({Ending::failed, {"changes", hex_of(device().address()), Fault{"waypoints"}}, {}}, now);
    if (!missing().empty()) return finish({Ending::incomplete, {"waypoint_missing", missing().front()}, {}}, now);
    finish({}, now);
}

void WaypointsPut::start(TimePoint now) {
    for (const Waypoint& waypoint : waypoints_) {
        auto request = waypoint_write(waypoint, write);
        if (!request) return finish({Ending::invalid, {"waypoint_invalid", waypoint.num}, {}}, now);
        request->patience.sends = 3;    // then it is read back
        request->patience.late = std::chrono::milliseconds{3500};
        writes_.push_back(std::move(*request));
    }
    presence_ = device().presence();
    next(now);
}

void WaypointsPut::next(TimePoint now) {
    if (at_ == writes_.size()) return ask(WaypointsGet::how_many(ask_count), now);
    begun_at_.reset();
    is_acknowledged_ = is_written_again_ = false;
    mismatches_ = 0;
    silence_ = {};
    write_it(now);
}

void WaypointsPut::write_it(TimePoint now) {
    if (!begun_at_) begun_at_ = now;
    ask(writes_[at_], now);
}

void WaypointsPut::ended(const Ended& ended, TimePoint now) {
    if (ended.evidence.sent > 1 || device().presence() != presence_) may_have_restarted_ = true;
    switch (ended.tag) {
    case write: return written(ended, now);
    case read_back: return was_read_back(ended, now);
    default:
        if (ended.outcome != Outcome::answered)
            return finish_silent({"number_of_waypoints"}, ended.evidence, now, {"probably_stores_none"});
        counted(as<"waypoint_read">(*ended.answer)->get<"num">(), now);
    }
}

void WaypointsPut::written(const Ended& ended, TimePoint now) {
    is_acknowledged_ = ended.outcome == Outcome::answered;
    if (is_acknowledged_ && at_ == 0) renew_identity();
    if (!is_acknowledged_) {
        const unsigned before = silence_.sent;
        silence_ = ended.evidence;
        silence_.sent += before;
    }
    if (!is_acknowledged_) return ask_patiently(now);
    acknowledged_at_ = now;
    ask(WaypointsGet::waypoint(waypoints_[at_].num, read_back), now);
}

// The device may be busy with storing the waypoint, or with a repetition of the same write.
void WaypointsPut::ask_patiently(TimePoint now) {
    Request question = WaypointsGet::waypoint(waypoints_[at_].num, read_back);
    question.patience = {.sends = 2, .wait = std::chrono::milliseconds{500}};
    ask(question, now);
}

void WaypointsPut::was_read_back(const Ended& ended, TimePoint now) {
    const auto stored = ended.outcome == Outcome::answered ? waypoint_in(*ended.answer) : std::nullopt;
    const bool is_as_written = stored && *stored == rounded(writes_[at_]);
    if (!is_acknowledged_ && !is_as_written) {
        if (stored) ++mismatches_;
        silence_.is_heard = silence_.is_heard || stored;
        if (mismatches_ < 2 && now - *begun_at_ < patience) return write_it(now);
        return finish_unacknowledged(order(), silence_, now, {"stores_no_more"});
    }
    if (!stored && now - acknowledged_at_ < patience) return ask_patiently(now);
    if (!stored) return finish({Ending::refused, {"not_returned", hex_of(device().address()), number()}, ended.evidence}, now);
    // The device may have restarted with its old list between the write and this answer.
    if (!is_as_written && !std::exchange(is_written_again_, true)) return write_it(now);
    stored_.push_back(*stored);
    if (!is_acknowledged_) ++(silence_.unfit.empty() ? unacknowledged_ : wrongly_acknowledged_);
    if (!is_as_written) changed_.push_back(waypoints_[at_].num);
    ++at_;
    next(now);
}

void WaypointsPut::counted(std::uint8_t count, TimePoint now) {
    count_ = count;
    if (count < wanted_count() || may_have_restarted_ || !changed_.empty() || waypoints_.size() > 1) return look_again(now);
    finish_stored(now);
}

std::size_t WaypointsPut::wanted_count() const {
    std::size_t wanted = 0;
    for (const Waypoint& waypoint : waypoints_) wanted = std::max(wanted, waypoint.num + std::size_t{1});
    return wanted;
}

void WaypointsPut::finish_stored(TimePoint now) {
    Fault remark;
    const auto add = [&](Fault clause) { remark = remark.empty() ? std::move(clause) : Fault{"and", remark, std::move(clause)}; };
    if (!changed_.empty()) add({"stored_differently", changed_.size(), list_of(changed_)});
    if (unacknowledged_ > 0) add({"stored_unacknowledged", unacknowledged_});
    if (wrongly_acknowledged_ > 0) add({"stored_wrongly_acknowledged", wrongly_acknowledged_});
    if (const std::size_t wanted = wanted_count(); count_ > wanted)
        add({"old_waypoints", hex_of(device().address()), count_, count_ - wanted});
    finish({Ending::done, std::move(remark), {}}, now);
}

void WaypointsPut::look_again(TimePoint now) {
    look_ = std::make_unique<WaypointsGet>(device());
    look_->on_end([this](TimePoint later) { looked(later); });
    look_->start(now);
}

// Only the list as read now counts: the value read back may have been an earlier answer, or from an older list.
void WaypointsPut::looked(TimePoint now) {
    if (end()) return;
    const Ending looked = look_->end()->ending;
    if (looked != Ending::done && looked != Ending::incomplete) return finish_as(*look_, now);
    const auto& all = look_->waypoints();
    std::map<std::uint8_t, std::size_t> last;    // of those with the same number
    for (std::size_t i = 0; i < waypoints_.size(); ++i) last[waypoints_[i].num] = i;
    changed_.clear();
    bool is_lost = false;
    for (const auto& [num, i] : last) {
        const auto has = [&, num = num](const Waypoint& waypoint) { return num < all.size() && all[num] == waypoint; };
        if (const Waypoint as_written = rounded(writes_[i]); has(as_written)) {
            stored_[i] = as_written;
            continue;
        }
        changed_.push_back(num);
        is_lost = is_lost || !has(stored_[i]);
    }
    const std::string who = hex_of(device().address());
    if (finds_another()) return finish_another({}, now);
    // A waypoint stored with another value may also be from the old list, read back after the restart.
    at_ = last.size() - changed_.size();
    if (is_lost) return finish({Ending::failed, {"waypoints_lost", who, list_of(changed_)}, {}}, now);
    if (may_have_restarted_ && looked != Ending::done) return finish_as(*look_, now);
    if (!changed_.empty() && at_ == 0) return finish({Ending::failed, {"waypoints_not_stored", who, list_of(changed_)}, {}}, now);
    at_ = waypoints_.size();
    finish_stored(now);
}

void WaypointsPut::cancel(TimePoint now) {
    look_.reset();
    finish({Ending::cancelled, {"waypoints_written", at_, waypoints_.size()}, {}}, now);
}

}    // namespace ano::host
