#include <ano/typed.hpp>
#include <host/device.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {
namespace {

// The parameter that a frame to a device asks for, or writes.
std::optional<std::uint16_t> parameter_in(FrameView request) noexcept {
    if (const auto value = as<"parameter_value">(request)) return value->get<"par_id">();
    const auto query = as<"parameter_command">(request);
    if (query && (query->get<"cmd">() == 2 || query->get<"cmd">() == 3)) return query->get<"val">();
    return std::nullopt;
}

}    // namespace

bool Device::ask(const Request& request, Asker& asker) {
    Exchange exchange{request, own_, address_, &asker};
    if (!exchange.is_askable() || !may_be_asked(exchange.frame())) return false;
    waiting_.push_back(std::move(exchange));
    return true;
}

bool Device::may_be_asked(FrameView request) const noexcept {
    const auto parameter = parameter_in(request);
    return !parameter || (parameter_count_ && *parameter < *parameter_count_);
}

void Device::forget(const Asker& asker) noexcept {
    for (const Exchange& exchange : sent_)
        if (exchange.asker() == &asker) remember(exchange, false);
    const auto is_of_it = [&](const Exchange& exchange) { return exchange.asker() == &asker; };
    sent_.remove_if(is_of_it);
    waiting_.remove_if(is_of_it);
}

Taken Device::take(FrameView frame, TimePoint now) {
    if (!may_be_of(frame.source(), address_)) return Taken::nothing;
    hear(frame, now);
    if (!Expectation::may_be_met_by(frame.id())) return Taken::nothing;
    const auto met = std::find_if(sent_.begin(), sent_.end(), [&](const Exchange& e) { return e.expects().is_met_by(frame); });
    if (met == sent_.end()) return past(frame);
    if (met->is_measured()) round_trip_.answered(now - met->first_sent(), met->sent() > 1);
    window_.answered();
    answered_at_ = now;
    end(sent_, met, Outcome::answered, frame, now);
    return Taken::ended;
}

// Device info and parameter count are taken from every frame, whichever host asked for it.
void Device::hear(FrameView frame, TimePoint now) {
    const auto forget_it = [&] {
        info_.reset();
        parameter_count_.reset();
        ++presence_;
    };
    if (heard_at_ && now - *heard_at_ >= away_after) forget_it();
    heard_at_ = now;
    if (const auto said = as<"device_info">(frame)) {
        DeviceInfo info{said->get<"dev_id">(), said->get<"hw_ver">(), said->get<"sw_ver">(),
                        said->get<"bl_ver">(), said->get<"pt_ver">(), std::string{said->get<"name">()}};
        if (info_ && *info_ != info) forget_it();
        info_ = std::move(info);
    }
    const auto count = as<"parameter_command">(frame);
    if (count && count->get<"cmd">() == 1) parameter_count_ = count->get<"val">();
}

Taken Device::past(FrameView frame) noexcept {
    for (std::size_t i = 1; i <= past_.size(); ++i) {
        auto& one = past_[(next_past_ + past_.size() - i) % past_.size()];
        if (!one || !one->expects.is_met_by(frame)) continue;
        return std::exchange(one->answered, true) ? Taken::doubled : Taken::late;
    }
    return frame.destination() == own_ ? Taken::unasked : Taken::foreign;
}

void Device::remember(const Exchange& exchange, bool answered) noexcept {
    past_[next_past_] = Past{exchange.expects(), answered, exchange.is_once() ? exchange.due() + late_for : TimePoint::min()};
    next_past_ = (next_past_ + 1) % past_.size();
}

// The exchange is taken off the list before the asker is called, since that may ask again at once.
void Device::end(Exchanges& from, Exchanges::iterator which, Outcome outcome, std::optional<FrameView> answer, TimePoint now) {
    Exchanges over;
    over.splice(over.end(), from, which);
    const Exchange& exchange = over.front();
    if (exchange.was_sent()) remember(exchange, outcome == Outcome::answered);
    const bool answers = answered_at_ && exchange.was_sent() && *answered_at_ >= exchange.first_sent();
    exchange.asker()->ended({outcome, exchange.tag(), answer, evidence_of(exchange), answers}, now);
}

std::optional<FrameView> Device::next_frame(TimePoint now) {
    expire(now);
    while (const Exchange* next = next_to_send(now)) {
        Exchanges& from = next->was_sent() ? sent_ : waiting_;
        const auto which = std::find_if(from.begin(), from.end(), [&](const Exchange& e) { return &e == next; });
        if (may_be_asked(next->frame())) return send(from, which, now);
        end(from, which, Outcome::not_there, {}, now);
    }
    return std::nullopt;
}

void Device::expire(TimePoint now) {
    const auto is_over = [&](const Exchange& e) { return e.is_on_its_way() && e.due() <= now; };
    for (auto over = std::find_if(sent_.begin(), sent_.end(), is_over); over != sent_.end();
         over = std::find_if(sent_.begin(), sent_.end(), is_over)) {
        window_.lost();
        if (!over->time_out()) end(sent_, over, Outcome::timeout, {}, now);
    }
}

std::size_t Device::on_their_way() const noexcept {
    return static_cast<std::size_t>(
        std::count_if(sent_.begin(), sent_.end(), [](const Exchange& e) { return e.is_on_its_way(); }));
}

const Exchange* Device::lost() const noexcept {
    const auto found = std::find_if(sent_.begin(), sent_.end(), [](const Exchange& e) { return !e.is_on_its_way(); });
    return found == sent_.end() ? nullptr : &*found;
}

// Lost requests are sent first.
const Exchange* Device::next_to_send(TimePoint now) const noexcept {
    if (on_their_way() >= window_.size()) return nullptr;
    if (const Exchange* again = lost()) return again;
    const auto fresh = std::find_if(waiting_.begin(), waiting_.end(), [&](const Exchange& e) {
        const auto at = may_start_at(e);
        return at && *at <= now;
    });
    return fresh == waiting_.end() ? nullptr : &*fresh;
}

// std::nullopt: not before a request that was sent has ended.
std::optional<TimePoint> Device::may_start_at(const Exchange& exchange) const noexcept {
    const bool is_blocked = std::any_of(sent_.begin(), sent_.end(), [&](const Exchange& e) {
        return e.expects() == exchange.expects() || (e.expects().is_alone() && exchange.expects().is_alone());
    });
    if (is_blocked) return std::nullopt;
    TimePoint at = TimePoint::min();
    if (!exchange.is_once()) return at;
    for (const auto& past : past_)
        if (past && !past->answered && past->expects == exchange.expects()) at = std::max(at, past->late_until);
    return at;
}

FrameView Device::send(Exchanges& from, Exchanges::iterator which, TimePoint now) noexcept {
    if (!which->was_sent()) sent_.splice(sent_.end(), from, which);
    which->send(now, round_trip_);
    return which->frame();
}

std::optional<TimePoint> Device::due() const noexcept {
    std::optional<TimePoint> first;
    if (on_their_way() < window_.size()) {
        if (lost() != nullptr) return TimePoint::min();
        for (const Exchange& exchange : waiting_)
            if (const auto at = may_start_at(exchange)) first = std::min(first.value_or(TimePoint::max()), *at);
    }
    for (const Exchange& exchange : sent_)
        if (exchange.is_on_its_way()) first = std::min(first.value_or(TimePoint::max()), exchange.due());
    return first;
}

}    // namespace ano::host
